#pragma once
/// The published multigrid solver of texel systems, to compare with: thesis 5.8,
/// [prada2018gradient].

#include "mq/fem/texels.h"
#include "mq/linear/solver.h"

namespace mq {

struct ReferenceOptions {
  enum class Precision { float32, float64 };

  int grids = 4;          ///< with the texels and the coarsest
  int sweeps = 3;         ///< over interior texels, before and after each coarse solution
  int block_height = 16;  ///< of the blocks that are relaxed at once, texels; they are 128 wide
  Precision precision = Precision::float64;
  double tolerance = 1e-6;  ///< stop when ‖B − A·X‖ ≤ tolerance · ‖B‖ in every channel, and
                            ///< `ErrorEstimate` finds the error small enough
  int max_cycles = 200;     ///< ... or after so many cycles
};

/// Makes solvers for the systems a·M + b·S of a texel space by plain V-cycles; `texels` are those
/// of the space and must outlive the factory (not the solvers it makes).
///
/// Levels: a grid of its own for every chart, halved `grids` − 1 times, Galerkin matrices. On each,
/// interior texels (3 × 3 stencils) are relaxed by Gauss–Seidel and all others, the boundary, are
/// solved for directly; the coarsest is solved directly. A cycle cannot increase ‖X − A⁻¹B‖_A. A
/// may be semidefinite with the constants of a component in its null space; what B holds of them is
/// dropped then, and X keeps its sum on that component.
///
/// With Precision::float32 the whole iteration is in single precision, as in thesis 5.9, and ends
/// at a relative error of about 1e-5. Factorisations are in double either way.
///
/// Throws `InvalidInput` where A does not have one row per texel or holds a NaN,
/// `NotPositiveDefinite`. Results are the same bits for any number of threads.
SolverFactory reference_solver(const Texels& texels, const ReferenceOptions& options = {});

}  // namespace mq
