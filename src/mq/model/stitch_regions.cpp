#include "mq/model/stitch_regions.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/base/words.h"
#include "mq/image/colour.h"

namespace mq {
namespace {

/// Regions of labels; what has more colours is a picture of something else.
constexpr std::int64_t most_regions = 4096;

/// The largest value that is stored.
double most_of(Depth depth) {
  if (depth == Depth::u8) return 255;
  return depth == Depth::u16 ? 65535 : 1;
}

/// As the pixels of the picture.
std::vector<float> as_pixel(const std::vector<double>& colour, const Texture& picture) {
  const int channels = colour_channels(picture.pixels.channels());
  require(colour.size() == 1 || std::ssize(colour) == channels,
          fmt::format("{}: has {}: {} wants one value, or as many, and found {}",
                      picture.path.string(), counted(channels, "colour channel"),
                      option_name("unseen"), fmt::join(colour, ",")));
  std::vector<float> pixel;
  for (int c = 0; c < channels; ++c)
    pixel.push_back(
        float(colour[colour.size() == 1 ? 0 : std::size_t(c)] / most_of(picture.format.depth)));
  return pixel;
}

}  // namespace

void require_exact(const Texture& picture) {
  require(picture.format.file_format != "jpeg",
          fmt::format("{}: {}: JPEG does not keep colours exactly, so that regions cannot be told "
                      "apart: save it as PNG",
                      picture.path.string(), option_name("labels")));
}

std::int64_t StitchRegions::count() const {
  std::set<int> regions(labels.begin(), labels.end());
  regions.erase(unseen);
  return std::ssize(regions);
}

std::int64_t StitchRegions::count_unseen() const { return std::ranges::count(labels, unseen); }

StitchRegions regions_of_labels(const TexturedModel& model, const TextureSignal& signal,
                                std::span<const Texture> labels,
                                const std::optional<std::vector<double>>& unseen_colour,
                                Messages& messages) {
  const Texels& texels = signal.space().texels();
  if (labels.empty()) return {.values = signal.values(), .labels = texels.chart};
  std::vector<Image<float>> pictures;
  std::optional<std::vector<float>> unseen_pixel;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const Texture& picture = labels[i];
    require_exact(picture);
    if (unseen_colour) unseen_pixel = as_pixel(*unseen_colour, picture);
    const int width = picture.pixels.width(), height = picture.pixels.height();
    if (i < model.texture_sizes.size())
      if (const TextureSize& size = model.texture_sizes[i];
          width != size.width || height != size.height)
        messages.remark(
            fmt::format("{}: {} × {} pixels, where the texture has {} × {}: each texel "
                        "takes the nearest one's label",
                        picture.path.string(), width, height, size.width, size.height));
    pictures.push_back(picture.pixels);
  }
  StitchRegions regions{.values = signal.values(),
                        .labels = labels_of_pictures(texels, model.texture_sizes, pictures, unseen_pixel)};
  require_labels(labels[0].path, regions.count());
  return regions;
}

void require_labels(const std::filesystem::path& picture, std::int64_t regions) {
  require(regions <= most_regions,
          fmt::format("{}: {}: found {} colours, and each would be a region (wanted {} at most): a picture of labels has "
                      "a colour for each photograph, and no shades between them",
                      picture.string(), option_name("labels"), regions, most_regions));
}

StitchRegions regions_of_photographs(std::vector<Partial> photographs,
                                     std::span<const int> wanted) {
  Composite composite = best_of(photographs, wanted);
  return {.values = std::move(composite.values),
          .labels = std::move(composite.labels),
          .partials = std::move(photographs)};
}

std::vector<int> wanted_photographs(const TextureSignal& signal,
                                    std::span<const TextureSize> textures,
                                    std::span<const Texture> labels, int count) {
  std::vector<Image<float>> pictures;
  std::vector<double> steps;
  for (const Texture& picture : labels) {
    const Depth depth = picture.format.depth;
    require(
        picture.format.file_format != "jpeg" && (depth == Depth::u8 || depth == Depth::u16),
        fmt::format("{}: {}: the numbers of photographs want whole numbers kept exactly: save it "
                    "as PNG",
                    picture.path.string(), option_name("labels")));
    steps.push_back(most_of(depth));
    pictures.push_back(picture.pixels);
  }
  const Texels& texels = signal.space().texels();
  std::vector<int> numbers = numbers_of_pictures(texels, textures, pictures, steps);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const Texels::Place& at = texels.places[i];
    require(numbers[i] < count,
            fmt::format(
                "{}: {}: found the number {} for the texel in column {}, row {}, and there are {}, "
                "counted from 0",
                labels[std::size_t(at.texture)].path.string(), option_name("labels"), numbers[i],
                at.x, at.y, counted(count, "photograph")));
  }
  return numbers;
}

}  // namespace mq
