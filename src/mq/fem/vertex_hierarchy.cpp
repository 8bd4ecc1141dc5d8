#include "mq/fem/vertex_hierarchy.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mq/base/parallel.h"

namespace mq {

namespace {

/// Where vertices lie, and how far their closest neighbours are.
SurfacePoints points_of(const SparseMatrix& A, std::span<const Vector3> positions) {
  SurfacePoints points;
  points.positions = relative_positions(positions);
  points.spacing.resize(positions.size());
  parallel_for(std::ssize(positions), [&](std::int64_t i) {
    double least = std::numeric_limits<double>::infinity();
    for (SparseMatrix::InnerIterator entry(A, int(i)); entry; ++entry)
      if (entry.col() != i) least = std::min(least, (positions[i] - positions[entry.col()]).norm());
    points.spacing[i] = std::isfinite(least) ? float(least) : 0;
  });
  return points;
}

}  // namespace

std::vector<std::array<float, 3>> relative_positions(std::span<const Vector3> positions) {
  std::vector<std::array<float, 3>> relative(positions.size());
  parallel_for(std::ssize(positions), [&](std::int64_t i) {
    for (int k = 0; k < 3; ++k)
      relative[i][std::size_t(k)] = float(positions[i][k] - positions[0][k]);
  });
  return relative;
}

Hierarchy vertex_hierarchy(const SparseMatrix& A, std::span<const Vector3> positions,
                           const MultigridOptions& options, const Progress& progress) {
  require_square(A, std::ssize(positions));
  Hierarchy hierarchy(int(A.rows()), A.nonZeros(), options);
  if (A.rows() == 0) return hierarchy;
  SparseMatrix coarsest;
  hierarchy.add_graph_levels(A, points_of(A, positions), layout_without_stencils(int(A.rows())),
                             PatchSmoother::Kind::single, progress, coarsest);
  hierarchy.finish(coarsest);
  progress.at(1);
  return hierarchy;
}

}  // namespace mq
