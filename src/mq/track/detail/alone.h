#pragma once
/// What one of two surfaces that lie close to each other has and the other does not, such as a handle.

#include <vector>

#include "mq/mesh/closest_point.h"
#include "mq/mesh/mesh.h"

namespace mq {

/// The corner of its triangle that a point is nearest to, by barycentric coordinates.
int nearest_corner(const Mesh& mesh, const ClosestPoint& p);

/// Per vertex of a mesh 1 where the other one has nothing like it: points that are more than a `reach` and twice the
/// distance that the places they find there have from the mesh away; and all that hang together with these and are
/// farther than half a reach. `from` are the points of the other one nearest to the vertices, `back` those of the mesh
/// nearest to the other's vertices.
std::vector<char> alone(const Mesh& mesh, const std::vector<ClosestPoint>& from, const Mesh& other,
                        const std::vector<ClosestPoint>& back, double reach);

}  // namespace mq
