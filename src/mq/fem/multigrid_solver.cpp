#include "mq/fem/multigrid_solver.h"

#include "mq/base/stopwatch.h"
#include "mq/fem/texel_hierarchy.h"

namespace mq {

SolverFactory multigrid_solver(const Texels& texels, const MultigridOptions& options) {
  return [&texels, options](const SparseMatrix& A, const Progress& progress) {
    const Stopwatch watch;
    Hierarchy hierarchy = texel_hierarchy(A, texels, options, progress);
    return hierarchy_solver(std::move(hierarchy), watch.seconds());
  };
}

}  // namespace mq
