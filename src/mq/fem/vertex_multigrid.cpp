#include "mq/fem/vertex_multigrid.h"

#include "mq/base/stopwatch.h"
#include "mq/fem/vertex_hierarchy.h"

namespace mq {

SolverFactory vertex_multigrid_solver(std::span<const Vector3> positions,
                                      const MultigridOptions& options) {
  return [positions, options](const SparseMatrix& A, const Progress& progress) {
    const Stopwatch watch;
    Hierarchy hierarchy = vertex_hierarchy(A, positions, options, progress);
    return hierarchy_solver(std::move(hierarchy), watch.seconds());
  };
}

}  // namespace mq
