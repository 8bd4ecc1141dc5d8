#pragma once
/// Direct factorisation as a `LinearSolver`.

#include "mq/linear/direct.h"
#include "mq/linear/solver.h"

namespace mq {

/// Makes solvers that factor A once and then, for every right-hand side,
///
///     X ← X + A⁻¹·(B − A·X),
///
/// so that a good first guess X costs nothing and sharpens the result (one step of iterative
/// refinement). The report has one cycle and the residuals {1, ‖B − A·X‖ / ‖B − A·X₀‖}; where the
/// guess solves the system exactly it has none, and X is untouched, bit for bit.
///
/// The solver keeps a copy of A. A must be symmetric positive definite; making the solver, and
/// `update`, throw what `DirectSolver` throws.
SolverFactory direct_solver(Factorisation kind = Factorisation::automatic,
                            std::int64_t most_entries = std::numeric_limits<std::int64_t>::max());

}  // namespace mq
