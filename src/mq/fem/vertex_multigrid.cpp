#include "mq/fem/vertex_multigrid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mq/base/parallel.h"
#include "mq/base/stopwatch.h"
#include "mq/fem/hierarchy.h"

namespace mq {

namespace {

/// Where vertices lie, relative to the first, and how far their closest neighbours are.
SurfacePoints points_of(const SparseMatrix& A, std::span<const Vector3> positions) {
  SurfacePoints points;
  points.positions.resize(positions.size());
  points.spacing.resize(positions.size());
  parallel_for(std::ssize(positions), [&](std::int64_t i) {
    for (int k = 0; k < 3; ++k)
      points.positions[i][std::size_t(k)] = float(positions[i][k] - positions[0][k]);
    double least = std::numeric_limits<double>::infinity();
    for (SparseMatrix::InnerIterator entry(A, int(i)); entry; ++entry)
      if (entry.col() != i)
        least = std::min(least, (positions[i] - positions[entry.col()]).norm());
    points.spacing[i] = std::isfinite(least) ? float(least) : 0;
  });
  return points;
}

/// As the coarse levels of a texel system, from the first level on: points and the graph of the
/// matrix.
Hierarchy vertex_hierarchy(const SparseMatrix& A, std::span<const Vector3> positions,
                           const MultigridOptions& options, const Progress& progress) {
  Hierarchy hierarchy(A, std::ssize(positions), options);
  if (A.rows() == 0) return hierarchy;
  hierarchy.finish(A, hierarchy.add_graph_levels(A, points_of(A, positions),
                                                 layout_without_stencils(int(A.rows())),
                                                 Patches::Kind::single, progress));
  progress.at(1);
  return hierarchy;
}

}  // namespace

SolverFactory vertex_multigrid_solver(std::span<const Vector3> positions,
                                      const MultigridOptions& options) {
  return [positions, options](const SparseMatrix& A, const Progress& progress) {
    const Stopwatch watch;
    Hierarchy hierarchy = vertex_hierarchy(A, positions, options, progress);
    return hierarchy_solver(std::move(hierarchy), watch.seconds());
  };
}

}  // namespace mq
