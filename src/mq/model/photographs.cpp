#include "mq/model/photographs.h"

#include <fmt/format.h>

#include <algorithm>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/base/words.h"
#include "mq/filter/modulation.h"
#include "mq/image/colour.h"
#include "mq/io/image_file.h"
#include "mq/io/photograph_file.h"

namespace mq {
namespace {

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

/// The colours of a picture as `wanted` stores them, display values or light.
void restore(Texture& picture, TransferFunction wanted) {
  const TransferFunction found = transfer(picture);
  if (found == wanted) return;
  picture.pixels =
      encode(decode(picture.pixels, ColourSpace::linear, found), ColourSpace::linear, wanted);
}

/// A photograph in the values and channels of the signal; grey is spread over three.
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

/// With the alpha that the signal may have: 1.
Signal widened(const Signal& values, int channels) {
  Signal result = Signal::Ones(values.rows(), channels);
  result.leftCols(values.cols()) = values;
  return result;
}

bool works_on_stored(const TextureSignal& signal) {
  return signal.value_space().space == ColourSpace::stored;
}

}  // namespace

TransferFunction common_transfer(const Model& model) {
  for (std::size_t i = 1; i < model.textures.size(); ++i)
    require(
        transfer(model.textures[i]) == transfer(model.textures[0]),
        fmt::format("{} and {} do not store colours alike (light in floating point, display values "
                    "otherwise), so a photograph cannot fit both: choose {} linear or log",
                    texture_file(model, 0), texture_file(model, i), option_name("space")));
  return transfer(model.textures.at(0));
}

Partial partial_of_textures(const TexturedModel& model, const TextureSignal& signal,
                            std::vector<Texture> textures,
                            std::span<const Image<float>> confidence) {
  require(textures.size() == model.texture_sizes.size() &&
              (confidence.empty() || confidence.size() == textures.size()),
          fmt::format("a photograph of {} for a model of {}: give one each, and as many of "
                      "confidence",
                      counted(std::ssize(textures), "picture"),
                      counted(std::ssize(model.texture_sizes), "texture")));
  std::vector<Image<float>> shown;
  for (std::size_t i = 0; i < textures.size(); ++i) {
    require(
        !confidence.empty() || has_alpha(textures[i].pixels.channels()),
        fmt::format("{}: {}: has no alpha channel to tell what it shows; give {} pictures",
                    textures[i].path.string(), option_name("partial"), option_name("confidence")));
    Image<float> alpha;
    const bool surplus = textures[i].pixels.channels() == signal.channels() + 1;
    if (has_alpha(textures[i].pixels.channels()) && (confidence.empty() || surplus))
      alpha = split_alpha(textures[i]);
    if (works_on_stored(signal)) restore(textures[i], transfer(model.model.textures[i]));
    shown.push_back(confidence.empty() ? std::move(alpha) : confidence[i]);
  }
  return {signal.values_of(textures),
          mask_of_pictures(signal.space().texels(), model.texture_sizes, shown)};
}

std::vector<Partial> partials_of_photographs(const TexturedModel& model,
                                             const TextureSignal& signal,
                                             std::span<const Photograph> photographs,
                                             const PhotographOptions& options, Messages& messages,
                                             const Progress& progress) {
  const Projector projector(model.surface, signal.space().positions(), model.atlas->texel_spacing(),
                            progress.step("places", 0.3));
  const bool stored = works_on_stored(signal);
  const TransferFunction wanted = stored ? common_transfer(model.model) : TransferFunction::linear;
  std::vector<Partial> partials;
  for (const Photograph& photograph : photographs) {
    const std::string file = photograph.picture.string();
    const FittedCamera fitted = fitted_camera(photograph, picture_info(photograph.picture));
    Texture texture = read_photograph(photograph, fitted.turn);
    if (stored) restore(texture, wanted);
    const Image<float> values = photograph_values(texture, signal.value_space(), signal.channels());
    const PinholeCamera& camera = fitted.camera;
    if (const std::string remark = remark_on_size(photograph, camera); !remark.empty()) messages.remark(remark);
    Partial partial = projector.project(
        camera, values, options,
        progress.step(photograph.picture.filename().string(), 0.7 / double(photographs.size())));
    partial.values = widened(partial.values, signal.channels());
    if (shown_unknowns(partial) == 0)
      messages.warning(file + ": shows nothing of the model: check its camera");
    partials.push_back(std::move(partial));
  }
  return partials;
}

std::string remark_on_size(const Photograph& photograph, const PinholeCamera& fitted) {
  const PinholeCamera& camera = photograph.camera;
  if (fitted.width == camera.width && fitted.height == camera.height) return {};
  return fmt::format(
      "{}: is {} × {}, and its camera is of pictures of {} × {}: it is taken for the same picture at another size",
      photograph.picture.string(), fitted.width, fitted.height, camera.width, camera.height);
}

std::int64_t shown_unknowns(const Partial& partial) {
  return std::ranges::count_if(partial.confidence, [](double c) { return c > 0; });
}

void add_missing_pictures(TexturedModel& model) {
  std::vector<Texture>& textures = model.model.textures;
  textures.resize(std::max(textures.size(), model.texture_sizes.size()));
  for (std::size_t k = 0; k < model.texture_sizes.size(); ++k) {
    if (!textures[k].pixels.empty()) continue;
    textures[k].pixels =
        Image<float>(model.texture_sizes[k].width, model.texture_sizes[k].height, 3);
    textures[k].format.file_format = "png";
  }
}

}  // namespace mq
