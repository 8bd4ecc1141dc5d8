// Where unknowns lie, which are at the boundary, and what of a signal the surface shows.

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/fem/detail/shown_places.h"
#include "mq/fem/multigrid_solver.h"
#include "mq/fem/detail/texel_space_data.h"

namespace mq {
namespace {

/// Weights below this do not count at a boundary.
constexpr double least_weight = 1e-3;

double larger(double largest, double value) {
  return std::isfinite(value) ? std::max(largest, value) : largest;
}

}  // namespace

std::vector<Vector3> TexelSpace::positions() const {
  require(std::ssize(texels().positions) == size(), "the positions of this space were let go of; integrate again");
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
  data_->require_integrals();
  double largest = 0;
  for_each_shown(
      data_->surface, data_->atlas, *this, [&](int i) { largest = larger(largest, values[i]); },
      [&](int triangle, const Vector3& barycentric) {
        double sum = 0;
        for (const BasisWeight& w : basis_at(triangle, barycentric)) sum += w.weight * values[w.unknown];
        largest = larger(largest, sum);
      });
  return largest;
}

SolverFactory TexelSpace::multigrid(const StoppingRule& stop) const {
  return multigrid_solver(texels(), stopping<MultigridOptions>(stop));
}

}  // namespace mq
