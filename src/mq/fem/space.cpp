#include "mq/fem/space.h"

#include <cmath>

#include "mq/base/error.h"
#include "mq/linear/direct_solver.h"

namespace mq {

namespace {

/// Operations up to which a factorisation is worth it, by the squares of the factor's columns: a second or so. Surfaces need
/// a tenth at `most_for_factorisation`. Where thousands of charts share their texels everything meets everything, and it
/// would take minutes.
constexpr double most_operations = 4e9;

}  // namespace

SolverFactory SignalSpace::solver(const StoppingRule& stop) const {
  if (size() > most_for_factorisation) return multigrid(stop);
  return [cycles = multigrid(stop)](const SparseMatrix& A, const Progress& progress) -> std::unique_ptr<LinearSolver> {
    try {
      const auto most_entries = std::int64_t(std::sqrt(most_operations * double(A.rows())));
      return direct_solver(Factorisation::automatic, most_entries)(A, progress);
    } catch (const OutOfMemory&) {
      return cycles(A, progress);
    }
  };
}

SolverFactory solver_or_own(const SolverFactory& given, const SignalSpace& space) {
  return given ? given : space.solver();
}

}  // namespace mq
