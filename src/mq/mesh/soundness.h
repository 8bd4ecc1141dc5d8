#pragma once
/// What is wrong with a surface as a whole, for those who made it and want to know.

#include <vector>

#include "mq/mesh/surface.h"

namespace mq {

/// Whether the mesh was manifold before it was cut: no edge of more than two triangles or of two
/// that turn against each other, no vertex of several fans, no triangle twice.
bool is_manifold(const Surface& surface);

/// Triangles that are folded over: without area, or with a normal that points against the sum of
/// the unit normals of those across their edges.
std::vector<int> folded_triangles(const Surface& surface);

}  // namespace mq
