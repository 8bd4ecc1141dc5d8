#pragma once
/// The levels of a texel system.

#include "mq/fem/detail/hierarchy.h"
#include "mq/fem/texels.h"

namespace mq {

/// Makes them by the pattern of A and the places of the texels, then takes A's values. Throws as
/// `multigrid_solver`.
Hierarchy texel_hierarchy(const SparseMatrix& A, const Texels& texels,
                          const MultigridOptions& options = {}, const Progress& progress = {});

/// The same of a matrix that is used up, with the layout of `make_layout`: what it held is let go of on the way.
Hierarchy texel_hierarchy(StencilSystem&& A, const Texels& texels, const MultigridOptions& options = {},
                          const Progress& progress = {});

}  // namespace mq
