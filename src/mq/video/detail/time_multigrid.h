#pragma once
/// Multigrid for frames that are coupled in time.

#include <deque>
#include <functional>
#include <vector>

#include "mq/linear/conjugate_gradients.h"
#include "mq/linear/solver.h"
#include "mq/video/detail/time_links.h"

namespace mq {

/// One frame of a system in space and time: K, symmetric and positive definite, and how its
/// unknowns hang on those of the frame before.
struct TimePlane {
  SparseMatrix K;
  TimeLinks links;  ///< no rows in the first frame
  Vector strength;  ///< per unknown d, 0 or more; what is not linked has none
};

/// Z ≈ B⁻¹·R for the matrix of one frame; as a `Preconditioner` must be.
using PlaneSolver = std::function<Preconditioner(int frame, const SparseMatrix& B)>;

/// One V-cycle of texel multigrid per call, for the frames' texels; `texels(f)` must live as long.
PlaneSolver texel_planes(std::function<const Texels&(int frame)> texels);

/// A factorisation.
PlaneSolver factored_planes();

struct TimeMultigridOptions {
  double tolerance = 1e-6;  ///< stop when ‖B − A·X‖ ≤ tolerance · ‖B − A·X₀‖ in every channel
  int max_cycles = 60;
  int sweeps = 2;        ///< of all frames on the coarsest level
  int most_levels = 30;  ///< 1: no coarsening
};

/// A = blockdiag(K_f) + Σ_f T_f, with
///
///     φᵀ·T_f·φ = Σ_t d_t |φ_f(t) − Σ_s w_ts φ_{f−1}(s)|²,
///
/// symmetric and positive definite. Unknowns are those of the first frame, then those of the
/// second, and so on.
///
/// The cycle relaxes whole frames, even ones and then odd ones, each by a plane solver of its block
/// of A; what remains varies slowly in time, and is solved for on every second frame. In between it
/// is interpolated along the links, linearly. T is coarsened as PᵀTP; K_f of a frame that stays
/// counts as often as there are frames that it stands for, two, but where texels are added and
/// removed and at both ends. So planes keep their stencils and a coarse plane couples to two others
/// as a fine one does. Levels end where frames hang together less than half as strongly as the K
/// are large: relaxation is all it takes there. So neither strong nor weak links nor smooth nor
/// rough K slow it down: with exact planes and equal frames the relaxation is cyclic reduction.
///
/// The same bits for any number of threads.
class TimeMultigrid {
 public:
  /// Takes the planes' matrices. Throws `InvalidInput` where sizes do not agree, and what the plane
  /// solvers throw.
  TimeMultigrid(std::vector<TimePlane> planes, const PlaneSolver& solver,
                const TimeMultigridOptions& options = {}, const Progress& progress = {});

  /// Z = C·R with C ≈ A⁻¹ symmetric and positive definite. One at a time: vectors are kept from one
  /// to the next.
  void cycle(const Signal& R, Signal& Z) const;

  /// Conjugate gradients around the cycle. Throws as `conjugate_gradients`.
  SolveReport solve(const Signal& B, Signal& X, const Progress& progress = {}) const;

  const SparseMatrix& matrix() const { return levels_.front().A; }
  int offset(int frame) const { return levels_.front().offsets[frame]; }
  int level_count() const { return int(levels_.size()); }

 private:
  struct Level {
    SparseMatrix A;
    std::vector<int> offsets = {0};  ///< of the frames' first unknowns, and the end
    std::vector<Preconditioner> planes;
    SparseMatrix P, R;  ///< from the coarser level, and its transpose; empty on the coarsest
    mutable Signal residual, below, correction, change;  ///< of a cycle, kept for the next
    int frames() const { return int(planes.size()); }
  };

  void relax(const Level& level, int parity, const Signal& b, Signal& x) const;
  void descend(std::size_t level, const Signal& b, Signal& x) const;

  std::deque<Level> levels_;
  TimeMultigridOptions options_;
};

}  // namespace mq
