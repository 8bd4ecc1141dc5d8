#pragma once
/// The unknowns that have a part in what a signal is at the boundary of its domain.

#include <vector>

#include "mq/atlas/atlas.h"
#include "mq/fem/texel_space.h"
#include "mq/mesh/surface.h"

namespace mq {

/// A point of a triangle.
struct BoundaryPoint {
  int triangle = 0;
  Vector3 barycentric = Vector3::Zero();
};

/// Points along the edges of triangles that have a chart and no neighbour with one, `step` (model
/// units) or less apart, their ends among them.
std::vector<BoundaryPoint> boundary_points(const Surface& surface, const Atlas& atlas, double step);

/// Ascending: those whose functions are above 1e-3 at one of these points, half a mean texel spacing
/// apart.
std::vector<int> boundary_unknowns(const Surface& surface, const Atlas& atlas,
                                   const TexelSpace& space);

/// Ascending: the vertices of edges with one triangle.
std::vector<int> boundary_unknowns(const Surface& surface);

}  // namespace mq
