// (M + w·S)·(p − p₀) = w·Gᵀ M₁ (∇(p_k − p₀) − ⟨∇p_k, n⟩ n),   p_0 = p₀, p_{k+1} ← p.
//
// In the frame e₁, e₂ of a triangle in space ∇p₀ has the rows e₁ᵀ, e₂ᵀ, whose part along the own
// normal is 0 but for rounding: it is left out, so that what has its own normals stays bit for bit.

#include "mq/filter/normal_fit.h"

#include <fmt/format.h>

#include <cmath>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/filter/detail/vector_signal.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/norm.h"

namespace mq {
namespace {

/// Normals whose sum is shorter than this say nothing about where it points.
constexpr double least_sum = 3e-6;

/// Half of Σ |e|² / area² of a triangle times 3, see `filtered_with`.
double rate_of(const FlatTriangle& shape) {
  double squares = 0;
  for (int k = 0; k < 3; ++k) squares += shape.edge(k).squaredNorm();
  return 1.5 * squares / (shape.area() * shape.area());
}

/// (1 + β·x) / (1 + x), also for x without end.
double gain(double beta, double x) { return beta + (1 - beta) / (1 + x); }

}  // namespace

std::vector<int> joined_fans(const Surface& surface) {
  std::vector<int> joined(surface.mesh.positions.size());
  for (std::size_t v = 0; v < joined.size(); ++v)
    joined[v] = surface.vertex_from_source[std::size_t(surface.source_from_vertex[v])];
  return joined;
}

Surface with_fans_joined(const Surface& surface) {
  Surface result;
  result.mesh.positions = surface.mesh.positions;
  result.mesh.triangles = surface.mesh.triangles;
  result.degenerate = surface.degenerate;
  result.area = surface.area;
  const std::vector<int> joined = joined_fans(surface);
  for (Triangle& triangle : result.mesh.triangles)
    for (int& v : triangle) v = joined[std::size_t(v)];
  return result;
}

std::vector<Vector3> filtered_with(const VertexSpace& space, std::vector<Vector3> own,
                                   const NormalChange& change) {
  require(std::ssize(own) == space.triangle_count() &&
              std::ssize(change.before) == space.size() && change.before.size() == change.after.size(),
          fmt::format("{} normals of triangles, {} and {} at vertices were given for {} triangles and "
                      "{} vertices",
                      own.size(), change.before.size(), change.after.size(), space.triangle_count(),
                      space.size()));
  if (change.beta == 1 || change.weight == 0) return own;
  parallel_for(std::ssize(own), [&](std::int64_t t) {
    const FlatTriangle& shape = space.shapes()[std::size_t(t)];
    if (shape.empty()) return;
    Vector3 before = Vector3::Zero(), after = Vector3::Zero();
    for (const int v : space.triangles()[std::size_t(t)]) {
      before += change.before[std::size_t(v)];
      after += change.after[std::size_t(v)];
    }
    const Vector3 sum =
        after + gain(change.beta, change.weight * rate_of(shape)) * (3 * own[t] - before);
    if (sum.norm() > least_sum) own[t] = safe_unit(sum);
  });
  return own;
}

NormalFit::NormalFit(const Surface& surface, double alpha, const SolverFactory& factory,
                     const Progress& progress)
    : joined_(joined_fans(surface)),
      positions_(as_signal(surface.mesh.positions)),
      own_(triangle_normals(surface.mesh)) {
  require(alpha >= 0 && std::isfinite(alpha),
          fmt::format("the weight of a fit to normals is {}; it must be finite and not negative",
                      alpha));
  space_ = std::make_unique<VertexSpace>(with_fans_joined(surface));
  equation_ =
      std::make_unique<ScreenedPoisson>(*space_, alpha * space_->scale().area, factory, progress);
}

Reshaped NormalFit::fit(std::span<const Vector3> normals, int steps,
                        const Progress& progress) const {
  require(std::ssize(normals) == space_->triangle_count(),
          fmt::format("{} normals were given for {} triangles", normals.size(),
                      space_->triangle_count()));
  require(steps >= 1, fmt::format("a fit to normals takes at least one step; {} were asked for",
                                  steps));
  for (std::size_t t = 0; t < normals.size(); ++t)
    require(normals[t].allFinite(), fmt::format("the normal of triangle {} is not finite", t));
  Filtered found{positions_, {}};
  for (int k = 0; k < steps; ++k) {
    const Progress step = progress.step(fmt::format("fit {}", k + 1), 1.0 / steps);
    const Signal moved = found.signal - positions_;
    Signal change = space_->gradient(moved);
    const Signal gradient = space_->gradient(found.signal);
    parallel_for(std::ssize(normals), [&](std::int64_t t) {
      const Vector3 n = safe_unit(normals[t]);
      const Signal& seen = normals[t] == own_[std::size_t(t)] ? change : gradient;
      for (Eigen::Index i = 2 * t; i < 2 * t + 2; ++i) {
        const Vector3 row = seen.row(i).transpose();
        change.row(i) -= (row.dot(n) * n).transpose();
      }
    });
    found = equation_->solve_change(positions_, space_->gradient_moments(change), step);
  }
  Reshaped result{std::vector<Vector3>(joined_.size()), std::move(found.report)};
  for (std::size_t v = 0; v < joined_.size(); ++v)
    result.positions[v] = found.signal.row(joined_[v]).transpose();
  return result;
}

}  // namespace mq
