#pragma once
/// The regular part of a texel hierarchy: which rows are stencils, and the next coarser grid.

#include <functional>
#include <memory>
#include <vector>

#include "mq/base/progress.h"
#include "mq/fem/texels.h"
#include "mq/linear/matrix.h"
#include "mq/linear/stencil_matrix.h"
#include "mq/linear/transfer.h"

namespace mq {

/// Finds the rows of A whose entries are exactly a texel's 3 × 3 neighbours in its texture and chart,
/// and cuts them into tiles of 128 × 64 texels in four colours.
StencilLayout make_layout(const SparseMatrix& A, const Texels& texels);

/// The same where `middles(k)` says which texels are above and below texel k if that couples to its 3 × 3 neighbours and
/// nothing else, and is below 0 if not. Called in parallel.
StencilLayout make_layout(const Texels& texels, const std::function<std::array<int, 2>(int k)>& middles);

/// The worst stencil rows, ascending, to be `clustered`, which relaxation one by one would leave to the conjugate
/// gradients: rows whose anisotropy (see `stencil_anisotropy`) is above 16, lengths 4 : 1, or whose
/// diagonal value is more than 10 times that of a stencil next to them, these with two rings around; all
/// but the rings no more than one row in 50, the worst.
std::vector<int> find_clustered(const StencilRows& A, const StencilLayout& layout);

/// `make_layout` with the rows that `find_clustered` finds.
StencilLayout make_robust_layout(const SparseMatrix& A, const Texels& texels);

/// By how much a chart is coarsened along its columns and rows, 1 or 2 each.
struct GridStep {
  int x = 2;
  int y = 2;
};

/// Per chart how to coarsen: where texels are more than `max_ratio` times as far apart along one axis
/// as along the other, only along the other.
std::vector<GridStep> coarsening_steps(const Texels& texels, const StencilLayout& layout,
                                       double max_ratio);

struct GridCoarsening {
  std::unique_ptr<GridTransfer> transfer;
  Texels coarse;  ///< ordered by chart, row, column; x and y count nodes of the coarse grid
};

/// One node for every multiple of the chart's step of which a texel of the chart is less than a step
/// away (thesis 5.8.1), with bilinear interpolation, so that constants and, where all nodes are
/// there, linear functions are reproduced. A node without a texel lies at the mean of those it serves.
GridCoarsening coarsen_grid(const Texels& fine, const std::vector<GridStep>& steps);

/// The texels without a stencil that A, of which their rows are read, couples to others far away on the surface: where charts, or parts
/// of one, share texels of their border.
std::vector<int> find_contacts(const SparseMatrix& A, const Texels& texels,
                               const StencilLayout& layout);

/// Gives each sheet a node of its own where several parts of a chart pass through the 3 × 3 texels of
/// one, a gap narrower than the coarse grid between them: a handle, say, that lies beside the pan. Texels
/// are of one sheet where A couples them and they lie close to each other on the surface. The new nodes
/// come after all others. A, of which the rows without a stencil are read, and `layout` are of the texels that
/// `coarsening` was made for.
void part_sheets(const SparseMatrix& A, const Texels& fine, const StencilLayout& layout,
                 GridCoarsening& coarsening);

}  // namespace mq
