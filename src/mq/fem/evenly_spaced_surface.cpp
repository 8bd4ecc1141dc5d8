// Halved, made coarser, and each vertex of the finer one knows where it lies on the coarser one.

#include "mq/fem/evenly_spaced_surface.h"

#include <fmt/format.h>

#include <cmath>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/mesh/refine.h"

namespace mq {
namespace {

/// The triangles that have area, as nothing else is integrated.
Mesh with_area(const Surface& surface) {
  Mesh mesh;
  mesh.positions = surface.mesh.positions;
  for (int t = 0; t < surface.triangle_count(); ++t)
    if (!surface.degenerate[std::size_t(t)]) mesh.triangles.push_back(surface.mesh.triangles[std::size_t(t)]);
  return mesh;
}

}  // namespace

EvenlySpacedSurface::EvenlySpacedSurface(const Surface& surface, double spacing, const Progress& progress) {
  require(spacing > 0 && std::isfinite(spacing), fmt::format("vertices cannot be {} apart", spacing));
  // Of edges halved as they are longer than this the mean is about the spacing.
  constexpr double longest = 1.4;
  fine_ = make_surface(refined(with_area(surface), longest * spacing).mesh, {.kind = WeldOptions::Kind::none});
  progress.at(0.3);
  even_ = coarsen(fine_, spacing, progress.step("take vertices out", 0.7));
  space_ = std::make_unique<VertexSpace>(even_.surface);
  closest_ = std::make_unique<ClosestPointFinder>(fine_.mesh);
  progress.at(1);
}

double EvenlySpacedSurface::expected_size(const Surface& surface, double spacing) {
  return surface.area / (std::sqrt(0.75) * spacing * spacing);
}

Signal EvenlySpacedSurface::at(std::span<const Vector3> places, const Signal& psi, const Progress& progress) const {
  require(psi.rows() == space_->size(), "one row per vertex is needed");
  Signal on_fine = Signal::Zero(fine_.mesh.vertex_count(), psi.cols());
  parallel_for(on_fine.rows(), [&](std::int64_t v) {
    const ClosestPoint& place = even_.places[std::size_t(v)];
    if (place.triangle < 0) return;
    for (const auto& [unknown, weight] : space_->basis_at(place.triangle, place.barycentric))
      on_fine.row(v) += weight * psi.row(unknown);
  });
  progress.at(0.1);
  Signal values(std::ssize(places), psi.cols());
  parallel_for(std::ssize(places), [&](std::int64_t i) {
    const ClosestPoint point = (*closest_)(places[std::size_t(i)]);
    const Triangle& corners = fine_.mesh.triangles[std::size_t(point.triangle)];
    values.row(i) = interpolate(point.barycentric, [&](int k) { return on_fine.row(corners[std::size_t(k)]); });
  });
  progress.at(1);
  return values;
}

}  // namespace mq
