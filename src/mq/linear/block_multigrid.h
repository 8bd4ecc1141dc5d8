#pragma once
/// Multigrid for symmetric matrices of 2 × 2 blocks: two unknowns at a point, turned on the way from
/// point to point.

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "mq/linear/dense.h"
#include "mq/linear/direct.h"
#include "mq/linear/solver.h"

namespace mq {

/// Compressed rows of 2 × 2 blocks (row by row), stored whole, columns ascending; every row has its
/// diagonal block.
template <class Real>
struct BlockMatrix {
  using Block = std::array<Real, 4>;
  std::vector<int> starts = {0};
  std::vector<int> columns;
  std::vector<Block> blocks;

  int rows() const { return int(starts.size()) - 1; }
};

/// The same entry by entry, 2·rows × 2·rows.
SparseMatrix scalar_matrix(const BlockMatrix<double>& A);

/// P: y_i = Σ_j w_ij·R_ij·x_j with rotations R_ij, a few terms a row.
struct BlockTransfer {
  struct Entry {
    int column;
    float cosine, sine;  ///< times the weight
  };
  int columns = 0;
  std::vector<int> starts = {0};
  std::vector<Entry> entries;
  /// Pᵀ: per column its rows, made by `finish`.
  std::vector<int> child_starts;
  std::vector<Entry> children;  ///< `column` is the row; cosine and sine are those of P

  int rows() const { return int(starts.size()) - 1; }
  void finish();
  Vector prolongated(const Vector& x) const;  ///< P·x
};

struct BlockMultigridOptions {
  double tolerance = 1e-6;  ///< stop when ‖b − A·x‖ ≤ tolerance · ‖b‖
  int max_cycles = 60;
  int sweeps = 2;  ///< of Gauss–Seidel by blocks, before and after each coarse solution
};

/// Conjugate gradients in double precision around a symmetric V-cycle in single precision, for
/// matrices that change while the levels stay: coarse matrices are PᵀAP, the last one is factored.
/// Rows are relaxed in coloured pieces of a few hundred, so that bits do not depend on the threads.
class BlockMultigrid {
 public:
  /// From the finest level to coarser ones; may be none (then it is a factorisation of A).
  explicit BlockMultigrid(std::vector<std::shared_ptr<const BlockTransfer>> transfers,
                          const BlockMultigridOptions& options = {});

  /// Takes A, symmetric and positive definite. Throws `NotPositiveDefinite`.
  void set_matrix(BlockMatrix<double> A, const Progress& progress = {});

  /// Gives A back, for the next one to be made of it. Nothing can be solved before that is set.
  BlockMatrix<double> take_matrix() { return std::move(finest_); }

  /// Improves x towards A·x = b. Throws `SolverError` where a value is not finite.
  SolveReport solve(const Vector& b, Vector& x, const Progress& progress = {}) const;

 private:
  struct Level {
    BlockMatrix<float> matrix;
    std::vector<std::array<float, 4>> inverses;  ///< of the diagonal blocks
    std::vector<int> pieces;                     ///< by colour
    std::vector<int> colours;
  };
  struct Vectors {
    std::vector<float> b, x, r;
  };

  static void order_pieces(Level& level);
  void relax(const Level& level, const Vectors& v, std::vector<float>& x, int direction) const;
  void cycle(std::size_t level, std::vector<Vectors>& vectors) const;

  std::vector<std::shared_ptr<const BlockTransfer>> transfers_;
  BlockMultigridOptions options_;
  BlockMatrix<double> finest_;
  std::vector<Level> levels_;
  DenseCholesky coarsest_;
  std::optional<DirectSolver> sparse_;  ///< in its place where the last level is large
  double scale_ = 1;  ///< of the matrices in single precision
};

}  // namespace mq
