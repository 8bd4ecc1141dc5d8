#pragma once
/// The levels of a system of a vertex space.

#include <array>
#include <span>
#include <vector>

#include "mq/fem/detail/hierarchy.h"
#include "mq/mesh/mesh.h"

namespace mq {

/// Positions from the first of them, near which single precision tells them apart wherever they
/// are.
std::vector<std::array<float, 3>> relative_positions(std::span<const Vector3> positions);

/// Makes them by the pattern of A and where the vertices lie, then takes A's values: as the coarse
/// levels of a texel system, from the first level on. Throws as `vertex_multigrid_solver`.
Hierarchy vertex_hierarchy(const SparseMatrix& A, std::span<const Vector3> positions,
                           const MultigridOptions& options = {}, const Progress& progress = {});

}  // namespace mq
