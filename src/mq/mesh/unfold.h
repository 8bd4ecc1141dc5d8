#pragma once
/// Takes folds out of a surface that was moved vertex by vertex.

#include <span>
#include <vector>

#include "mq/mesh/surface.h"

namespace mq {

/// Positions at which the mesh is folded over (`folded_triangles`) nowhere that smoothing can help:
/// corners of folded triangles go towards the mean of their neighbours (along a boundary, of the
/// two beside them) in sweeps, with more of their neighbours the longer it takes, until none is
/// folded. Vertices stay that are `fixed` (one entry each; empty: none is) or not manifold; so
/// does, bit for bit, each connected group of folds that is not gone after all sweeps. Where
/// nothing is folded nothing moves. Throws as `make_surface` does; none are welded.
std::vector<Vector3> unfolded(const Mesh& mesh, std::span<const char> fixed = {});

}  // namespace mq
