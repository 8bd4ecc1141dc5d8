#include "mq/model/model_sources.h"

namespace mq {

std::vector<GeodesicSource> sources_at_point(const TexturedModel& model, const ModelSignal& signal,
                                             const SurfacePoint& point) {
  /// Weights below this do not count among texels.
  constexpr double least_weight = 1e-3;
  const Mesh& mesh = model.surface.mesh;
  const Vector3 place = point_at(mesh, point);
  std::vector<GeodesicSource> sources;
  const auto add = [&](int unknown, const Vector3& at) {
    sources.push_back({unknown, (at - place).norm(), place});
  };
  if (const TexelSpace* texels = signal.texel_space()) {
    for (const BasisWeight& w : texels->basis_at(point.triangle, point.barycentric))
      if (w.weight > least_weight) add(w.unknown, texels->texels().position(w.unknown));
  } else {
    for (int k = 0; k < 3; ++k)
      add(mesh.triangles[point.triangle][k], mesh.position(point.triangle, k));
  }
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
