#pragma once
/// Multigrid around a change: the cycle on some rows of a matrix, at a cost of those rows.

#include <cstdint>
#include <limits>
#include <vector>

#include <tbb/task_arena.h>

#include "mq/linear/multigrid.h"
#include "mq/linear/row_set.h"

namespace mq {

struct LocalSolveOptions {
  double error = 1e-3;  ///< of x: stop when the largest that is left is estimated to be no more
  int max_cycles = 8;
  std::int64_t enough = std::numeric_limits<std::int64_t>::max();  ///< updates from which on no further cycle begins
};

struct LocalSolve {
  int cycles = 0;
  double error = 0;          ///< the largest that is left in x, estimated
  std::int64_t updates = 0;  ///< how often a row of any level was relaxed
};

/// A_NN·x = b for a set N of rows of the finest level of a multigrid, x = 0 in the others.
///
/// The levels are those of the whole matrix: nothing is assembled for N. On each level are the rows
/// all of whose children are in the set of the finer one, so that what they correct stays within N
/// and the coarse matrices are exact: a cycle can only bring x nearer to the solution, as measured
/// by ⟨e, A·e⟩. Levels end where relaxation alone solves (mass outweighs stiffness), or where no
/// row is left. The same bits for any number of threads.
class LocalMultigrid {
 public:
  /// The multigrid must outlive it. Keeps three floats per row and lane of all levels. Lanes: 1, 4 or 8.
  LocalMultigrid(const Multigrid& multigrid, int lanes);

  /// Takes N. Costs about as much as a cycle. b and x become 0.
  void choose(const RowSet& rows);

  /// N, increasing.
  const std::vector<int>& rows() const { return levels_.front().rows; }

  int lanes() const { return lanes_; }

  /// b, to be set in the rows of N and nowhere else (rows × lanes, see `LaneVector`).
  float* right_hand_side() { return levels_.front().b.data(); }

  /// x, 0 outside N.
  const float* solution() const { return levels_.front().x.data(); }

  /// Solves from x = 0.
  LocalSolve solve(const LocalSolveOptions& options);

 private:
  struct Level {
    RowSet set;
    std::vector<int> rows;
    std::vector<RowSet::Segment> segments;  ///< the same rows
    StencilPart part;
    PatchSmoother::Within patches;
    std::vector<WeightedIndex> rescaled;
    LaneVector b, x, r;
    std::vector<int> runs_by_row, anisotropic_by_row;  ///< of the whole level
    bool dominated = false;                            ///< relaxation alone solves here
  };

  template <class Body>
  void run(std::int64_t rows, const Body& body);
  void choose_rows(const RowSet& rows);
  LocalSolve solve_rows(const LocalSolveOptions& options);
  void take_rows(std::size_t level);
  void coarsen(std::size_t level);
  void cycle(std::size_t level);
  void relax(std::size_t level, int sweeps, Order order);
  void relax_alone(std::size_t level, int position);
  enum class Cycle { first, later };
  template <class Body>
  void for_segments(const Level& level, const Body& body) const;
  void clear(LaneVector& v, const Level& level) const;
  double change_by(Cycle cycle);
  void keep_solution();

  const Multigrid& multigrid_;
  int lanes_;
  std::vector<Level> levels_;  ///< the last is the coarsest, which is solved as a whole if at all
  std::size_t last_ = 0;       ///< the last level in use
  LaneVector before_;          ///< x before the cycle, if that is not the first
  /// What a cycle leaves of the error: the last ratio of changes by two cycles, of this solve or
  /// the one before, and the larger of the last two.
  double ratio_ = 0.5, rate_ = 0.5;
  std::int64_t updates_ = 0;
  tbb::task_arena one_thread_{1};
};

}  // namespace mq
