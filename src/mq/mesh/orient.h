#pragma once
/// Triangles that face the wrong way, as scanners and converters leave them, turned back.

#include <vector>

#include "mq/base/defect.h"
#include "mq/mesh/mesh.h"

namespace mq {

struct Oriented {
  Mesh mesh;                ///< the same triangles, of some two corners changed places
  std::vector<int> turned;  ///< which, in order
  Defects defects;          ///< turned_triangles, inside_out_triangles: warnings
};

/// Turns triangles over, corners with their texture coordinates:
///
/// 1. Against their neighbours. Parts hang together by edges of exactly two triangles (vertices at
///    equal positions are one; of more triangles, the two that the mesh joins by its own vertices,
///    so that solids which touch are two); of each the side that has more of its area stays, the
///    rest is turned to face alike. A part of which that does not at least halve the edges that
///    disagree, as a Möbius strip, stays as it is.
/// 2. Inward. A part that encloses a negative volume, whatever the point that closes its boundary
///    as cones (within its box; ten times over, so that nothing that is open counts), is turned.
///    Those that lie inside it are turned with it: cavities face inward.
/// 3. Against `before`, if it is given, where it is not known what is inside: a part of which three
///    quarters of the area nearer than a twentieth of its diagonal, and that at least half, face
///    against the nearest point.
///
/// 2 and 3 are asked of parts of at least a thousandth of the area. Costs O(n log n). Throws
/// `InvalidInput` where `make_surface` does.
Oriented oriented(const Mesh& mesh, const Mesh* before = nullptr);

/// What was captured, facing as what follows it, `before`, does: as above, but left as it is where
/// that is inside out itself, which decides.
Oriented oriented_like(const Mesh& mesh, const Mesh& before);

/// The same triangles flipped.
Mesh with_flipped(Mesh mesh, const std::vector<int>& triangles);

}  // namespace mq
