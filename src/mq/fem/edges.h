#pragma once
/// The edges of a surface, each with a direction: where 1-forms have their values.

#include <array>
#include <vector>

#include "mq/fem/flat_triangle.h"

namespace mq {

/// Edges that bound at least one triangle with area, numbered by their lowest half-edge (of such
/// triangles) and directed along it.
struct Edges {
  std::vector<std::array<int, 2>> vertices;  ///< source and target
  std::vector<int> from_half_edge;  ///< per half-edge its edge; -1 where the triangle has no area
  std::vector<signed char> sign;    ///< per half-edge +1 where it runs along its edge, -1 against it

  int count() const { return int(vertices.size()); }
};

/// Edges where the surface was cut (no twin) are one per side. `shapes` says which triangles have
/// area.
Edges make_edges(const Surface& surface, const std::vector<FlatTriangle>& shapes);

}  // namespace mq
