#include "pick.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mq/image/resample.h"

namespace mq::view {
namespace {

void read_texel(const TexturedModel& scene, const TextureSet* textures, Pick& pick) {
  const TextureSize& size = scene.atlas->textures[std::size_t(pick.texture)];
  pick.x = wrapped(std::llround(pick.column), size.width, size.wrap);
  pick.y = wrapped(std::llround(pick.row), size.height, size.wrap);
  if (textures != nullptr) pick.values = textures->texel(pick.texture, pick.x, pick.y);
}

/// Linear in the triangle.
void read_colour(const TexturedModel& scene, const VertexSignal& colours, Pick& pick) {
  pick.values.assign(std::size_t(colours.channels), 0);
  for (int k = 0; k < 3; ++k) {
    const int vertex = scene.surface.mesh.triangles[std::size_t(pick.triangle)][std::size_t(k)];
    const int source = scene.surface.source_from_vertex[std::size_t(vertex)];
    for (int c = 0; c < colours.channels; ++c)
      pick.values[std::size_t(c)] +=
          float(pick.barycentric[k]) *
          colours.values[std::size_t(source) * std::size_t(colours.channels) + std::size_t(c)];
  }
}

}  // namespace

Pick pick_on_surface(const TexturedModel& scene, const mq::Scene& rays, const ShownValues& values,
                     const Ray& ray) {
  const Hit hit = rays.hit(ray);
  Pick pick;
  pick.triangle = hit.triangle;
  if (!pick) return pick;
  pick.barycentric = hit.barycentric;
  pick.point = hit.point;
  if (!scene.atlas || scene.atlas->chart[std::size_t(hit.triangle)] < 0) {
    if (values.colours != nullptr) read_colour(scene, *values.colours, pick);
    return pick;
  }
  pick.chart = scene.atlas->chart[std::size_t(hit.triangle)];
  pick.texture = scene.surface.mesh.texture(hit.triangle);
  const auto& corners = scene.atlas->corners[std::size_t(hit.triangle)];
  for (int k = 0; k < 3; ++k) {
    pick.column += hit.barycentric[k] * corners[std::size_t(k)].column();
    pick.row += hit.barycentric[k] * corners[std::size_t(k)].row();
  }
  read_texel(scene, values.textures, pick);
  return pick;
}

Pick pick_in_atlas(const TexturedModel& scene, const TrianglesAt& triangles,
                   const TextureSet* textures, int texture, double column, double row) {
  const TrianglesAt::Found found =
      triangles(texture, {std::llround(column * double(TexelPoint::one)),
                          std::llround(row * double(TexelPoint::one))});
  Pick pick;
  pick.triangle = found.triangle;
  if (!pick) return pick;
  pick.barycentric = found.barycentric;
  const Mesh& mesh = scene.surface.mesh;
  for (int k = 0; k < 3; ++k) pick.point += pick.barycentric[k] * mesh.position(pick.triangle, k);
  pick.chart = scene.atlas->chart[std::size_t(pick.triangle)];
  pick.texture = texture;
  pick.column = column, pick.row = row;
  read_texel(scene, textures, pick);
  return pick;
}

std::string in_words(const Pick& pick, double size) {
  if (!pick) return "";
  const int decimals = size > 0 ? std::clamp(4 - int(std::floor(std::log10(size))), 0, 12) : 4;
  std::string text =
      fmt::format("face {}  bary {:.3f} {:.3f} {:.3f}  at {:.{}f}, {:.{}f}, {:.{}f}", pick.triangle,
                  pick.barycentric[0], pick.barycentric[1], pick.barycentric[2], pick.point[0],
                  decimals, pick.point[1], decimals, pick.point[2], decimals);
  if (pick.chart < 0 && pick.values.empty()) return text + "  no texture here";
  if (pick.chart >= 0)
    text += fmt::format("  chart {}  texel{} {}, {}", pick.chart,
                        pick.texture > 0 ? std::to_string(pick.texture) : "", pick.x, pick.y);
  if (!pick.values.empty()) text += "  value";
  for (const float value : pick.values) text += fmt::format(" {:.4g}", value);
  return text;
}

nlohmann::ordered_json as_json(const Pick& pick) {
  if (!pick) return nullptr;
  nlohmann::ordered_json json = {
      {"face", pick.triangle},
      {"barycentric", {pick.barycentric[0], pick.barycentric[1], pick.barycentric[2]}},
      {"point", {pick.point[0], pick.point[1], pick.point[2]}}};
  if (pick.chart < 0) {
    if (!pick.values.empty()) json["values"] = pick.values;
    return json;
  }
  json["chart"] = pick.chart;
  json["texture"] = pick.texture;
  json["texel"] = {pick.x, pick.y};
  json["place"] = {pick.column, pick.row};
  json["values"] = pick.values;
  return json;
}

}  // namespace mq::view
