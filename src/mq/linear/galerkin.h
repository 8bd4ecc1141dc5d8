#pragma once
/// The matrix of a coarse level.

#include "mq/base/progress.h"
#include "mq/linear/stencil_rows.h"
#include "mq/linear/transfer.h"

namespace mq {

/// Pᵀ·A·P: symmetric, as definite as A, with the null space of A where P reproduces it. Row by row
/// in parallel; every sum is taken in a fixed order. Costs entries of A × parents of a row.
SparseMatrix galerkin(const SparseMatrix& A, const LevelTransfer& P, const Progress& progress = {});
SparseMatrix galerkin(const StencilRows& A, const StencilLayout& layout, const LevelTransfer& P,
                      const Progress& progress = {});

}  // namespace mq
