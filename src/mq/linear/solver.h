#pragma once
/// The one interface of everything that solves A·X = B, direct or iterative.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "mq/base/error.h"
#include "mq/base/progress.h"
#include "mq/linear/stencil_rows.h"

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

  /// The same with a matrix that is used up.
  virtual void take(StencilSystem&& A, const Progress& progress = {}) { update(A.matrix(), progress); }
};

/// Makes a solver for a matrix. Throws `NotPositiveDefinite`, as `update` does.
class SolverFactory {
 public:
  using OfMatrix = std::function<std::unique_ptr<LinearSolver>(const SparseMatrix& A, const Progress& progress)>;
  using OfStencils = std::function<std::unique_ptr<LinearSolver>(StencilSystem&& A, const Progress& progress)>;

  SolverFactory() = default;

  /// Any function that an `OfMatrix` may hold.
  template <class Make>
    requires(!std::is_same_v<std::remove_cvref_t<Make>, SolverFactory> && std::is_constructible_v<OfMatrix, Make>)
  SolverFactory(Make&& make) : of_matrix_(std::forward<Make>(make)) {}

  /// `of_stencils` makes the same solver of a matrix that is used up, so that it is never held twice.
  SolverFactory(OfMatrix of_matrix, OfStencils of_stencils)
      : of_matrix_(std::move(of_matrix)), of_stencils_(std::move(of_stencils)) {}

  explicit operator bool() const { return bool(of_matrix_); }
  bool takes_stencils() const { return bool(of_stencils_); }

  std::unique_ptr<LinearSolver> operator()(const SparseMatrix& A, const Progress& progress) const {
    return of_matrix_(A, progress);
  }
  std::unique_ptr<LinearSolver> operator()(StencilSystem&& A, const Progress& progress) const {
    return of_stencils_ ? of_stencils_(std::move(A), progress) : of_matrix_(A.matrix(), progress);
  }

 private:
  OfMatrix of_matrix_;
  OfStencils of_stencils_;
};

}  // namespace mq
