#pragma once
/// What a mesh must fulfil before anything can be said of it.

#include <vector>

#include "mq/mesh/mesh.h"

namespace mq {

/// Beyond it the squares of areas would leave the range of a double.
inline constexpr double largest_coordinate = 1e60;

/// Throws `InvalidInput`, with the first ids, unless all indices point at something and the arrays
/// per triangle are as long as there are triangles.
void check_mesh(const Mesh& mesh);

/// Per vertex 1 if a triangle uses it. Throws `InvalidInput`, with the first ids, where the
/// position of one in use is not finite or lies beyond `largest_coordinate`.
std::vector<char> referenced_vertices(const Mesh& mesh);

}  // namespace mq
