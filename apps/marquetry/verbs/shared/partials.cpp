#include "verbs/shared/partials.h"

#include <fmt/format.h>

#include <algorithm>

#include "verbs/shared/input_pictures.h"
#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/draw/photograph.h"
#include "mq/filter/modulation.h"
#include "mq/image/colour.h"
#include "mq/io/cameras.h"
#include "mq/io/image_file.h"

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

/// Takes the last channel out of a picture.
Image<float> split_alpha(Texture& texture) {
  Image<float>& pixels = texture.pixels;
  Image<float> alpha(pixels.width(), pixels.height(), 1);
  Image<float> rest(pixels.width(), pixels.height(), pixels.channels() - 1);
  for (int y = 0; y < pixels.height(); ++y)
    for (int x = 0; x < pixels.width(); ++x) {
      alpha(x, y) = pixels.pixel(x, y).back();
      std::copy_n(pixels.pixel(x, y).begin(), rest.channels(), rest.pixel(x, y).begin());
    }
  pixels = std::move(rest);
  return alpha;
}

bool has_alpha(const Texture& texture) {
  return colour_channels(texture.pixels.channels()) < texture.pixels.channels();
}

/// The colours of a picture as `wanted` stores them, display values or light.
void restore(Texture& picture, TransferFunction wanted) {
  const TransferFunction found = transfer(picture);
  if (found == wanted) return;
  picture.pixels =
      encode(decode(picture.pixels, ColourSpace::linear, found), ColourSpace::linear, wanted);
}

/// How all textures of the model store colours.
TransferFunction common_transfer(const Model& model) {
  for (std::size_t i = 1; i < model.textures.size(); ++i)
    require(transfer(model.textures[i]) == transfer(model.textures[0]),
            fmt::format("--space stored: {} and {} do not store colours alike (light in floating "
                        "point, display values otherwise), so a photograph cannot fit both: choose "
                        "--space linear or log",
                        texture_file(model, 0), texture_file(model, i)));
  return transfer(model.textures.at(0));
}

/// The camera of a photograph for its file as it is, which may have been made smaller or larger as
/// a whole since the camera was found.
PinholeCamera camera_of_size(const Photograph& photograph, int width, int height) {
  const PinholeCamera& camera = photograph.camera;
  try {
    return scaled(camera, width, height);
  } catch (const InvalidInput&) {
    throw InvalidInput(fmt::format(
        "{}: is {} × {}, and its camera is of pictures of {} × {}: wanted that size, or another of "
        "the same proportions; has it been cropped or turned since?",
        photograph.picture.string(), width, height, camera.width, camera.height));
  }
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
  table.add({.name = "views",
             .type = Type::path,
             .count = Option::Count::many,
             .group = "Regions",
             .help = "photographs with their cameras: JSON, or a folder of COLMAP's text export",
             .details =
                 "The texture is made of them; where the model has no picture it gets one of "
                 "1024 × 1024."});
  table.add({.name = "steepest",
             .type = Type::number,
             .default_value = "75",
             .unit = "degrees",
             .least = 1,
             .most = 90,
             .group = "Regions",
             .help = "from the normal, beyond which a view shows nothing"});
  table.add({.name = "bias",
             .type = Type::number,
             .default_value = "0.1",
             .unit = "%",
             .least = 0,
             .most = 100,
             .group = "Regions",
             .help =
                 "of the model's diagonal: what is so close in front of a point does not hide it "
                 "from a view"});
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
  for (const std::string& file : options.texts("views"))
    for (const Photograph& photograph : read_cameras(file)) {
      const PictureInfo info = picture_info(photograph.picture);
      camera_of_size(photograph, info.width, info.height);
    }
}

void add_missing_pictures(TexturedModel& scene) {
  std::vector<Texture>& textures = scene.model.textures;
  textures.resize(std::max(textures.size(), scene.texture_sizes.size()));
  for (std::size_t k = 0; k < scene.texture_sizes.size(); ++k) {
    if (!textures[k].pixels.empty()) continue;
    textures[k].pixels =
        Image<float>(scene.texture_sizes[k].width, scene.texture_sizes[k].height, 3);
    textures[k].format.file_format = "png";
  }
}

namespace {

/// A photograph in the values and channels of the target; grey is spread over three.
Image<float> photograph_values(const Texture& texture, const ValueSpace& space, int channels) {
  const Image<float> values = decoded(texture, space);
  const int colours = colour_channels(values.channels()), wanted = colour_channels(channels);
  require(colours == wanted || colours == 1,
          fmt::format("{}: has {}, and the texture {}: convert it", texture.path.string(),
                      counted(colours, "colour channel"), wanted));
  const bool alpha = colours < values.channels();
  Image<float> result(values.width(), values.height(), wanted + (alpha ? 1 : 0));
  for (int y = 0; y < values.height(); ++y)
    for (int x = 0; x < values.width(); ++x) {
      for (int c = 0; c < wanted; ++c) result(x, y, c) = values(x, y, colours == 1 ? 0 : c);
      if (alpha) result(x, y, wanted) = values(x, y, colours);
    }
  return result;
}

/// With the alpha that the target may have: 1.
Signal widened(const Signal& values, int channels) {
  Signal result = Signal::Ones(values.rows(), channels);
  result.leftCols(values.cols()) = values;
  return result;
}

std::vector<Partial> project_views(Run& run, const TexturedModel& scene, const TextureSignal& target,
                                   const Progress& progress) {
  const OptionValues& options = run.options();
  std::vector<Photograph> photographs;
  for (const std::string& file : options.texts("views"))
    for (Photograph& photograph : read_cameras(file)) photographs.push_back(std::move(photograph));
  for (const Photograph& photograph : photographs) run.will_read(photograph.picture);
  const Projector projector(scene.surface, target.space().positions(), scene.atlas->texel_spacing(),
                            progress.step("places", 0.3));
  PhotographOptions projecting;
  projecting.steepest = options.number("steepest");
  projecting.bias = options.number("bias") / 100;
  std::vector<Partial> partials;
  const ValueSpace space = value_space(options);
  const bool stored = space.space == ColourSpace::stored;
  const TransferFunction wanted = stored ? common_transfer(scene.model) : TransferFunction::linear;
  Json views = Json::array();
  for (const Photograph& photograph : photographs) {
    const std::string name = photograph.picture.filename().string();
    Texture texture = read_texture(photograph.picture);
    if (stored) restore(texture, wanted);
    const Image<float> values = photograph_values(texture, space, target.channels());
    const PinholeCamera camera = camera_of_size(photograph, values.width(), values.height());
    if (camera.width != photograph.camera.width || camera.height != photograph.camera.height)
      run.terminal().remark(fmt::format(
          "{}: is {} × {}, and its camera is of pictures of {} × {}: it is taken for the same "
          "picture at another size",
          photograph.picture.string(), camera.width, camera.height, photograph.camera.width,
          photograph.camera.height));
    Partial partial = projector.project(camera, values, projecting,
                                        progress.step(name, 0.7 / double(photographs.size())));
    partial.values = widened(partial.values, target.channels());
    const auto shown = std::ranges::count_if(partial.confidence, [](double c) { return c > 0; });
    views.push_back({{"picture", photograph.picture.string()}, {"texels", shown}});
    if (shown == 0)
      run.terminal().warning(photograph.picture.string() +
                             ": shows nothing of the model: check its camera");
    partials.push_back(std::move(partial));
  }
  run.result["views"] = views;
  return partials;
}

}  // namespace

std::vector<Partial> read_partials(Run& run, const TexturedModel& scene, const TextureSignal& target,
                                   const Progress& progress) {
  if (has_views(run.options())) return project_views(run, scene, target, progress);
  const std::vector<std::string> files = run.options().texts("partial");
  const std::vector<std::string> confidences = run.options().texts("confidence");
  const std::size_t count = scene.texture_sizes.size();
  const bool stored = value_space(run.options()).space == ColourSpace::stored;
  std::vector<Partial> partials;
  for (std::size_t first = 0; first < files.size(); first += count) {
    std::vector<Texture> textures = read_pictures(files, first, scene);
    std::vector<Image<float>> shown;
    for (std::size_t i = 0; i < count; ++i) {
      require(!confidences.empty() || has_alpha(textures[i]),
              files[first + i] +
                  ": --partial: has no alpha channel to tell what it shows; give "
                  "--confidence pictures");
      Image<float> alpha;
      const bool surplus = textures[i].pixels.channels() == target.channels() + 1;
      if (has_alpha(textures[i]) && (confidences.empty() || surplus))
        alpha = split_alpha(textures[i]);
      if (stored) restore(textures[i], transfer(scene.model.textures[i]));
      shown.push_back(confidences.empty() ? alpha : read_texture(confidences[first + i]).pixels);
    }
    const Texels& texels = target.space().texels();
    partials.push_back(
        {target.values_of(textures), mask_of_pictures(texels, scene.texture_sizes, shown)});
  }
  return partials;
}

std::vector<int> asked_photographs(const OptionValues& options, const TexturedModel& scene,
                                   const TexelSpace& space, int count) {
  require(!options.has("unseen"),
          "--unseen is a label of regions: where photographs are given too, the labels are their "
          "numbers, and transparent where the one that shows it best is taken");
  std::vector<Image<float>> pictures;
  std::vector<double> steps;
  for (const std::string& file : options.texts("labels")) {
    const Texture texture = read_texture(file);
    require(
        texture.format.file_format != "jpeg" &&
            (texture.format.depth == Depth::u8 || texture.format.depth == Depth::u16),
        file +
            ": --labels: the numbers of photographs want whole numbers kept exactly: save it as "
            "PNG");
    steps.push_back(texture.format.depth == Depth::u8 ? 255 : 65535);
    pictures.push_back(texture.pixels);
  }
  const std::vector<int> numbers =
      numbers_of_pictures(space.texels(), scene.texture_sizes, pictures, steps);
  for (std::size_t i = 0; i < numbers.size(); ++i)
    require(numbers[i] < count,
            fmt::format("{}: --labels: found the number {} at column {}, row {}, and there are {}, "
                        "counted from 0",
                        options.texts("labels")[std::size_t(space.texels().places[i].texture)],
                        numbers[i], space.texels().places[i].x, space.texels().places[i].y,
                        counted(count, "photograph")));
  return numbers;
}

}  // namespace mq::app
