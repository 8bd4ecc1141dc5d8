#include "mq/fem/space.h"

#include "mq/base/error.h"
#include "mq/linear/direct_solver.h"

namespace mq {

namespace {

/// Entries of the factor per entry of A up to which a factorisation is worth it: surfaces need five to fifteen. Where
/// thousands of charts share their texels everything meets everything, and it would take minutes.
constexpr double most_fill = 40;

}  // namespace

SolverFactory SignalSpace::solver(const StoppingRule& stop) const {
  if (size() > most_for_factorisation) return multigrid(stop);
  return [cycles = multigrid(stop)](const SparseMatrix& A, const Progress& progress) -> std::unique_ptr<LinearSolver> {
    try {
      return direct_solver(Factorisation::automatic, std::int64_t(most_fill * double(A.nonZeros())))(A, progress);
    } catch (const OutOfMemory&) {
      return cycles(A, progress);
    }
  };
}

SolverFactory solver_or_own(const SolverFactory& given, const SignalSpace& space) {
  return given ? given : space.solver();
}

}  // namespace mq
