#include "mq/flow/surface_registration.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/fem/vertex_space.h"
#include "mq/flow/surface_levels.h"
#include "mq/mesh/geometry.h"
#include "mq/trace/surface_flow.h"

namespace mq {

namespace {

Eigen::RowVectorXd at(const Mesh& mesh, const Signal& signal, const SurfacePoint& p) {
  const Triangle& v = mesh.triangles[p.triangle];
  return interpolate(p.barycentric, [&](int k) { return signal.row(v[k]); });
}

/// The smaller eigenvalue of Σ_c ∇φ_c ∇φ_cᵀ, averaged over the triangles around each vertex.
/// Vectors of neighbouring triangles are compared as they lie in space.
Vector weaker_slope(const Surface& surface, const VertexSpace& space, const Signal& signal) {
  const Signal gradients = space.gradient(signal);
  std::vector<Eigen::Matrix3d> around(surface.mesh.positions.size(), Eigen::Matrix3d::Zero());
  Vector areas = Vector::Zero(std::ssize(around));
  for (Eigen::Index c = 0; c < signal.cols(); ++c) {
    const std::vector<Vector3> field = field_in_space(surface, gradients.col(c));
    for (int t = 0; t < surface.triangle_count(); ++t)
      for (const int v : surface.mesh.triangles[t]) {
        const double area = space.shapes()[t].area();
        around[v] += area * field[t] * field[t].transpose();
        if (c == 0) areas[v] += area;
      }
  }
  // Of the three eigenvalues the smallest belongs to the normal.
  Vector weaker(std::ssize(around));
  parallel_for(weaker.size(), [&](std::int64_t v) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(around[v], Eigen::EigenvaluesOnly);
    weaker[v] = areas[v] > 0 ? std::max(0.0, solver.eigenvalues()[1]) / areas[v] : 0;
  });
  return weaker;
}

}  // namespace

ColourRegistrar::ColourRegistrar(const Surface& target, const Signal& target_colours,
                                 const MeshFlowOptions& options, const Progress& progress)
    : target_(target),
      colours_(target_colours),
      flow_(target, options, progress),
      on_target_(target.mesh) {
  require(
      colours_.rows() == target.mesh.vertex_count() && colours_.allFinite(),
      fmt::format("{} rows of colours were given for {} vertices of the target, or some are not "
                  "finite",
                  colours_.rows(), target.mesh.vertex_count()));
  slopes_ = weaker_slope(target, flow_.finest().space(), colours_);
  mean_slope_ = slopes_.mean();
  const Eigen::RowVectorXd mean = colours_.colwise().mean();
  variance_ = (colours_.rowwise() - mean).squaredNorm() / double(colours_.rows());
}

std::vector<double> ColourRegistrar::confidences(const Surface& source,
                                                 const Signal& source_colours,
                                                 const ColourRegistration& found) const {
  const std::vector<Vector3> source_normals = vertex_normals(source.mesh);
  const std::vector<Vector3> target_normals = triangle_normals(target_.mesh);
  std::vector<double> result(source.mesh.positions.size(), 0.0);
  parallel_for(std::ssize(result), [&](std::int64_t v) {
    const SurfacePoint& p = found.points[v];
    const double difference = (at(target_.mesh, colours_, p) - source_colours.row(v)).squaredNorm();
    const double known = at(target_.mesh, slopes_, p)[0];
    const double facing = source_normals[v].dot(target_normals[found.closest[v].triangle]);
    if (variance_ > 0 && mean_slope_ > 0)
      result[v] = variance_ / (variance_ + difference) * known / (known + mean_slope_) *
                  std::max(0.0, facing);
  });
  return result;
}

ColourRegistration ColourRegistrar::operator()(const Surface& source, const Signal& source_colours,
                                               const Progress& progress) const {
  require(
      source_colours.rows() == source.mesh.vertex_count() && source_colours.allFinite(),
      fmt::format("{} rows of colours were given for {} vertices of the source, or some are not "
                  "finite",
                  source_colours.rows(), source.mesh.vertex_count()));
  require(colours_.cols() == source_colours.cols(),
          fmt::format("the source has {} channels and the target {}", source_colours.cols(),
                      colours_.cols()));
  ColourRegistration result;

  // Step 2: the source's colours on the target.
  const ClosestPointFinder on_source(source.mesh);
  const std::vector<ClosestPoint> seen =
      on_source(target_.mesh.positions, progress.step("project", 0.1));
  Signal projected(target_.mesh.vertex_count(), source_colours.cols());
  parallel_for(projected.rows(), [&](std::int64_t v) {
    projected.row(v) = at(source.mesh, source_colours, seen[v]);
  });

  // Step 3: align them. Step 4: move the closest points.
  result.flow = flow_(projected, colours_, progress.step("flow", 0.7));
  const std::vector<ClosestPoint> closest =
      on_target_(source.mesh.positions, progress.step("closest points", 0.1));
  for (const ClosestPoint& p : closest) result.closest.push_back(p);
  result.points = SurfaceFlow::along(flow_.finest().trace(), result.flow.field)
                      .trace(result.closest, 1, progress.step("move", 0.1))
                      .ends;
  result.confidences = confidences(source, source_colours, result);
  return result;
}

ColourRegistration register_by_colour(const Surface& source, const Signal& source_colours,
                                      const Surface& target, const Signal& target_colours,
                                      const MeshFlowOptions& options, const Progress& progress) {
  const ColourRegistrar registrar(target, target_colours, options, progress.step("prepare", 0.2));
  return registrar(source, source_colours, progress.step("register", 0.8));
}

}  // namespace mq
