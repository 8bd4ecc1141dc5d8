#include "mq/linear/economical_solver.h"

#include "mq/linear/direct_solver.h"

namespace mq {

SolverFactory economical_solver(EconomicalOptions options) {
  return
      [options](const SparseMatrix& A, const Progress& progress) -> std::unique_ptr<LinearSolver> {
        const double most_entries = options.most_fill * double(A.nonZeros());
        try {
          return direct_solver(Factorisation::automatic, std::int64_t(most_entries))(A, progress);
        } catch (const OutOfMemory&) {
          return conjugate_gradient_solver(options.iterate)(A, progress);
        }
      };
}

}  // namespace mq
