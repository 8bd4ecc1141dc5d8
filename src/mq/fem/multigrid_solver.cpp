#include "mq/fem/multigrid_solver.h"

#include "mq/base/stopwatch.h"
#include "mq/fem/texel_hierarchy.h"

namespace mq {

SolverFactory multigrid_solver(const Texels& texels, const MultigridOptions& options) {
  const auto make = [&texels, options](auto&& A, const Progress& progress) {
    const Stopwatch watch;
    Hierarchy hierarchy = texel_hierarchy(std::forward<decltype(A)>(A), texels, options, progress);
    return hierarchy_solver(std::move(hierarchy), watch.seconds());
  };
  return {SolverFactory::OfMatrix(make), SolverFactory::OfStencils(make)};
}

}  // namespace mq
