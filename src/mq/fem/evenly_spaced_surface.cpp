// Halved, made coarser, and each vertex of the finer one knows where it lies on the coarser one.

#include "mq/fem/evenly_spaced_surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/mesh/components.h"
#include "mq/mesh/refine.h"
#include "mq/mesh/space_order.h"

namespace mq {
namespace {

/// The triangles that have area, as nothing else is integrated, and what `of_triangles` says of each.
Mesh with_area(const Surface& surface, const std::vector<int>& of_triangles, std::vector<int>& of_these) {
  Mesh mesh;
  mesh.positions = surface.mesh.positions;
  for (int t = 0; t < surface.triangle_count(); ++t) {
    if (surface.degenerate[std::size_t(t)]) continue;
    mesh.triangles.push_back(surface.mesh.triangles[std::size_t(t)]);
    of_these.push_back(of_triangles[std::size_t(t)]);
  }
  return mesh;
}

}  // namespace

EvenlySpacedSurface::EvenlySpacedSurface(const Surface& surface, double spacing, const Progress& progress) {
  require(spacing > 0 && std::isfinite(spacing), fmt::format("vertices cannot be {} apart", spacing));
  // Of edges halved as they are longer than this the mean is about the spacing.
  constexpr double longest = 1.4;
  std::vector<int> components;
  const RefinedMesh halved = refined(with_area(surface, triangle_components(surface), components), longest * spacing);
  OrderedMesh ordered = in_space_order(halved.mesh);
  fine_ = make_surface(std::move(ordered.mesh), {.kind = WeldOptions::Kind::none});
  for (const int t : ordered.source) fine_components_.push_back(components[std::size_t(halved.source[std::size_t(t)])]);
  is_connected_ = std::ranges::all_of(fine_components_, [&](int c) { return c == fine_components_.front(); });
  progress.at(0.3);
  even_ = coarsen(fine_, spacing, progress.step("take vertices out", 0.7));
  space_ = std::make_unique<VertexSpace>(even_.surface);
  std::vector<int> of_fine_vertex(fine_.mesh.positions.size(), -1);
  for (int t = 0; t < fine_.triangle_count(); ++t)
    for (const int v : fine_.mesh.triangles[std::size_t(t)]) of_fine_vertex[std::size_t(v)] = fine_components_[std::size_t(t)];
  for (const int v : even_.source) components_.push_back(of_fine_vertex[std::size_t(v)]);
  closest_ = std::make_unique<ClosestPointFinder>(fine_.mesh);
  progress.at(1);
}

double EvenlySpacedSurface::expected_size(const Surface& surface, double spacing) {
  return surface.area / (std::sqrt(0.75) * spacing * spacing);
}

ClosestPoint EvenlySpacedSurface::closest(const Places& places, std::size_t i) const {
  if (is_connected_ || places.components.empty() || places.components[i] < 0) return (*closest_)(places.points[i]);
  const ClosestPoint found =
      closest_->among(places.points[i], std::numeric_limits<double>::infinity(), [&](const ClosestPoint& point) {
        return fine_components_[std::size_t(point.triangle)] == places.components[i];
      });
  require(found.triangle >= 0, fmt::format("a surface has no component {}", places.components[i]));
  return found;
}

Signal EvenlySpacedSurface::at(const Places& places, const Signal& psi, const Progress& progress) const {
  require(psi.rows() == space_->size(), "one row per vertex is needed");
  Signal on_fine = Signal::Zero(fine_.mesh.vertex_count(), psi.cols());
  parallel_for(on_fine.rows(), [&](std::int64_t v) {
    const ClosestPoint& place = even_.places[std::size_t(v)];
    if (place.triangle < 0) return;
    for (const auto& [unknown, weight] : space_->basis_at(place.triangle, place.barycentric))
      on_fine.row(v) += weight * psi.row(unknown);
  });
  progress.at(0.1);
  Signal values(std::ssize(places.points), psi.cols());
  parallel_for(values.rows(), [&](std::int64_t i) {
    const ClosestPoint point = closest(places, std::size_t(i));
    const Triangle& corners = fine_.mesh.triangles[std::size_t(point.triangle)];
    values.row(i) = interpolate(point.barycentric, [&](int k) { return on_fine.row(corners[std::size_t(k)]); });
  });
  progress.at(1);
  return values;
}

}  // namespace mq
