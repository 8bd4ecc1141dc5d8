#include "mq/model/detail/source_colours.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "mq/base/error.h"
#include "mq/image/colour.h"
#include "mq/image/resample.h"
#include "mq/io/slots.h"
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

SourceColours::SourceColours(const Model& model, const Mesh& mesh, const ValueSpace& values,
                             const BakeOptions& options)
    : model_(model), mesh_(mesh), space_(values.space) {
  bool is_textured = false;
  for (int t = 0; t < mesh.triangle_count() && !is_textured; ++t)
    is_textured = shown_texture(model, t) >= 0;
  read_vertices(options);
  if (is_textured) read_textures(values);
  if (is_textured || model.colors.channels == 0) read_materials(options.factors);
  const auto shows = [](const auto& bare) { return bare.has_value(); };
  require(is_textured || model.colors.channels > 0 || std::ranges::any_of(bare_, shows),
          model.path.string() + ": has neither textures nor colours at vertices or of materials, so nothing to bake");
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
    is_light_ = holds_light(texture.format) && texture.meaning == TextureMeaning::colours;
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

void SourceColours::read_materials(BakeOptions::Factors factors) {
  materials_ = file_materials(model_);
  const std::string slot = model_.slot.empty() ? base_slot : model_.slot;
  const bool applied = factors != BakeOptions::Factors::apart;
  tints_ = applied && slot == base_slot && model_.colors.is_light && model_.colors.channels >= 3;
  const double one = to_space(1);
  for (const Material& material : materials_.materials) {
    SlotFactor factor = slot_factor(material, slot);
    if (factors == BakeOptions::Factors::applied_but_alpha) factor.factor[3] = 1;
    if (applied) factors_.push_back(factor);
    bare_.emplace_back();
    if (material.names_picture(slot) || factor.kind == SlotFactor::Kind::unknown) continue;
    bare_.back() = {one, one, one, 1};
    if (factor.kind == SlotFactor::Kind::normals) bare_.back() = {0.5, 0.5, 1, 1};
    if (factor.kind == SlotFactor::Kind::light || factor.kind == SlotFactor::Kind::values)
      for (std::size_t c = 0; c < 4; ++c)
        if (factor.factor[c] == 0) (*bare_.back())[c] = 0;
    const bool adds_alpha = applied && slot == base_slot && factor.factor[3] != 1;
    if (adds_alpha && !has_alpha(channels_)) ++channels_;
  }
}

double SourceColours::to_light(double value) const {
  if (space_ == ColourSpace::log) return linear_from_log(value);
  const bool is_displayed = space_ == ColourSpace::stored && transfer_ == TransferFunction::srgb;
  return is_displayed ? linear_from_srgb(value) : value;
}

double SourceColours::to_space(double light) const {
  if (space_ == ColourSpace::log) return log_from_linear(light);
  const bool is_displayed = space_ == ColourSpace::stored && transfer_ == TransferFunction::srgb;
  return is_displayed ? srgb_from_linear(light) : light;
}

/// Grey is the mean of colours.
void SourceColours::fill(const std::array<double, 4>& colour, std::span<double> values) const {
  const int colours = colour_channels(channels_);
  for (int c = 0; c < colours; ++c) values[std::size_t(c)] = c < 3 ? colour[std::size_t(c)] : 1;
  if (colours == 1) values[0] = (colour[0] + colour[1] + colour[2]) / 3;
  if (has_alpha(channels_)) values[std::size_t(colours)] = colour[3];
}

void SourceColours::multiply(const SlotFactor& by, std::span<double> values) const {
  using Kind = SlotFactor::Kind;
  const int colours = colour_channels(channels_);
  for (int c = 0; c < std::min(colours, 3); ++c) {
    double& v = values[std::size_t(c)];
    const double f = colours == 1 && by.kind == Kind::light ? (by.factor[0] + by.factor[1] + by.factor[2]) / 3
                                                            : by.factor[std::size_t(c)];
    if (f == 1) continue;
    if (by.kind == Kind::light) v = to_space(f * to_light(v));
    if (by.kind == Kind::values) v *= f;
    if (by.kind == Kind::towards_1) v = 1 + f * (v - 1);
    if (by.kind == Kind::normals) v = 0.5 + f * (v - 0.5);
  }
  if (has_alpha(channels_)) values[std::size_t(colours)] *= by.factor[3];
}

void SourceColours::read_vertices(const BakeOptions& options) {
  const bool is_float = model_.colors.depth == Depth::f32 || model_.colors.depth == Depth::half;
  is_light_ = model_.colors.is_light && is_float && options.float_colours == BakeOptions::FloatColours::light;
  colours_ = is_light_ ? model_.colors : as_displayed(model_.colors);
  if (model_.colors.is_light && is_float && !is_light_) colours_.depth = Depth::u16;
  channels_ = colours_.channels > 0 ? colours_.channels : 3;
  depth_ = colours_.depth;
  spacing_ = std::sqrt(total_area(mesh_) / std::max(1, mesh_.vertex_count()));
}

bool SourceColours::at(const SurfacePoint& point, std::span<double> values) const {
  if (pictures_.empty() && colours_.channels > 0) {
    const Triangle& corners = mesh_.triangles[std::size_t(point.triangle)];
    for (int c = 0; c < channels_; ++c)
      values[std::size_t(c)] = interpolate(point.barycentric, [&](int k) {
        return double(colours_.values[std::size_t(corners[k]) * std::size_t(channels_) + std::size_t(c)]);
      });
    return true;
  }
  const int texture = shown_texture(model_, point.triangle);
  const int material =
      materials_.of_triangle.empty() ? -1 : materials_.of_triangle[std::size_t(point.triangle)];
  const bool is_bare = texture < 0;
  if (is_bare && (material < 0 || !bare_[std::size_t(material)])) return false;
  if (is_bare)
    fill(*bare_[std::size_t(material)], values);
  else
    look_up(texture, point, values);
  if (material >= 0 && !factors_.empty()) multiply(factors_[std::size_t(material)], values);
  if (tints_) multiply(tint_at(point), values);
  return true;
}

/// What glTF multiplies the base colour by: the colours at vertices, light.
SlotFactor SourceColours::tint_at(const SurfacePoint& point) const {
  const Triangle& corners = mesh_.triangles[std::size_t(point.triangle)];
  SlotFactor tint{SlotFactor::Kind::light, {1, 1, 1, 1}};
  const int own = model_.colors.channels;
  for (int c = 0; c < std::min(own, 4); ++c)
    tint.factor[std::size_t(c)] = interpolate(point.barycentric, [&](int k) {
      return double(model_.colors.values[std::size_t(corners[k]) * std::size_t(own) + std::size_t(c)]);
    });
  return tint;
}

void SourceColours::look_up(int texture, const SurfacePoint& point, std::span<double> values) const {
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
}

}  // namespace mq
