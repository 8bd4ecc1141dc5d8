#pragma once
/// A patch laid into the hole that a chart has where what was there before is gone.

#include <optional>
#include <vector>

#include "mq/mesh/mesh.h"

namespace mq {

/// A disc of triangles and where its boundary lies in the plane, counter-clockwise.
struct HolePatch {
  std::vector<Triangle> triangles;  ///< of its own vertices
  std::vector<Vector3> positions;   ///< per vertex, at the scale of the plane
  std::vector<char> fixed;          ///< per vertex 1 on the boundary
  std::vector<Vector2> places;      ///< per vertex; of those that are not fixed any
};

/// Places of all vertices: what is not fixed at the mean of its neighbours, with mean value weights of the
/// patch in space (Floater, Mean value coordinates, 2003). So a flat patch whose boundary lies as in its
/// plane is laid as it is. None where a triangle is turned over, or three times as long, short or thin
/// as in space.
std::optional<std::vector<Vector2>> filled_hole(const HolePatch& patch);

/// Whether two triangles of the plane have an area in common, beyond rounding.
bool overlap(const std::vector<Vector2>& one, const std::vector<Vector2>& other);

}  // namespace mq
