#pragma once
/// How much a surface encloses.

#include "mq/mesh/surface.h"

namespace mq {

/// The volume inside a closed surface, by the divergence theorem
///
///     V = ⅓ ∫ ⟨x − c, N⟩ dA = ⅙ Σ_t ⟨p − c, (q − c) × (r − c)⟩,
///
/// c the middle of the bounding box; model units cubed. Positive where normals point outward; parts
/// that are turned inside out count negative, overlaps count twice. Where there are boundaries it is
/// the volume with them closed by cones from c, which means little.
double enclosed_volume(const Mesh& mesh);

}  // namespace mq
