#include "mq/fem/boundary_unknowns.h"

#include <algorithm>
#include <cmath>

namespace mq {
namespace {

/// Weights below this do not count.
constexpr double least_weight = 1e-3;

std::vector<int> without_repeats(std::vector<int> unknowns) {
  std::sort(unknowns.begin(), unknowns.end());
  unknowns.erase(std::unique(unknowns.begin(), unknowns.end()), unknowns.end());
  return unknowns;
}

}  // namespace

std::vector<BoundaryPoint> boundary_points(const Surface& surface, const Atlas& atlas,
                                           double step) {
  std::vector<BoundaryPoint> points;
  for (HalfEdge h = 0; h < 3 * surface.triangle_count(); ++h) {
    const int t = h / 3, k = h % 3, twin = surface.twins[std::size_t(h)];
    if (atlas.chart[t] < 0 || surface.degenerate[t]) continue;
    if (twin >= 0 && atlas.chart[twin / 3] >= 0) continue;
    const double length =
        (surface.mesh.position(t, (k + 1) % 3) - surface.mesh.position(t, k)).norm();
    const int steps = std::max(1, int(std::ceil(length / step)));
    for (int s = 0; s <= steps; ++s) {
      BoundaryPoint point{.triangle = t};
      point.barycentric[k] = 1 - double(s) / steps;
      point.barycentric[(k + 1) % 3] = double(s) / steps;
      points.push_back(point);
    }
  }
  return points;
}

std::vector<int> boundary_unknowns(const Surface& surface, const Atlas& atlas,
                                   const TexelSpace& space) {
  std::vector<int> unknowns;
  for (const BoundaryPoint& p : boundary_points(surface, atlas, space.scale().texel_spacing / 2))
    for (const TexelWeight& w : space.basis_at(p.triangle, p.barycentric))
      if (w.weight > least_weight) unknowns.push_back(w.texel);
  return without_repeats(std::move(unknowns));
}

std::vector<int> boundary_unknowns(const Surface& surface) {
  std::vector<int> unknowns;
  for (HalfEdge h = 0; h < 3 * surface.triangle_count(); ++h) {
    const int t = h / 3;
    if (surface.twins[std::size_t(h)] >= 0 || surface.degenerate[t]) continue;
    unknowns.push_back(surface.mesh.triangles[t][h % 3]);
    unknowns.push_back(surface.mesh.triangles[t][(h + 1) % 3]);
  }
  return without_repeats(std::move(unknowns));
}

}  // namespace mq
