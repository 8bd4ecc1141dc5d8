/// Both triangles in a common plane: their shared edge along the first axis, one above, one below.
/// With the shared edge e the dual area is ½|e||l| between circumcentres, where l is orthogonal to
/// e, and (|t_i| + |t_j|)/3 between barycentres.

#include "mq/fem/vector_differences.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "mq/base/error.h"

namespace mq {

namespace {

constexpr double least_distance = 0.005;  // of circumcentres, per edge length

/// The corner opposite edge k, the edge from the origin along the first axis.
Vector2 apex(const FlatTriangle& shape, int k) {
  const Vector2 edge = shape.edge(k), side = shape.corner((k + 2) % 3) - shape.corner(k);
  const double length = edge.norm();
  return {edge.dot(side) / length, 2 * shape.area() / length};
}

/// 2·A/|l|² of the edge k of one triangle and l of the other.
double weight(const FlatTriangle& here, int k, const FlatTriangle& there, int l,
              DualCentre centre) {
  if (centre == DualCentre::circumcentre) {
    const double distance =
        here.half_cotangent((k + 2) % 3) + there.half_cotangent((l + 2) % 3);  // |l|/|e|
    return 1 / std::max(distance, least_distance);
  }
  const double length = here.edge(k).norm();
  const Vector2 above = apex(here, k), below = apex(there, l);
  const Vector2 between = (above + Vector2(below.x() - length, below.y())) / 3;
  return 2 * (here.area() + there.area()) / 3 / between.squaredNorm();
}

double angle(const Vector2& v) { return std::atan2(v.y(), v.x()); }

}  // namespace

SparseMatrix vector_differences(const Surface& surface, const std::vector<FlatTriangle>& shapes,
                                DualCentre centre) {
  const int count = surface.triangle_count();
  require(int(shapes.size()) == count,
          fmt::format("{} shapes were given for {} triangles", shapes.size(), count));
  Entries entries;
  for (HalfEdge h = 0; h < 3 * count; ++h) {
    const HalfEdge twin = surface.twins[h];
    if (twin <= h) continue;  // of each pair one; boundaries have none
    const int i = h / 3, j = twin / 3;
    if (shapes[i].empty() || shapes[j].empty()) continue;
    const double w = weight(shapes[i], h % 3, shapes[j], twin % 3, centre);
    const double turn =
        angle(shapes[i].edge(h % 3)) - angle(shapes[j].edge(twin % 3)) + std::numbers::pi;
    const double c = w * std::cos(turn), s = w * std::sin(turn);
    for (int k = 0; k < 2; ++k)
      entries.insert(entries.end(), {{2 * i + k, 2 * i + k, w},
                                     {2 * j + k, 2 * j + k, w},
                                     {2 * i + k, 2 * j + k, -c},
                                     {2 * j + k, 2 * i + k, -c}});
    entries.insert(entries.end(), {{2 * i, 2 * j + 1, s},
                                   {2 * j + 1, 2 * i, s},
                                   {2 * i + 1, 2 * j, -s},
                                   {2 * j, 2 * i + 1, -s}});
  }
  return sparse_matrix(2 * count, 2 * count, entries);
}

}  // namespace mq
