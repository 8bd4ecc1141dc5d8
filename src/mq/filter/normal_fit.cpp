// (M + w·S)·δ = w·(b − S·p₀),   b = Gᵀ M₁ (I − nnᵀ)∇p,   p ← p₀ + δ.
//
// In the frame e₁, e₂ of a triangle in space ∇p has the rows e₁ᵀ, e₂ᵀ while p = p₀; the projection
// takes ⟨∇p, n⟩ n off each. With that alone on the right-hand side, whatever has its own normals
// stays, bit for bit where they are exact.

#include "mq/filter/normal_fit.h"

#include <fmt/format.h>

#include <cmath>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/norm.h"

namespace mq {
namespace {

/// Normals whose mean is shorter than this say nothing about where it points.
constexpr double least_mean = 1e-6;

Signal as_signal(std::span<const Vector3> positions) {
  Signal signal(Eigen::Index(positions.size()), 3);
  for (std::size_t v = 0; v < positions.size(); ++v)
    signal.row(Eigen::Index(v)) = positions[v].transpose();
  return signal;
}

/// Takes ⟨∇p, n⟩ n off every row, or leaves that alone of it.
enum class Part { tangent, normal };
void keep(Part part, std::span<const Vector3> normals, Signal& gradient) {
  parallel_for(std::ssize(normals), [&](std::int64_t t) {
    const Vector3 n = safe_unit(normals[t]);
    for (int i = 0; i < 2; ++i) {
      const Vector3 row = gradient.row(2 * t + i).transpose();
      const Vector3 along = row.dot(n) * n;
      gradient.row(2 * t + i) =
          (part == Part::normal ? Vector3(-along) : Vector3(row - along)).transpose();
    }
  });
}

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

std::vector<Vector3> triangle_means(const Mesh& mesh, std::span<const Vector3> vertex_normals) {
  require(std::ssize(vertex_normals) == mesh.vertex_count(),
          fmt::format("{} normals were given for {} vertices", vertex_normals.size(),
                      mesh.vertex_count()));
  std::vector<Vector3> means(mesh.triangles.size());
  parallel_for(std::ssize(means), [&](std::int64_t t) {
    Vector3 sum = Vector3::Zero();
    for (const int v : mesh.triangles[t]) sum += safe_unit(vertex_normals[v]);
    means[t] = sum.norm() > 3 * least_mean ? safe_unit(sum) : Vector3(Vector3::Zero());
  });
  return means;
}

NormalFit::NormalFit(const Surface& surface, double alpha, const SolverFactory& factory,
                     const Progress& progress)
    : joined_(joined_fans(surface)), positions_(as_signal(surface.mesh.positions)) {
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
    Signal gradient = space_->gradient(found.signal);
    keep(k == 0 ? Part::normal : Part::tangent, normals, gradient);
    const Signal moments = space_->gradient_moments(gradient);
    found = k == 0 ? equation_->solve_change(positions_, moments, step)
                   : equation_->solve_towards(positions_, moments, step);
  }
  Reshaped result{std::vector<Vector3>(joined_.size()), std::move(found.report)};
  for (std::size_t v = 0; v < joined_.size(); ++v)
    result.positions[v] = found.signal.row(joined_[v]).transpose();
  return result;
}

}  // namespace mq
