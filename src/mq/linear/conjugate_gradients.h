#pragma once
/// Preconditioned conjugate gradients, all channels at once.

#include <functional>
#include <span>
#include <vector>

#include "mq/linear/solver.h"

namespace mq {

/// Z ≈ A⁻¹·R: symmetric positive definite, linear, the same for every call. Z has R's shape and is
/// to be overwritten.
using Preconditioner = std::function<void(const Signal& R, Signal& Z)>;

/// Z = R / diag(A). Throws `SolverError` naming the first row whose diagonal is not positive.
Preconditioner jacobi_preconditioner(const SparseMatrix& A);

struct ConjugateGradientOptions {
  double tolerance = 1e-10;  ///< stop when ‖B − A·X‖ ≤ tolerance · ‖B − A·X₀‖ in every channel
  int max_cycles = 1000;

  /// For a semidefinite A whose null space are the functions constant on each component: the
  /// component of every unknown, 0, 1, ... Empty: A is definite. The residual is kept orthogonal to
  /// those constants (what B holds of them has no solution and is dropped), and each component of
  /// the result keeps the sum over its unknowns that the first guess had.
  std::vector<int> components = {};

  /// What is asked for beside the tolerance of the residual.
  enum class Stop {
    residual,       ///< nothing
    residual_error  ///< that `ErrorEstimate` finds the error small enough
  } stop = Stop::residual;
};

/// A matrix that is known by its products alone, perhaps with rows spread over processes: then all of them solve at
/// once, each with its own rows of B and X.
struct SharedSystem {
  std::function<void(const Signal& X, Signal& AX)> multiply;
  /// The sums and the largest of the values of all processes, in place and the same in each; empty: there is one.
  std::function<void(std::span<double> values)> sum = {}, largest = {};
};

/// Improves X towards A·X = B. Every channel has a step length of its own, so channels do not
/// disturb one another; one product with A and one call of the preconditioner serve them all.
///
/// A symmetric positive (semi)definite, n × n; B and X n × channels. Costs one product, one
/// preconditioner and six vector passes a cycle; four vectors of storage. Equal bits for any number
/// of threads if the preconditioner's are. Throws `SolverError` where A or the preconditioner turns
/// out not to be positive (naming the cycle) or a value is not finite, and `Cancelled`.
///
/// Hestenes and Stiefel [hestenes1952conjugate]; the report's residuals are those of the
/// recurrence, the last one is computed from X.
SolveReport conjugate_gradients(const SparseMatrix& A, const Signal& B, Signal& X,
                                const Preconditioner& precondition,
                                const ConjugateGradientOptions& options = {},
                                const Progress& progress = {});

/// The same for a system known by its products. Components are for one process.
SolveReport conjugate_gradients(const SharedSystem& system, const Signal& B, Signal& X,
                                const Preconditioner& precondition,
                                const ConjugateGradientOptions& options = {},
                                const Progress& progress = {});

/// The same as a `LinearSolver`, with the Jacobi preconditioner. Keeps a copy of A.
SolverFactory conjugate_gradient_solver(ConjugateGradientOptions options = {});

}  // namespace mq
