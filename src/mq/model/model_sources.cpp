#include "mq/model/model_sources.h"

namespace mq {

std::vector<GeodesicSource> sources_at_point(const Mesh& mesh, const TexelSpace& texels, const SurfacePoint& point) {
  /// Weights below this do not count among texels.
  constexpr double least_weight = 1e-3;
  const Vector3 place = point_at(mesh, point);
  std::vector<GeodesicSource> sources;
  for (const BasisWeight& w : texels.basis_at(point.triangle, point.barycentric))
    if (w.weight > least_weight)
      sources.push_back({w.unknown, (texels.texels().position(w.unknown) - place).norm(), place});
  return sources;
}

std::vector<GeodesicSource> sources_at_point(const TexturedModel& model, const ModelSignal& signal,
                                             const SurfacePoint& point) {
  const Mesh& mesh = model.surface.mesh;
  if (const TexelSpace* texels = signal.texel_space()) return sources_at_point(mesh, *texels, point);
  const Vector3 place = point_at(mesh, point);
  std::vector<GeodesicSource> sources;
  for (int k = 0; k < 3; ++k)
    sources.push_back(
        {mesh.triangles[point.triangle][k], (mesh.position(point.triangle, k) - place).norm(), place});
  return sources;
}

std::vector<GeodesicSource> sources_at_texel(const ModelSignal& signal,
                                             const Texels::Place& texel) {
  std::vector<GeodesicSource> sources;
  const TexelSpace* texels = signal.texel_space();
  for (const int i : signal.unknowns_at(texel))
    sources.push_back({i, 0, texels->texels().position(i)});
  return sources;
}

std::vector<GeodesicSource> sources_in_masks(const ModelSignal& signal,
                                             std::span<const Image<float>> masks) {
  std::vector<GeodesicSource> sources;
  for (int k = 0; k < int(masks.size()); ++k)
    for (int y = 0; y < masks[std::size_t(k)].height(); ++y)
      for (int x = 0; x < masks[std::size_t(k)].width(); ++x)
        if (masks[std::size_t(k)](x, y) > 0.5F)
          for (const int unknown : signal.unknowns_at({k, x, y})) sources.push_back({unknown, 0});
  return sources;
}

}  // namespace mq
