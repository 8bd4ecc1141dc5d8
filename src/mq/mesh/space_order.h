#pragma once
/// Places in an order in which neighbours in space are neighbours in memory.

#include <span>
#include <vector>

#include "mq/mesh/mesh.h"

namespace mq {

/// The numbers of the places along a space-filling curve (Morton 1966) through the cube around all of them, 21 bits per
/// axis; equal codes by number. One sort.
std::vector<int> space_order(std::span<const Vector3> places);

/// The same of a mesh's triangles, by their centres.
std::vector<int> triangle_space_order(const Mesh& mesh);

/// A mesh with its vertices and triangles in that order. Positions and triangles only.
struct OrderedMesh {
  Mesh mesh;
  std::vector<int> source;  ///< per triangle its number before
};
OrderedMesh in_space_order(const Mesh& mesh);

}  // namespace mq
