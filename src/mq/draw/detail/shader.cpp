// Light is multiplied as light, not as displayed values, and scaled so that a surface that faces
// the viewer keeps its stored colour.

#include "mq/draw/detail/shader.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "mq/image/resample.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/surface_point.h"

namespace mq {
namespace {

/// A displayed value in `light` times the light; `power` is light^(1/2.4). With the curved part of
/// sRGB on both sides that is (v + 0.055) · power − 0.055, with the straight part v · light.
double brightened(double v, double light, double power) {
  const double curved = (v + 0.055) * power - 0.055, straight = v * light;
  if (light < 1) return std::max(curved, straight);
  return std::min({curved, straight, std::max(v, 1.0)});  // white stays white
}

}  // namespace

bool shows_numbers(const RenderOptions& options) {
  using Paint = RenderOptions::Paint;
  return options.paint == Paint::vertex_numbers || options.paint == Paint::texture_numbers;
}

/// Values of the texture where the ray hit; false where there is none.
bool Shader::texture_values(const Hit& hit, std::span<float> values) const {
  if (atlas == nullptr || atlas->chart[hit.triangle] < 0) return false;
  const auto& corners = atlas->corners[hit.triangle];
  const double column = interpolate(hit.barycentric, [&](int k) { return corners[k].column(); });
  const double row = interpolate(hit.barycentric, [&](int k) { return corners[k].row(); });
  const int texture = surface.mesh.texture(hit.triangle);
  sample(*paints.textures[texture], column, row, atlas->textures[texture].wrap, values);
  return true;
}

Colour Shader::textured(const Hit& hit) const {
  std::array<float, 16> values;
  if (atlas == nullptr || atlas->chart[hit.triangle] < 0) return clay;
  const int channels = paints.textures[surface.mesh.texture(hit.triangle)]->channels();
  if (!texture_values(hit, std::span(values).first(std::min(channels, 3)))) return clay;
  if (channels < 3) return {values[0], values[0], values[0]};
  return {values[0], values[1], values[2]};
}

std::optional<float> Shader::number(const Hit& hit) const {
  using Paint = RenderOptions::Paint;
  if (options.paint == Paint::vertex_numbers) return vertex_value(hit, 1, 0);
  if (options.paint != Paint::texture_numbers || atlas->chart[hit.triangle] < 0) return {};
  std::vector<float> values(paints.textures[surface.mesh.texture(hit.triangle)]->channels());
  texture_values(hit, values);
  return values[options.channel];
}

float Shader::vertex_value(const Hit& hit, int count, int channel) const {
  const Triangle& triangle = surface.mesh.triangles[hit.triangle];
  return float(interpolate(hit.barycentric, [&](int k) {
    return paints.vertex_values[std::size_t(triangle[k]) * count + channel];
  }));
}

Colour Shader::albedo(const Hit& hit) const {
  using Paint = RenderOptions::Paint;
  switch (options.paint) {
    case Paint::clay: return clay;
    case Paint::texture: return textured(hit);
    case Paint::charts:
      return atlas->chart[hit.triangle] < 0 ? clay : chart_colour(atlas->chart[hit.triangle]);
    case Paint::vertex_colours:
      return {vertex_value(hit, 3, 0), vertex_value(hit, 3, 1), vertex_value(hit, 3, 2)};
    case Paint::vertex_numbers:
    case Paint::texture_numbers: break;
  }
  const std::optional<float> value = number(hit);
  return value ? false_colour(*value, options.scale) : clay;
}

Vector3 Shader::shading_normal(const Hit& hit) const {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (int k = 0; k < 3; ++k) sum += float(hit.barycentric[k]) * normals[3 * hit.triangle + k];
  return sum.cast<double>().normalized();
}

LightAt Shader::light_at(const Hit& hit) const {
  const Vector3 view = camera.towards_viewer(hit.point);
  Vector3 normal = shading_normal(hit);
  if (normal.dot(view) < 0) normal -= 2 * normal.dot(view) * view;  // the back, or past the rim
  const double key = std::max(0.0, normal.dot(key_light));
  const double light = 0.22 + 0.10 * normal.dot(camera.up()) + 0.44 * normal.dot(view) + 0.36 * key;
  const bool back = triangle_normal(surface.mesh, hit.triangle).dot(view) < 0;
  LightAt all;
  all.light = light / (0.22 + 0.44 + 0.36 * 0.57) * (back ? 0.45 : 1.0);
  all.power = std::pow(all.light, 1 / 2.4);
  if (options.paint == RenderOptions::Paint::clay)
    all.gloss = 0.06 * std::pow(std::max(0.0, (key_light + view).normalized().dot(normal)), 40);
  return all;
}

Colour Shader::lit(const Colour& colour, const LightAt& light) const {
  const double gloss = options.paint == RenderOptions::Paint::clay ? light.gloss : 0;
  Colour result;
  for (int k = 0; k < 3; ++k)
    result[k] = float(brightened(colour[k], light.light, light.power) + gloss);
  return result;
}

}  // namespace mq
