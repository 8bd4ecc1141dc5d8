#pragma once
/// One sweep of `sweep_heat`, in its two halves. Used inside this room.

#include <vector>

#include "mq/base/infinity.h"
#include "mq/filter/detail/falling_order.h"
#include "mq/filter/shared_unknowns.h"
#include "mq/linear/matrix.h"

namespace mq {

class HeatSweep {
 public:
  /// A row that never fits, as where the solution is not positive, counts for no more than so many
  /// tolerances.
  static constexpr double most_tolerances = 100;

  /// Of the own unknowns `met`; A, `log_u` and `shared` must outlive the object. Of several processes each keeps the
  /// order of them all, and carries on what others carried until nothing comes over any more.
  HeatSweep(const SparseMatrix& A, std::vector<int> met, std::vector<char> fixed, Vector& log_u,
            const SharedUnknowns& shared = SharedUnknowns::alone());

  /// c_i, and in what shares nearer neighbours carry theirs. Returns the mean of |c_i|, each at most `most`.
  double find_misses(double most);

  /// Carries the misses in the order of falling u, and adds what comes of it to log u.
  void carry();

 private:
  void find_miss(int i);
  void carry_own();
  void carry_of_others();
  void carry_touched(Vector& all);
  void touch_around(int i);

  const SparseMatrix& A_;
  const SharedUnknowns& shared_;
  std::vector<int> met_, beside_;  ///< what is swept, ascending; those of others beside
  std::vector<char> fixed_;
  Vector& log_u_;
  std::vector<float> shares_;  ///< per entry of A
  Vector delta_;
  std::vector<char> touched_;  ///< by what other processes carried
  double missed_ = 0;
  FallingOrder falling_;
};

/// When sweeps are enough.
class HeatSweepEnd {
 public:
  explicit HeatSweepEnd(double tolerance) : tolerance_(tolerance) {}

  /// By how much rows missed in one more of them.
  void add(double missed) { missed_.push_back(missed); }
  int sweeps() const { return int(missed_.size()); }
  double last() const { return missed_.empty() ? infinity : missed_.back(); }
  bool reached(int max_sweeps) const;

 private:
  double tolerance_;
  std::vector<double> missed_;
};

}  // namespace mq
