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
constexpr double no_distance = 1e-9;      // nothing but rounding

/// The corner opposite edge k, the edge from the origin along the first axis.
Vector2 apex(const FlatTriangle& shape, int k) {
  const Vector2 edge = shape.edge(k), side = shape.corner((k + 2) % 3) - shape.corner(k);
  const double length = edge.norm();
  return {edge.dot(side) / length, 2 * shape.area() / length};
}

/// |l|/|e| between circumcentres, negative where they lie the wrong way round.
double circumcentre_distance(const FlatTriangle& here, int k, const FlatTriangle& there, int l) {
  return here.half_cotangent((k + 2) % 3) + there.half_cotangent((l + 2) % 3);
}

/// 2·A/|l|² of the edge k of one triangle and l of the other.
double weight(const FlatTriangle& here, int k, const FlatTriangle& there, int l,
              DualCentre centre) {
  if (centre != DualCentre::barycentre) {
    const double distance = circumcentre_distance(here, k, there, l);
    return 1 / (centre == DualCentre::circumcentre ? std::max(distance, least_distance) : distance);
  }
  const double length = here.edge(k).norm();
  const Vector2 above = apex(here, k), below = apex(there, l);
  const Vector2 between = (above + Vector2(below.x() - length, below.y())) / 3;
  return 2 * (here.area() + there.area()) / 3 / between.squaredNorm();
}

double angle(const Vector2& v) { return std::atan2(v.y(), v.x()); }

/// Calls visit(h, twin) once for each edge between two triangles with area.
template <class Visit>
void for_each_inner_edge(const Surface& surface, const std::vector<FlatTriangle>& shapes, const Visit& visit) {
  require(int(shapes.size()) == surface.triangle_count(),
          fmt::format("{} shapes were given for {} triangles", shapes.size(), surface.triangle_count()));
  for (HalfEdge h = 0; h < 3 * surface.triangle_count(); ++h)
    if (const HalfEdge twin = surface.twins[h]; twin > h && !shapes[h / 3].empty() && !shapes[twin / 3].empty())
      visit(h, twin);
}

}  // namespace

DualWeights dual_weights(const Surface& surface, const std::vector<FlatTriangle>& shapes) {
  DualWeights weights;
  for_each_inner_edge(surface, shapes, [&](HalfEdge h, HalfEdge twin) {
    const double distance = circumcentre_distance(shapes[h / 3], h % 3, shapes[twin / 3], twin % 3);
    ++weights.edges;
    if (std::abs(distance) < no_distance)
      ++weights.on_a_circle;
    else
      weights.negative += distance < 0;
  });
  return weights;
}

SparseMatrix vector_differences(const Surface& surface, const std::vector<FlatTriangle>& shapes,
                                DualCentre centre) {
  const int count = surface.triangle_count();
  if (centre == DualCentre::circumcentre_as_printed) {
    const DualWeights found = dual_weights(surface, shapes);
    require(found.on_a_circle == 0,
            fmt::format("{} of {} edges lie between two triangles on one circle, whose weight by circumcentres as printed "
                        "is infinite; circumcentric weights on Delaunay triangles are bounded",
                        found.on_a_circle, found.edges));
  }
  Entries entries;
  for_each_inner_edge(surface, shapes, [&](HalfEdge h, HalfEdge twin) {
    const int i = h / 3, j = twin / 3;
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
  });
  return sparse_matrix(2 * count, 2 * count, entries);
}

}  // namespace mq
