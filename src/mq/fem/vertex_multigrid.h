#pragma once
/// The multigrid solver for signals at vertices.

#include <span>

#include "mq/fem/multigrid_solver.h"
#include "mq/mesh/mesh.h"

namespace mq {

/// Makes solvers for the systems a·M + b·S of a vertex space whose vertices lie at `positions`,
/// which must outlive the factory (not the solvers it makes).
///
/// Levels are points on the surface, each about a fifth of the one before, chosen along the edges of
/// the matrix, and interpolated in triangles of chosen points (`coarsen_graph`; Wiersma, Nasikun,
/// Eisemann and Hildebrandt, A fast geometric multigrid method for curved surfaces, 2023). Rows are
/// relaxed one by one (Gauss–Seidel), the coarsest level is solved directly; around the cycle run
/// conjugate gradients, to double precision. As `multigrid_solver` in all else: semidefinite
/// matrices, what it throws, bits. Of its options `max_stretch` means nothing here.
SolverFactory vertex_multigrid_solver(std::span<const Vector3> positions,
                                      const MultigridOptions& options = {});

}  // namespace mq
