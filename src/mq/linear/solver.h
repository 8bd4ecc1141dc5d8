#pragma once
/// The one interface of everything that solves A·X = B, direct or iterative.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mq/base/error.h"
#include "mq/base/progress.h"
#include "mq/linear/matrix.h"

namespace mq {

/// A solver was given a matrix that is not positive definite.
class NotPositiveDefinite : public SolverError {
 public:
  using SolverError::SolverError;
};

/// What a solve did. A solver that did not converge is a report, not an error.
struct SolveReport {
  std::string method;             ///< "direct (cholmod)", "multigrid", ...
  int cycles = 0;                 ///< iterations; 1 for a direct solve
  std::vector<double> residuals;  ///< ‖B − A·X‖ / ‖B − A·X₀‖, worst channel, from 1 at the guess X₀
  double error = 0;  ///< of an iterative solver: the largest that is left in X, estimated, relative to
                     ///< the largest value of X (see `ErrorEstimate`)
  bool converged = true;
  double setup_seconds = 0;
  double solve_seconds = 0;
};

/// When iterations stop: at a relative residual (and an error of about four times that, see
/// `ErrorEstimate`), or after so many cycles; unset: the solver's own limit.
struct StoppingRule {
  double tolerance = 1e-6;
  std::optional<int> max_cycles = {};
};

/// A solver's options with this rule in place of their own.
template <class SolverOptions>
SolverOptions stopping(const StoppingRule& stop, SolverOptions options = {}) {
  options.tolerance = stop.tolerance;
  options.max_cycles = stop.max_cycles.value_or(options.max_cycles);
  return options;
}

/// Of an equation whose solution is its first guess.
inline SolveReport nothing_to_solve() {
  return {.method = "none (nothing to change)", .residuals = {}};
}

/// Of several solutions the one that fell short, or the last.
inline SolveReport worst_of(const std::vector<SolveReport>& reports) {
  for (const SolveReport& report : reports)
    if (!report.converged) return report;
  return reports.empty() ? SolveReport{} : reports.back();
}

/// A prepared solver for one matrix A, symmetric and positive definite, or semidefinite where the
/// implementation says so. Holds no reference to A's storage unless it says so.
class LinearSolver {
 public:
  virtual ~LinearSolver() = default;

  /// Improves X (rows() × channels, on entry a first guess) towards A·X = B. Throws `SolverError` on
  /// NaN and `Cancelled`; the residual goes into the progress.
  virtual SolveReport solve(const Signal& B, Signal& X, const Progress& progress = {}) const = 0;

  /// Prepares for another matrix of the same pattern, reusing what does not depend on its values.
  virtual void update(const SparseMatrix& A, const Progress& progress = {}) = 0;
};

/// Makes a solver for a matrix. Throws `NotPositiveDefinite`, as `update` does.
using SolverFactory =
    std::function<std::unique_ptr<LinearSolver>(const SparseMatrix& A, const Progress& progress)>;

}  // namespace mq
