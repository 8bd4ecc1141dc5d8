#pragma once
/// Which triangles hang together.

#include <vector>

#include "mq/mesh/surface.h"

namespace mq {

/// Per triangle its component, connected through edges; it goes by its lowest triangle.
std::vector<int> triangle_components(const Surface& surface);

}  // namespace mq
