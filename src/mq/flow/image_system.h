#pragma once
/// The linear system of optical flow on an image, and its solver.

#include <vector>

#include "mq/base/progress.h"
#include "mq/linear/solver.h"

namespace mq {

/// A·Y = Σ_p D_p Y_p + Σ over neighbours p, q of w_pq (Y_p − Y_q): two unknowns per pixel, row by
/// row. D_p symmetric and positive semidefinite, w ≥ 0; A is positive definite where no vector
/// field that is constant over pixels joined by w > 0 is in the null space of all their D.
struct ImageFlowSystem {
  ImageFlowSystem(int w, int h);

  int width, height;
  std::vector<float> d11, d12, d22;  ///< D_p: across, mixed, down
  std::vector<float> east;   ///< w of a pixel and the one to its right; 0 in the last column
  std::vector<float> south;  ///< w of a pixel and the one below; 0 in the last row
};

/// A vector field as two planes, across and down.
struct FlowPlanes {
  std::vector<float> u, v;
};

/// Conjugate gradients around one V-cycle of multigrid: each pixel's two unknowns are relaxed
/// together, in the order of a chess board's colours (backward after the coarser grid, so that the
/// cycle is symmetric); a coarser pixel stands for 2 × 2, has the sum of their D and the mean w
/// across its sides, and is interpolated bilinearly. Bruhn, Weickert, Kohlberger and Schnörr
/// [bruhn2006multigrid] show that coupling the two unknowns and few levels of a cycle is what such
/// systems want.
///
/// Single precision, sums in double; bits do not depend on the number of threads, and −b gives −Y
/// bit for bit. About 110 bytes a pixel.
class ImageFlowSolver {
 public:
  /// Throws `SolverError` where A is not positive definite on the coarsest grid.
  explicit ImageFlowSolver(ImageFlowSystem system);
  ~ImageFlowSolver();
  ImageFlowSolver(ImageFlowSolver&&) noexcept;
  ImageFlowSolver& operator=(ImageFlowSolver&&) noexcept;

  /// Y from 0 towards A·Y = b until ‖b − A·Y‖ ≤ tolerance·‖b‖. Every iterate satisfies
  /// YᵀAY = Yᵀb, whence the scale of equation (4.8) is at least 1. Throws `SolverError` on a NaN.
  SolveReport solve(const FlowPlanes& b, FlowPlanes& Y, double tolerance, int max_cycles,
                    const Progress& progress = {}) const;

  /// A·Y.
  FlowPlanes times(const FlowPlanes& Y) const;

 private:
  struct Grid;
  struct Vectors;
  void cycle(std::size_t level, std::vector<Vectors>& work) const;
  void solve_coarsest(std::vector<Vectors>& work) const;

  std::vector<Grid> grids_;                   ///< finest first
  std::vector<std::vector<double>> inverse_;  ///< of the coarsest A: rows of a dense matrix
};

}  // namespace mq
