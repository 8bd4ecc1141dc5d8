#pragma once
/// The levels of a texel system.

#include "mq/fem/detail/hierarchy.h"
#include "mq/fem/texels.h"

namespace mq {

/// Makes them by the pattern of A and the places of the texels, then takes A's values. Throws as
/// `multigrid_solver`.
Hierarchy texel_hierarchy(const SparseMatrix& A, const Texels& texels,
                          const MultigridOptions& options = {}, const Progress& progress = {});

}  // namespace mq
