#pragma once
/// Signals of texels as the vertices of a mesh cut to their size see them.

#include "mq/filter/refined_texture.h"

namespace mq {

/// ∫ φ_v f dA / ∫ φ_v dA around each vertex, by samples about a texel apart. Values at the vertices
/// themselves would show waves that the triangles cannot hold as longer ones, which no motion
/// explains.
Signal means_at_vertices(const RefinedTexture& refined, const Signal& signal);

}  // namespace mq
