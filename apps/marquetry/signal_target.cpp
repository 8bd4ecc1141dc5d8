#include "signal_target.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/image/normal_map.h"
#include "options/signal_options.h"

namespace mq::app {
namespace {

bool same_row(const Signal& a, const Signal& b, Eigen::Index row) {
  return (a.row(row).array() == b.row(row).array()).all();
}

/// Whether pictures with `channels` lack just the alpha of those with `most`.
bool lacks_alpha(int channels, int most) {
  return channels + 1 == most && colour_channels(most) != most;
}

/// How many channels all pictures have.
int common_channels(const Model& model) {
  int most = 0;
  for (const Texture& texture : model.textures) most = std::max(most, texture.pixels.channels());
  for (std::size_t i = 0; i < model.textures.size(); ++i) {
    const int channels = model.textures[i].pixels.channels();
    require(channels == most || lacks_alpha(channels, most),
            fmt::format("{}: has {} and another texture of the model {}: textures of one model are "
                        "processed together and must agree; convert one of them",
                        texture_file(model, i), counted(channels, "channel"), most));
  }
  return most;
}

Image<float> with_alpha(const Image<float>& picture, int channels) {
  Image<float> wider(picture.width(), picture.height(), channels, 1.0F);
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x)
      std::ranges::copy(picture.pixel(x, y), wider.pixel(x, y).begin());
  return wider;
}

}  // namespace

ValueSpace value_space(const OptionValues& options) {
  const auto has = [&](const std::string& name) {
    return std::ranges::any_of(options.table().options(),
                               [&](const Option& option) { return option.name == name; });
  };
  ValueSpace values;
  if (has("normals") && options.flag("normals")) values.meaning = ValueSpace::Meaning::normals;
  const std::string name = has("space") ? options.text("space") : "stored";
  values.space = name == "linear" ? ColourSpace::linear
                 : name == "log"  ? ColourSpace::log
                                  : ColourSpace::stored;
  return values;
}

TransferFunction transfer(const Texture& texture) {
  return holds_light(texture.format) ? TransferFunction::linear : TransferFunction::srgb;
}

Image<float> decoded(const Texture& texture, const ValueSpace& values) {
  if (values.meaning == ValueSpace::Meaning::normals) return normals_from_colours(texture.pixels);
  if (values.space == ColourSpace::stored) return texture.pixels;
  return decode(texture.pixels, values.space, transfer(texture));
}

Image<float> encoded(const Image<float>& picture, const Texture& texture,
                     const ValueSpace& values) {
  if (values.meaning == ValueSpace::Meaning::normals) return colours_from_normals(picture);
  if (values.space == ColourSpace::stored) return picture;
  return encode(picture, values.space, transfer(texture));
}

namespace {

/// The logarithm of light is a straight line below `log_threshold`: values there change by other
/// rules than the rest.
void warn_of_no_light(Run& run, const Model& model) {
  for (const Texture& texture : model.textures) {
    const auto negative =
        std::ranges::count_if(texture.pixels.values(), [](float v) { return v < 0; });
    if (negative > 0)
      run.terminal().warning(fmt::format(
          "{}: {} of {} values are below 0, where light has no logarithm, and may end "
          "far from where they are: --space log is for light; take --space linear or stored",
          texture.path.string(), negative, texture.pixels.values().size()));
  }
}

}  // namespace

TextureTarget::TextureTarget(Run& run, const Scene& scene, const ValueSpace& values,
                             const TexelSpaceOptions& space, const Progress& progress)
    : model_(scene.model),
      values_(values),
      channels_(common_channels(scene.model)),
      domain_(run, scene, space, progress) {
  if (values.meaning == ValueSpace::Meaning::normals && values.meets_at_seams)
    refuse_tangent_space(scene);
  if (values.space == ColourSpace::log) warn_of_no_light(run, scene.model);
}

/// The pictures in the values that are worked on. Not kept: on large textures they would stand
/// beside the solver's matrices.
std::vector<Image<float>> TextureTarget::pictures_of(std::span<const Texture> textures) const {
  std::vector<Image<float>> pictures;
  for (std::size_t i = 0; i < textures.size(); ++i) {
    const Image<float>& pixels = textures[i].pixels;
    require(pixels.channels() == channels_ || lacks_alpha(pixels.channels(), channels_),
            fmt::format("{}: has {}, and the textures of {} have {}; convert it",
                        textures[i].path.string(), counted(pixels.channels(), "channel"),
                        model_.path.string(), channels_));
    pictures.push_back(decoded(textures[i], values_));
    if (pixels.channels() != channels_) pictures.back() = with_alpha(pictures.back(), channels_);
  }
  return pictures;
}

Signal TextureTarget::values_of(std::span<const Texture> textures) const {
  return domain_.space().gather(pictures_of(textures));
}

void TextureTarget::put(const Signal& before, const Signal& after, Model& model) const {
  const TexelSpace& space = domain_.space();
  std::vector<Image<float>> pictures = pictures_of(model_.textures);
  space.scatter(after, pictures);
  for (std::size_t i = 0; i < pictures.size(); ++i)
    pictures[i] = encoded(pictures[i], model.textures[i], values_);
  for (int k = 0; k < space.size(); ++k) {
    if (same_row(before, after, k)) continue;
    const Texels::Place& place = space.texels().places[std::size_t(k)];
    const auto from = pictures[std::size_t(place.texture)].pixel(place.x, place.y);
    const auto to = model.textures[std::size_t(place.texture)].pixels.pixel(place.x, place.y);
    std::copy_n(from.begin(), to.size(), to.begin());
  }
}

/// On the two sides of a seam the same normal has different coordinates in tangent space.
void TextureTarget::refuse_tangent_space(const Scene& scene) const {
  if (scene.atlas->seam_count == 0) return;
  const std::vector<Image<float>> pictures = pictures_of(model_.textures);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    Image<float> coverage(pictures[i].width(), pictures[i].height(), 1);
    for (const Texels::Place& place : domain_.space().texels().places)
      if (std::size_t(place.texture) == i) coverage(place.x, place.y) = 1;
    const double upright = share_upright(pictures[i], coverage);
    require(upright < 0.9,
            fmt::format("{}: {:.0f} % of its normals point along z, so it seems to be in tangent "
                        "space, where the same normal has different values on the two sides of a "
                        "seam (there are {}): bake it in object space first",
                        texture_file(model_, i), 100 * upright, scene.atlas->seam_count));
  }
}

Signal VertexTarget::values_of(const VertexSignal& colors) const {
  const SignalSpace& space = domain_.space();
  Signal sum = Signal::Zero(space.size(), colors.channels);
  Vector copies = Vector::Zero(space.size());
  for (int v = 0; v < scene_.model.mesh.vertex_count(); ++v) {
    const int unknown = scene_.surface.vertex_from_source[std::size_t(v)];
    if (unknown < 0) continue;
    copies[unknown] += 1;
    for (int c = 0; c < colors.channels; ++c) {
      const float value = colors.values[std::size_t(v) * colors.channels + c];
      require(
          std::isfinite(value),
          fmt::format("{}: channel {} of the colour of vertex {} (counted from 0) is {}; it must "
                      "be finite",
                      scene_.model.path.string(), c, v, value));
      sum(unknown, c) += value;
    }
  }
  // A vertex split into fans has its source's colour in each; only one of them was counted.
  for (int u = 0; u < space.size(); ++u) {
    if (copies[u] > 0) {
      sum.row(u) /= copies[u];
      continue;
    }
    const int source = scene_.surface.source_from_vertex[std::size_t(u)];
    for (int c = 0; c < colors.channels; ++c)
      sum(u, c) = colors.values[std::size_t(source) * colors.channels + c];
  }
  return sum;
}

void VertexTarget::put(const Signal& before, const Signal& after, Model& model) const {
  VertexSignal& colors = model.colors;
  for (int v = 0; v < model.mesh.vertex_count(); ++v) {
    const int unknown = scene_.surface.vertex_from_source[std::size_t(v)];
    if (unknown < 0 || same_row(before, after, unknown)) continue;
    for (int c = 0; c < colors.channels; ++c)
      colors.values[std::size_t(v) * colors.channels + c] = float(after(unknown, c));
  }
}

std::unique_ptr<Target> make_target(Run& run, const Scene& scene, const Progress& progress) {
  std::unique_ptr<Target> target;
  about(scene.model, [&] {
    if (at_vertices(run.options(), scene))
      target = std::make_unique<VertexTarget>(scene);
    else
      target = std::make_unique<TextureTarget>(run, scene, value_space(run.options()), progress);
  });
  return target;
}

}  // namespace mq::app
