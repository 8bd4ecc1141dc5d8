#pragma once
/// A sparse system of few rows per process, factored by all of them together (MUMPS).

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "mq/linear/matrix.h"
#include "petsc.h"
#include "processes.h"

namespace mq::shared {

/// An entry of a row; columns are numbers among those of all processes.
struct RowEntry {
  std::int64_t column = 0;
  double value = 0;
};

class DirectSystem {
 public:
  /// Symmetric and positive definite. This process has `count` rows, which follow those of the processes before it;
  /// `row(k)` are the entries of one. Every process must call it, and `solve`. Throws `InvalidInput` where there are
  /// more rows than PETSc's numbers count, `SolverError` for errors of PETSc.
  DirectSystem(const Processes& processes, int count, const std::function<std::vector<RowEntry>(int)>& row);

  /// Of all processes.
  std::int64_t rows() const { return total_; }

  /// X of the own rows, for their rows of B.
  Signal solve(const Signal& B) const;

 private:
  OwnedMat matrix_;
  OwnedPC factor_;
  OwnedVec x_, b_;
  std::int64_t total_ = 0;
};

}  // namespace mq::shared
