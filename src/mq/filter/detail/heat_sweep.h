#pragma once
/// One sweep of `sweep_heat`, in its two halves. Used inside this room.

#include <vector>

#include "mq/base/infinity.h"
#include "mq/filter/detail/falling_order.h"
#include "mq/linear/matrix.h"

namespace mq {

class HeatSweep {
 public:
  /// A row that never fits, as where the solution is not positive, counts for no more than so many
  /// tolerances.
  static constexpr double most_tolerances = 100;

  /// Of the unknowns `met`; A and `log_u` must outlive the object.
  HeatSweep(const SparseMatrix& A, std::vector<int> met, std::vector<char> fixed, Vector& log_u);

  /// c_i, and in what shares nearer neighbours carry theirs. Returns the mean of |c_i|, each at most `most`.
  double find_misses(double most);

  /// Carries the misses in the order of falling u, and adds what comes of it to log u.
  void carry();

 private:
  void find_miss(int i);

  const SparseMatrix& A_;
  std::vector<int> met_;  ///< what is swept, ascending
  std::vector<char> fixed_;
  Vector& log_u_;
  std::vector<float> shares_;  ///< per entry of A
  std::vector<double> delta_;
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
