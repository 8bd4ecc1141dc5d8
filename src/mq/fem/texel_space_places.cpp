// Where unknowns lie, which are at the boundary, and what of a signal the surface shows.

#include <algorithm>
#include <cmath>

#include "mq/atlas/coverage.h"
#include "mq/base/error.h"
#include "mq/fem/multigrid_solver.h"
#include "mq/fem/detail/texel_space_data.h"

namespace mq {
namespace {

/// Weights below this do not count at a boundary.
constexpr double least_weight = 1e-3;

/// Calls visit(triangle, barycentric) for points along the edges of triangles that have a chart and
/// no neighbour with one, `step` (model units) or less apart, their ends among them.
template <class Visit>
void for_each_boundary_point(const Surface& surface, const Atlas& atlas, double step,
                             const Visit& visit) {
  for (HalfEdge h = 0; h < 3 * surface.triangle_count(); ++h) {
    const int t = h / 3, k = h % 3, twin = surface.twins[std::size_t(h)];
    if (atlas.chart[t] < 0 || surface.degenerate[t]) continue;
    if (twin >= 0 && atlas.chart[twin / 3] >= 0) continue;
    const double length =
        (surface.mesh.position(t, (k + 1) % 3) - surface.mesh.position(t, k)).norm();
    const int steps = std::max(1, int(std::ceil(length / step)));
    for (int s = 0; s <= steps; ++s) {
      Vector3 barycentric = Vector3::Zero();
      barycentric[k] = 1 - double(s) / steps;
      barycentric[(k + 1) % 3] = double(s) / steps;
      visit(t, barycentric);
    }
  }
}

double larger(double largest, double value) {
  return std::isfinite(value) ? std::max(largest, value) : largest;
}

}  // namespace

std::vector<Vector3> TexelSpace::positions() const {
  std::vector<Vector3> positions;
  positions.reserve(std::size_t(size()));
  for (int i = 0; i < size(); ++i) positions.push_back(texels().position(i));
  return positions;
}

/// Those whose functions are above `least_weight` somewhere along it, looked at every half texel.
std::vector<int> TexelSpace::boundary() const {
  std::vector<int> unknowns;
  for_each_boundary_point(data_->surface, data_->atlas, scale().texel_spacing / 2,
                          [&](int triangle, const Vector3& barycentric) {
                            for (const BasisWeight& w : basis_at(triangle, barycentric))
                              if (w.weight > least_weight) unknowns.push_back(w.unknown);
                          });
  std::sort(unknowns.begin(), unknowns.end());
  unknowns.erase(std::unique(unknowns.begin(), unknowns.end()), unknowns.end());
  return unknowns;
}

double TexelSpace::largest_shown(const Vector& values) const {
  require(values.size() == size(), "one value per texel is needed");
  const Surface& surface = data_->surface;
  const Atlas& atlas = data_->atlas;
  double largest = 0;
  const std::vector<Coverage> coverage = texel_coverage(surface, atlas);
  for (int i = 0; i < size(); ++i) {
    const Texels::Place& at = texels().places[std::size_t(i)];
    if (coverage[std::size_t(at.texture)].triangle(at.x, at.y) >= 0)
      largest = larger(largest, values[i]);
  }
  const auto look_at = [&](int triangle, const Vector3& barycentric) {
    double sum = 0;
    for (const BasisWeight& w : basis_at(triangle, barycentric)) sum += w.weight * values[w.unknown];
    largest = larger(largest, sum);
  };
  for (int t = 0; t < surface.triangle_count(); ++t)
    for (int k = 0; k < 3 && atlas.chart[t] >= 0 && !surface.degenerate[t]; ++k)
      look_at(t, Vector3::Unit(k));
  for_each_boundary_point(surface, atlas, scale().texel_spacing / 2, look_at);
  return largest;
}

SolverFactory TexelSpace::multigrid(const StoppingRule& stop) const {
  return multigrid_solver(texels(), stopping<MultigridOptions>(stop));
}

}  // namespace mq
