#pragma once
/// Where the surface shows values of a texel space, and where it ends. Used inside this room.

#include <algorithm>
#include <cmath>

#include "mq/atlas/coverage.h"
#include "mq/fem/texel_space.h"

namespace mq {

/// Calls visit(triangle, barycentric) for points along the edges of triangles that have a chart and
/// no neighbour with one, `step` (model units) or less apart, their ends among them.
template <class Visit>
void for_each_boundary_point(const Surface& surface, const Atlas& atlas, double step,
                             const Visit& visit) {
  for (HalfEdge h = 0; h < 3 * surface.triangle_count(); ++h) {
    const int t = h / 3, k = h % 3, twin = surface.twins[std::size_t(h)];
    if (atlas.chart[t] < 0 || surface.degenerate[t]) continue;
    if (twin >= 0 && atlas.chart[twin / 3] >= 0) continue;
    const double length =
        (surface.mesh.position(t, (k + 1) % 3) - surface.mesh.position(t, k)).norm();
    const int steps = std::max(1, int(std::ceil(length / step)));
    for (int s = 0; s <= steps; ++s) {
      Vector3 barycentric = Vector3::Zero();
      barycentric[k] = 1 - double(s) / steps;
      barycentric[(k + 1) % 3] = double(s) / steps;
      visit(t, barycentric);
    }
  }
}

/// Calls texel(unknown) for those whose centres triangles cover, and point(triangle, barycentric) for the corners of
/// triangles and for points along boundaries.
template <class Texel, class Point>
void for_each_shown(const Surface& surface, const Atlas& atlas, const TexelSpace& space, const Texel& texel,
                    const Point& point) {
  const std::vector<Coverage> coverage = texel_coverage(surface, atlas);
  for (int i = 0; i < space.size(); ++i) {
    const Texels::Place& at = space.texels().places[std::size_t(i)];
    if (coverage[std::size_t(at.texture)].triangle(at.x, at.y) >= 0) texel(i);
  }
  for (int t = 0; t < surface.triangle_count(); ++t)
    for (int k = 0; k < 3 && atlas.chart[t] >= 0 && !surface.degenerate[t]; ++k) point(t, Vector3::Unit(k));
  for_each_boundary_point(surface, atlas, space.scale().texel_spacing / 2, point);
}

}  // namespace mq
