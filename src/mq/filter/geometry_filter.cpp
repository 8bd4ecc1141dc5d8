// The signals are the coordinates of positions, or of unit normals; the space is that of the hat
// functions, in the metric of the surface or in ⟨A, B⟩ + ℓ² ⟨dN(A), dN(B)⟩, with N smoothed first.

#include "mq/filter/geometry_filter.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/fem/field_metric.h"
#include "mq/filter/detail/vector_signal.h"
#include "mq/filter/modulation.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/norm.h"

namespace mq {
namespace {

/// Smooths or sharpens unit vectors at the vertices in a space.
std::pair<std::vector<Vector3>, SolveReport> filtered(const VertexSpace& space,
                                                      std::vector<Vector3> normals, double weight,
                                                      double beta, const SolverFactory& factory,
                                                      const Progress& progress) {
  if (beta == 1 || weight == 0) return {std::move(normals), nothing_to_solve()};
  const ScreenedPoisson equation(space, weight, factory, progress.step("prepare", 0.7));
  const Filtered found = equation.solve(as_signal(normals), beta, progress.step("solve", 0.3));
  parallel_for(std::ssize(normals), [&](std::int64_t v) {
    const Vector3 unit = safe_unit(found.signal.row(v).transpose());
    if (!unit.isZero(0)) normals[v] = unit;
  });
  return {std::move(normals), found.report};
}

void require_sound(const GeometryFilterOptions& options) {
  require(options.crease_length >= 0 && std::isfinite(options.crease_length),
          fmt::format("the length across creases is {}; it must be finite and not negative",
                      options.crease_length));
  require(options.crease_alpha >= 0 && std::isfinite(options.crease_alpha),
          fmt::format("the smoothing of normals is {}; it must be finite and not negative",
                      options.crease_alpha));
}

void require_mask(const Surface& surface, const GeometryFilterOptions& options) {
  require(options.mask.empty() || std::ssize(options.mask) == surface.mesh.vertex_count(),
          fmt::format("a mask of {} values was given for {} vertices", options.mask.size(),
                      surface.mesh.vertex_count()));
}

/// The shapes of triangles in the metric asked for.
std::vector<FlatTriangle> shapes(const Surface& surface, const std::vector<Vector3>& normals,
                                 const GeometryFilterOptions& options,
                                 const SolverFactory& factory, const Progress& progress) {
  if (options.crease_length == 0) return flat_triangles(surface);
  const VertexSpace space(surface);
  const std::vector<Vector3> smooth =
      filtered(space, normals, options.crease_alpha * space.scale().area, 0, factory, progress).first;
  return shapes_across_creases(surface, smooth, options.crease_length);
}

}  // namespace

FilteredNormals filter_normals(const Surface& surface, const GeometryFilterOptions& options,
                               const SolverFactory& factory, const Progress& progress) {
  require_sound(options);
  const double share = options.crease_length > 0 ? 0.5 : 0;
  const std::vector<Vector3> before = vertex_normals(surface.mesh);
  const VertexSpace space(
      surface, shapes(surface, before, options, factory, progress.step("creases", share)));
  auto [after, report] = filtered(space, before, options.weight, options.beta, factory,
                                  progress.step("normals", 1 - share));
  std::vector<Vector3> of_triangles = filtered_with(
      space, triangle_normals(surface.mesh), {before, after, options.weight, options.beta});
  return {std::move(after), std::move(of_triangles), std::move(report)};
}

Reshaped filter_positions(const Surface& surface, const GeometryFilterOptions& options,
                          const SolverFactory& factory, const Progress& progress) {
  require_sound(options);
  require_mask(surface, options);
  const double share = options.crease_length > 0 ? 0.5 : 0;
  const VertexSpace space(with_fans_joined(surface),
                          shapes(surface, vertex_normals(surface.mesh), options, factory,
                                 progress.step("creases", share)));
  const ScreenedPoisson equation(space, options.weight, factory,
                                 progress.step("prepare", 0.7 * (1 - share)));
  const Signal positions = as_signal(surface.mesh.positions);
  const Progress solve = progress.step("solve", 0.3 * (1 - share));
  Filtered found = options.mask.empty()
                       ? equation.solve(positions, options.beta, solve)
                       : equation.solve(positions, modulation(options.mask, options.beta), solve);
  const std::vector<int> joined = joined_fans(surface);
  Reshaped result{std::vector<Vector3>(joined.size()), std::move(found.report)};
  for (std::size_t v = 0; v < joined.size(); ++v)
    result.positions[v] = found.signal.row(joined[v]).transpose();
  return result;
}

}  // namespace mq
