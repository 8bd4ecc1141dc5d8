#pragma once
/// The solver of texel systems, made for them: conjugate gradients around a multigrid cycle.

#include "mq/fem/texels.h"
#include "mq/linear/solver.h"

namespace mq {

struct MultigridOptions {
  double tolerance = 1e-6;  ///< stop when ‖B − A·X‖ ≤ tolerance · ‖B‖ in every channel, and
                            ///< `ErrorEstimate` finds the error small enough
  int max_cycles = 60;      ///< ... or after so many cycles
  int sweeps = 2;           ///< relaxations before and after each coarse solution
  /// A chart whose texels are more than this times as far apart along one axis as along the other is
  /// coarsened along the other only.
  double max_stretch = 2.2;
  double graph_radius = 2.3;  ///< coarsening of the levels without a grid, see `coarsen_graph`
  int coarsest_rows = 500;    ///< no further levels below this size
};

/// Makes solvers for the systems a·M + b·S of a texel space; `texels` are those of the space
/// and must outlive the factory (not the solvers it makes).
///
/// Levels: the texels; per chart a grid of half the resolution; then points on the surface that know
/// nothing of charts. Interior texels are relaxed as 3 × 3 stencils, those at seams by solving
/// small patches exactly, and so once more those of triangles stretched beyond 4 : 1 or of nearly no
/// area, up to a fiftieth of all; the coarsest level is solved directly. A may be semidefinite with the
/// constants of a component in its null space (`SolveReport` residuals then leave out what B holds
/// of constants, and X keeps its mean on that component).
///
/// Set-up costs a few products with A; a cycle about that of ten. Throws `InvalidInput` where A does
/// not have one row per texel or holds a NaN, `NotPositiveDefinite` naming the row.
/// Results are the same bits for any number of threads.
SolverFactory multigrid_solver(const Texels& texels, const MultigridOptions& options = {});

}  // namespace mq
