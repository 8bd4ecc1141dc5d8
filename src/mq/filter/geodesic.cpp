// w = −√t·log u with (M + t·S)·u = 0 off the sources;  S·φ = ∫ ⟨∇w/|∇w|, ∇φ_i⟩ dA.
//
// The thesis normalises the gradient of u and solves for φ from nothing. w has the same direction,
// does not fall out of the range of numbers, is nearly linear in each element, and is a first guess
// of φ itself: what is solved for is the difference.

#include "mq/filter/geodesic.h"

#include <fmt/format.h>

#include <cmath>

#include "mq/base/error.h"
#include "mq/filter/geodesic_steps.h"
#include "mq/filter/screened_poisson.h"
#include "mq/linear/connected_components.h"

namespace mq {

struct GeodesicDistance::Parts {
  const SignalSpace& space;
  GeodesicOptions options;
  double length = 0;           ///< √t
  SparseMatrix heat;           ///< M + t·S
  std::vector<int> component;  ///< per unknown
  ScreenedPoisson poisson;
  std::vector<Vector3> positions;
  std::vector<int> boundary;
};

GeodesicDistance::GeodesicDistance(const SignalSpace& space, const SolverFactory& factory,
                                   const GeodesicOptions& options, const Progress& progress) {
  require(options.time > 0 && std::isfinite(options.time),
          fmt::format("the time that heat spreads is {}; it must be positive", options.time));
  // Matrices are made where they stay, as Eigen copies a sparse one that is moved.
  parts_.reset(new Parts{space, options, 0, space.regularised_system(0, 1, progress.step("assemble", 0.2)), {},
                         ScreenedPoisson(space, ScreenedPoisson::infinite_weight, factory, progress.step("prepare", 0.8)),
                         space.positions(), space.boundary()});
  const Vector mass = space.lumped_mass();
  parts_->length = std::sqrt(options.time) * heat_spacing(space, parts_->heat, mass);
  make_heat_matrix(mass, parts_->length * parts_->length, parts_->heat);
  parts_->component = connected_components(parts_->heat);
}

GeodesicDistance::~GeodesicDistance() = default;

double GeodesicDistance::diffusion_length() const { return parts_->length; }

Geodesic GeodesicDistance::from(const std::vector<GeodesicSource>& asked,
                                const Progress& progress) const {
  require_sources(asked, parts_->space.size());
  const double spacing = mean_spacing(parts_->space);
  const std::vector<GeodesicSource> sources = grown_sources(parts_->heat, parts_->positions, spacing, asked);
  HeatDistances heat =
      heat_distances({parts_->length, spacing, parts_->heat, parts_->positions, parts_->boundary}, sources,
                     parts_->options, progress.step("directions", 0.8));
  const Signal moments = unit_gradient_moments(parts_->space, heat.w);
  Filtered filtered = parts_->poisson.solve_towards(heat.w, moments, progress.step("solve", 0.2));
  Geodesic result{.distance = filtered.signal.col(0),
                  .sweeps = heat.sweeps,
                  .change = heat.change,
                  .report = std::move(filtered.report)};
  result.unreached = meet_sources(sources, parts_->component, result.distance);
  return result;
}

}  // namespace mq
