#pragma once
/// The symmetric V-cycle over levels that someone else has made.

#include <memory>
#include <optional>
#include <vector>

#include "mq/linear/dense.h"
#include "mq/linear/direct.h"
#include "mq/linear/lanes.h"
#include "mq/linear/detail/patches.h"
#include "mq/linear/stencil_matrix.h"
#include "mq/linear/transfer.h"

namespace mq {

/// One level above the coarsest: its matrix in single precision, how its irregular rows are
/// relaxed, and the way to the next coarser level.
struct MultigridLevel {
  StencilLayout layout;
  StencilMatrix matrix;
  PatchSmoother patches;
  std::unique_ptr<LevelTransfer> transfer;
  /// Unknowns that the matrix has in another unit than the transfer: x of the matrix is `weight`
  /// times x of the transfer (see `Scaling`).
  std::vector<WeightedIndex> rescaled;
};

/// Multiplies some rows of v (rows × lanes) by their weights, or divides where `power` is below 0.
void rescale(const std::vector<WeightedIndex>& rows, int lanes, float* v, int power);

/// The coarsest level, solved directly in double precision: densely where it is as small as it
/// should be, as its rows hold too many entries for sparse factors to gain anything. Components on
/// which the matrix vanishes on constants are pinned at one unknown, which solves a consistent
/// system.
class CoarsestLevel {
 public:
  CoarsestLevel() = default;

  /// `singular` has one flag per component, `component` one number per row.
  CoarsestLevel(SparseMatrix A, const std::vector<int>& component,
                const std::vector<char>& singular);

  int rows() const { return rows_; }
  void solve(int lanes, const float* b, float* x) const;
  std::int64_t bytes() const;

 private:
  static constexpr int most_dense_rows = 1000;

  int rows_ = 0;
  std::optional<DirectSolver> sparse_;
  DenseCholesky dense_;
};

struct CycleOptions {
  int sweeps = 2;  ///< of every tile and of single rows, before and after the coarse solve
  int patch_passes = 1;  ///< over patches that are solved exactly: a second one gains nothing
  /// The levels from this one on are walked through twice per cycle, with what the first walk left.
  /// They hold a twentieth of all rows, and the waves that are hardest to have on points.
  int twice_from = 2;
};

/// x = C·b with C ≈ A⁻¹ symmetric and positive definite, so that conjugate gradients may use it:
/// each level relaxes its stencils and then its patches, hands the residual to the next, adds the
/// correction, and undoes its relaxations in the opposite order. The same bits for any number of
/// threads.
class Multigrid {
 public:
  std::vector<std::unique_ptr<MultigridLevel>> levels;  ///< finest first; may be empty
  CoarsestLevel coarsest;
  CycleOptions options;

  /// The vectors of one cycle, made once and used by many.
  class Workspace {
   public:
    Workspace(const Multigrid& multigrid, int lanes);

   private:
    friend class Multigrid;
    struct Vectors {
      LaneVector b, x, r;
    };
    std::vector<Vectors> levels_;  ///< entry 0 has r only; the last is the coarsest level
    int lanes_;
  };

  /// One cycle from x = 0. b and x are rows × lanes of the workspace (see `LaneVector`).
  void cycle(const float* b, float* x, Workspace& workspace) const;

  /// Passes over the patches of a level, before and after the coarse solve. A second one over patches that
  /// are solved exactly costs more than it gains (a fifth of the cycle at 28 charts, a third at 3,000), but
  /// where they are nearly all of a level, as in charts of a few texels.
  int passes_over_patches(std::size_t level) const;

  int rows() const { return levels.empty() ? coarsest.rows() : levels.front()->layout.rows; }
  std::int64_t bytes() const;

 private:
  enum class Guess { zero, given };

  void descend(std::size_t level, Guess guess, const float* b, float* x,
               Workspace& workspace) const;
};

}  // namespace mq
