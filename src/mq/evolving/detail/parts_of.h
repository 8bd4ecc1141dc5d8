#pragma once
/// Triangles that hang together.

#include <vector>

#include "mq/mesh/surface.h"

namespace mq {

/// Sets of these triangles of a surface that hang together by edges, in the order of their first ones.
std::vector<std::vector<int>> parts_of(const std::vector<int>& triangles, const std::vector<HalfEdge>& twins);

}  // namespace mq
