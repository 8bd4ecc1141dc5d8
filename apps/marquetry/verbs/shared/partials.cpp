#include "verbs/shared/partials.h"

#include <fmt/format.h>

#include <algorithm>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/io/image_file.h"
#include "mq/model/photographs.h"
#include "mq/model/stitch_regions.h"
#include "shell/arguments.h"
#include "verbs/shared/input_pictures.h"

namespace mq::app {
namespace {

/// Pictures of one partial texture: files [first, first + count).
std::vector<Texture> read_pictures(const std::vector<std::string>& files, std::size_t first,
                                   const TexturedModel& scene) {
  std::vector<Texture> textures;
  for (std::size_t i = 0; i < scene.texture_sizes.size(); ++i) {
    textures.push_back(read_texture(files[first + i]));
    const Image<float>& picture = textures.back().pixels;
    require_size(files[first + i], picture.width(), picture.height(), scene, i);
  }
  return textures;
}

}  // namespace

void add_partial_options(OptionTable& table) {
  using Type = Option::Type;
  table.add({.name = "partial",
             .type = Type::path,
             .count = Option::Count::many,
             .group = "Regions",
             .help = "a photograph as a texture of its own, of the texture's size",
             .details =
                 "Each texel is taken from the one that shows it best. With several textures "
                 "the first photograph's pictures of all of them come first."});
  table.add({.name = "confidence",
             .type = Type::path,
             .count = Option::Count::many,
             .group = "Regions",
             .help = "for each of them how well it shows each texel: black not at all",
             .details = "Without it, by their alpha channels."});
}

bool has_partials(const OptionValues& options) { return !options.texts("partial").empty(); }

void check_partials(const OptionValues& options, const TexturedModel& scene) {
  using Count = InputPictures::Count;
  check_pictures(options, scene,
                 {"partial", Count::many_sets, InputPictures::Size::of_the_texture});
  const std::size_t partials = options.texts("partial").size(),
                    confidences = options.texts("confidence").size();
  require(
      confidences == 0 || confidences == partials,
      fmt::format("--confidence: found {} for {} of --partial: give one for each, in their order",
                  counted(std::int64_t(confidences), "picture"),
                  counted(std::int64_t(partials), "picture")));
  check_pictures(options, scene, {"confidence", Count::many_sets});
  require(
      !has_partials(options) || !options.has("unseen"),
      "--unseen is a label of regions: where photographs are given, the labels are their numbers, "
      "and transparent where the one that shows it best is taken");
}

std::vector<Partial> read_partials(const OptionValues& options, const TexturedModel& scene,
                                   const TextureSignal& target) {
  const std::vector<std::string> files = options.texts("partial");
  const std::vector<std::string> confidences = options.texts("confidence");
  const std::size_t count = scene.texture_sizes.size();
  std::vector<Partial> partials;
  for (std::size_t first = 0; first < files.size(); first += count) {
    std::vector<Texture> textures = read_pictures(files, first, scene);
    std::vector<Image<float>> shown;
    for (std::size_t i = 0; i < count && !confidences.empty(); ++i)
      shown.push_back(read_texture(confidences[first + i]).pixels);
    partials.push_back(partial_of_textures(scene, target, std::move(textures), shown));
  }
  return partials;
}

std::vector<Texture> read_labels(const OptionValues& options) {
  std::vector<Texture> labels;
  for (const std::string& file : options.texts("labels")) labels.push_back(read_texture(file));
  return labels;
}

std::vector<int> asked_photographs(const OptionValues& options, const TexturedModel& scene,
                                   const TextureSignal& target, int count) {
  return wanted_photographs(target, scene.texture_sizes, read_labels(options), count);
}

void add_labels_option(OptionTable& table) {
  table.add({.name = "labels",
             .type = Option::Type::path,
             .count = Option::Count::many,
             .group = "Regions",
             .help = "a picture per texture: texels of one colour come from one photograph",
             .details =
                 "Taken at the nearest pixel, transparent ones are unseen. Without it every "
                 "chart is a region. With --partial its first channel is the "
                 "number, from 0, of the photograph that each texel comes from; where that "
                 "does not show it, and where labels are transparent, the one that does best "
                 "is taken."});
}

void add_borders_option(OptionTable& table) {
  table.add({.name = "borders",
             .type = Option::Type::choice,
             .default_value = "continued",
             .choices = {"continued", "level", "published"},
             .group = "Stitch",
             .help = "continued: each region goes on past its border as it runs there; level: no differences are asked for "
                     "there; published: nor where nothing is seen, which level refuses",
             .details = "What slopes across a border becomes flat there by the last two. published, with --alpha 0.01 and "
                        "--exposure keep, is the thesis' stitching: texels that nobody sees keep the colours they have, "
                        "of several photographs the mean, and lose their differences."});
}

void add_levels_option(OptionTable& table) {
  table.add({.name = "exposure",
             .type = Option::Type::choice,
             .default_value = "match",
             .choices = {"match", "keep"},
             .metavar = "HOW",
             .group = "Stitch",
             .help = "even out exposure and white balance of regions first, or keep them",
             .details = "One gain for each region and channel, of the steps that most of each border shows."});
}

RegionLevels asked_levels(const OptionValues& options, const Model& model, const Stitcher& stitcher, const Signal& psi) {
  const auto law = light_law(model.textures, value_space(options));
  return law && options.text("exposure") == "match" ? stitcher.levels(psi, *law) : RegionLevels();
}

}  // namespace mq::app
