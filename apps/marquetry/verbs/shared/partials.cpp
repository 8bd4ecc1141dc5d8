#include "verbs/shared/partials.h"

#include <fmt/format.h>

#include <algorithm>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/io/cameras.h"
#include "mq/io/image_file.h"
#include "mq/io/photograph_file.h"
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

void add_sight_options(OptionTable& table, const std::string& group) {
  using Type = Option::Type;
  table.add({.name = "steepest",
             .type = Type::number,
             .default_value = as_typed(PhotographOptions{}.steepest),
             .unit = "degrees",
             .least = 1,
             .most = 90,
             .group = group,
             .help = "from the normal, beyond which a view shows nothing"});
  table.add({.name = "bias",
             .type = Type::number,
             .default_value = as_typed(100 * PhotographOptions{}.bias),
             .unit = "%",
             .least = 0,
             .most = 100,
             .group = group,
             .help =
                 "of the model's diagonal: what is so close in front of a point does not hide it "
                 "from a view"});
}

PhotographOptions asked_sight(const OptionValues& options) {
  return {.steepest = options.number("steepest"), .bias = options.number("bias") / 100};
}

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
  table.add({.name = "views",
             .type = Type::path,
             .count = Option::Count::many,
             .group = "Regions",
             .help = "photographs with their cameras: any file or folder that the verb cameras reads",
             .details =
                 "The texture is made of them; where the model has no picture it gets one of "
                 "1024 × 1024."});
  add_sight_options(table, "Regions");
}

bool has_views(const OptionValues& options) { return !options.texts("views").empty(); }

bool has_partials(const OptionValues& options) {
  return !options.texts("partial").empty() || has_views(options);
}

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
  for (const char* name : {"steepest", "bias"})
    require(has_views(options) || !asks_for(options, name),
            fmt::format("--{}: it is for photographs with cameras, which --views names", name));
  require(
      !has_partials(options) || !options.has("unseen"),
      "--unseen is a label of regions: where photographs are given, the labels are their numbers, "
      "and transparent where the one that shows it best is taken");
  for (const std::string& file : options.texts("views"))
    for (const Photograph& photograph : read_cameras(file)) {
      fitted_camera(photograph, picture_info(photograph.picture));
    }
}

namespace {

std::vector<Partial> read_views(Run& run, const TexturedModel& scene, const TextureSignal& target,
                                const Progress& progress) {
  const OptionValues& options = run.options();
  std::vector<Photograph> photographs;
  for (const std::string& file : options.texts("views"))
    for (Photograph& photograph : read_cameras(file)) photographs.push_back(std::move(photograph));
  for (const Photograph& photograph : photographs) run.will_read(photograph.picture);
  std::vector<Partial> partials = partials_of_photographs(
      scene, target, photographs,
      asked_sight(options),
      run.terminal(), progress);
  Json views = Json::array();
  for (std::size_t k = 0; k < partials.size(); ++k)
    views.push_back(
        {{"picture", photographs[k].picture.string()}, {"texels", shown_unknowns(partials[k])}});
  run.result["views"] = views;
  return partials;
}

}  // namespace

std::vector<Partial> read_partials(Run& run, const TexturedModel& scene,
                                   const TextureSignal& target, const Progress& progress) {
  if (has_views(run.options())) return read_views(run, scene, target, progress);
  const std::vector<std::string> files = run.options().texts("partial");
  const std::vector<std::string> confidences = run.options().texts("confidence");
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

}  // namespace mq::app
