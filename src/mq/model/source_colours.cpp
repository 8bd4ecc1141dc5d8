#include "mq/model/detail/source_colours.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "mq/base/error.h"
#include "mq/image/colour.h"
#include "mq/image/resample.h"
#include "mq/io/vertex_colours.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

constexpr int most_channels = 64;

double area_in_texels(const Mesh& mesh, int t, const Image<float>& picture) {
  return std::abs(cross(mesh.uv(t, 1) - mesh.uv(t, 0), mesh.uv(t, 2) - mesh.uv(t, 0))) / 2 *
         picture.width() * picture.height();
}

/// The channels that hold both.
int joined_channels(int a, int b) {
  return std::max(colour_channels(a), colour_channels(b)) + (has_alpha(a) || has_alpha(b) ? 1 : 0);
}

}  // namespace

SourceColours::SourceColours(const Model& model, const Mesh& mesh, const ValueSpace& values)
    : model_(model), mesh_(mesh) {
  bool is_textured = false;
  for (int t = 0; t < mesh.triangle_count() && !is_textured; ++t)
    is_textured = shown_texture(model, t) >= 0;
  require(
      is_textured || model.colors.channels > 0,
      model.path.string() + ": has neither textures nor colours at vertices, so nothing to bake");
  if (is_textured)
    read_textures(values);
  else
    read_vertices();
}

void SourceColours::read_textures(const ValueSpace& values) {
  std::vector<char> is_shown(model_.textures.size(), 0);
  double texels = 0, area = 0;
  for (int t = 0; t < mesh_.triangle_count(); ++t) {
    const int texture = shown_texture(model_, t);
    if (texture < 0) continue;
    is_shown[std::size_t(texture)] = 1;
    texels += area_in_texels(mesh_, t, model_.textures[std::size_t(texture)].pixels);
    area += triangle_area(mesh_, t);
  }
  spacing_ = texels > 0 ? std::sqrt(area / texels) : 0;
  pictures_.resize(model_.textures.size());
  bool is_first = true;
  for (std::size_t i = 0; i < pictures_.size(); ++i) {
    if (!is_shown[i]) continue;
    const Texture& texture = model_.textures[i];
    const TransferFunction own = mq::transfer(texture);
    require(is_first || own == transfer_,
            fmt::format(
                "{}: its textures do not store colours alike, some light (floating point), some "
                "display values: convert {}",
                model_.path.string(), texture_file(model_, i)));
    transfer_ = own;
    depth_ = is_first ? texture.format.depth : std::max(depth_, texture.format.depth);
    channels_ = is_first ? texture.pixels.channels()
                         : joined_channels(channels_, texture.pixels.channels());
    pictures_[i] = decoded(texture, values);
    is_first = false;
  }
  require(channels_ <= most_channels,
          fmt::format("{}: a texture has {} channels, at most {} can be baked",
                      model_.path.string(), channels_, most_channels));
}

void SourceColours::read_vertices() {
  channels_ = model_.colors.channels;
  depth_ = model_.colors.depth;
  spacing_ = std::sqrt(total_area(mesh_) / std::max(1, mesh_.vertex_count()));
}

bool SourceColours::at(const SurfacePoint& point, std::span<double> values) const {
  if (pictures_.empty()) {
    const Triangle& corners = mesh_.triangles[std::size_t(point.triangle)];
    for (int c = 0; c < channels_; ++c)
      values[std::size_t(c)] = interpolate(point.barycentric, [&](int k) {
        return double(model_.colors.values[std::size_t(corners[k]) * std::size_t(channels_) +
                                           std::size_t(c)]);
      });
    return true;
  }
  const int texture = shown_texture(model_, point.triangle);
  if (texture < 0) return false;
  const Image<float>& picture = pictures_[std::size_t(texture)];
  const Vector2 uv =
      interpolate(point.barycentric, [&](int k) { return Vector2(mesh_.uv(point.triangle, k)); });
  std::array<float, most_channels> found;
  const std::size_t own = std::size_t(picture.channels());
  sample(picture, uv.x() * picture.width() - 0.5, (1 - uv.y()) * picture.height() - 0.5,
         model_.textures[std::size_t(texture)].wrap, std::span(found).first(own));
  const int colours = colour_channels(channels_), own_colours = colour_channels(int(own));
  for (int c = 0; c < colours; ++c)
    values[std::size_t(c)] =
        found[own_colours == 1 ? 0 : std::size_t(std::min(c, own_colours - 1))];
  if (has_alpha(channels_)) values[std::size_t(colours)] = has_alpha(int(own)) ? found[own - 1] : 1;
  return true;
}

}  // namespace mq
