#pragma once
/// Triangles that show what they should but no longer have their rest shape.

#include <array>
#include <span>
#include <vector>

#include "mq/remesh/detail/clip_surfaces.h"

namespace mq {

/// What is triangulated anew where it lies.
struct Retriangulation {
  std::vector<char> triangles;  ///< per triangle of the pair: is added
  std::vector<char> vertices;   ///< per vertex of the pair: all around it is added, and it may move
};

/// Renews distorted triangles of a template that are kept as they are (`kept`, per triangle of the
/// pair), and with them all that share a corner inside of what is kept. Edges of the distorted ones
/// that are longer than twice the mean edge of their rest shapes are halved, again and again, as
/// far as what lies across is renewed too, or nothing; for parts made by that, `kept` gets a 1
/// each. `distorted` (empty: none is) and `rest` (corners; empty: nothing is halved) are per
/// triangle of the template. Nothing of the target changes.
Retriangulation retriangulate(SurfacePair& pair, std::vector<char>& kept,
                              const std::vector<char>& distorted,
                              std::span<const std::array<Vector3, 3>> rest);

}  // namespace mq
