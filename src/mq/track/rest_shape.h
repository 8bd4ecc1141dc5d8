#pragma once
/// The shape a surface would have if its triangles had never been stretched.

#include <array>
#include <span>
#include <vector>

#include "mq/mesh/mesh.h"

namespace mq {

/// Positions x near those of `now` whose triangles have the shapes `rest` says (corners, per
/// triangle, anywhere in space), as far as these fit together: least squares of
///
///     Σ_t Σ_(ij in t) w_ij |x_i − x_j − R_t (b_i − b_j)|²,   R_t a rotation,
///
/// w_ij the cotangents at rest, from below cut at 0.05, by twenty rounds of fitting R and solving
/// for x (Sorkine, Alexa, As-rigid-as-possible surface modeling, 2007). Where the triangles can be
/// laid together they have their shapes, at the bends of now; a surface that is as it was at rest
/// is returned bit for bit. Throws `InvalidInput` unless there are as many rest shapes as
/// triangles.
std::vector<Vector3> rest_shape(const Mesh& now, std::span<const std::array<Vector3, 3>> rest);

/// The most that a triangle of a mesh is stretched, the larger singular value of the map from its rest
/// shape over the smaller, or scaled, larger or smaller; 1: all are as at rest. Triangles without an area
/// at rest do not count. Throws as `rest_shape` does.
double worst_distortion(const Mesh& now, std::span<const std::array<Vector3, 3>> rest);

}  // namespace mq
