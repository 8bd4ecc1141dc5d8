#pragma once
/// Which triangles pass through others.

#include <span>
#include <vector>

#include "mq/mesh/mesh.h"

namespace mq {

/// Whether two triangles in the same vertices have points in common beyond what they share: an edge
/// of one passes through the inside of the other. Triangles that share an edge, or lie in one
/// plane, do not count, nor does touching that rounding cannot tell from passing by.
bool cross(const std::vector<Vector3>& positions, const Triangle& first, const Triangle& second);

/// Per triangle asked about 1 where it crosses one of the others or another one asked about. In
/// parallel; expected time linear as long as triangles are of similar size.
std::vector<char> crossed(const std::vector<Vector3>& positions, std::span<const Triangle> asked,
                          std::span<const Triangle> others);

/// The same for crossing one of the others alone.
std::vector<char> crossed_by(const std::vector<Vector3>& positions, std::span<const Triangle> asked,
                             std::span<const Triangle> others);

}  // namespace mq
