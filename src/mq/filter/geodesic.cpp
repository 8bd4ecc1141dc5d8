// w = −√t·log u with (M + t·S)·u = 0 off the sources;  S·φ = ∫ ⟨∇w/|∇w|, ∇φ_i⟩ dA.
//
// The thesis normalises the gradient of u and solves for φ from nothing. w has the same direction,
// does not fall out of the range of numbers, is nearly linear in each element, and is a first guess
// of φ itself: what is solved for is the difference.

#include "mq/filter/geodesic.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/filter/front.h"
#include "mq/filter/heat_sweeps.h"
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
  std::vector<Vector3> places = {};
};

namespace {

/// Mean distance of neighbouring unknowns; that of equilateral triangles where there is no grid.
double mean_spacing(const SignalSpace& space) {
  const SurfaceScale scale = space.scale();
  if (scale.texel_spacing > 0) return scale.texel_spacing;
  return std::sqrt(2 / std::sqrt(3.0) * scale.area / space.size());
}

SparseMatrix heat_matrix(const SignalSpace& space, double t, const Progress& progress) {
  SparseMatrix A = space.solvable(0, t, progress);
  A.diagonal() += space.mass() * Vector::Ones(space.size());
  return A;
}

/// |∇w| is near 1. Where it is less than this there is no direction but rounding: inside sources,
/// and in the half texel by which a texture ends beyond its last texels.
constexpr float least_gradient = 0.05F;

/// ∫ ⟨∇w/|∇w|, ∇φ_i⟩ dA, |∇w| at least `least_gradient`.
Signal unit_gradient_moments(const SignalSpace& space, const Signal& w) {
  std::vector<float> factor = space.gradient_norms(w);
  for (float& f : factor) f = 1 / std::max(f, least_gradient);
  return space.conducted(w, factor);
}

void require_sources(const std::vector<GeodesicSource>& sources, int size) {
  require(!sources.empty(), "distances need at least one source");
  for (const GeodesicSource& s : sources) {
    require(s.unknown >= 0 && s.unknown < size,
            fmt::format("source {} is none of the {} unknowns", s.unknown, size));
    require(s.distance >= 0 && std::isfinite(s.distance),
            fmt::format("the distance at source {} is {}; it must be finite and not negative",
                        s.unknown, s.distance));
  }
}

/// Shifts each component such that the given distances are met on average.
void meet_sources(const std::vector<GeodesicSource>& sources, const std::vector<int>& component,
                  Geodesic& result) {
  std::vector<double> sum(component.size(), 0), count(component.size(), 0);
  for (const GeodesicSource& s : sources) {
    sum[component[s.unknown]] += result.distance[s.unknown] - s.distance;
    count[component[s.unknown]] += 1;
  }
  for (Eigen::Index i = 0; i < result.distance.size(); ++i) {
    const int c = component[i];
    if (count[c] > 0) {
      result.distance[i] = std::max(0.0, result.distance[i] - sum[c] / count[c]);
    } else {
      result.distance[i] = std::numeric_limits<double>::infinity();
      ++result.unreached;
    }
  }
}

}  // namespace

GeodesicDistance::GeodesicDistance(const SignalSpace& space, SolverFactory factory,
                                   const GeodesicOptions& options, const Progress& progress) {
  require(options.time > 0 && std::isfinite(options.time),
          fmt::format("the time that heat spreads is {}; it must be positive", options.time));
  const double length = std::sqrt(options.time) * mean_spacing(space);
  SparseMatrix heat = heat_matrix(space, length * length, progress.step("assemble", 0.2));
  std::vector<int> component = connected_components(heat);
  parts_ = std::make_unique<Parts>(
      Parts{space, options, length, std::move(heat), std::move(component),
            ScreenedPoisson(space, ScreenedPoisson::infinite_weight, std::move(factory),
                            progress.step("prepare", 0.8))});
}

GeodesicDistance::~GeodesicDistance() = default;

void GeodesicDistance::set_places(std::vector<Vector3> places) {
  require(std::ssize(places) == parts_->space.size(), "one place per unknown is needed");
  parts_->places = std::move(places);
}

double GeodesicDistance::diffusion_length() const { return parts_->length; }

Geodesic GeodesicDistance::from(const std::vector<GeodesicSource>& sources,
                                const Progress& progress) const {
  require_sources(sources, parts_->space.size());
  std::vector<std::pair<int, double>> fixed;
  for (const GeodesicSource& s : sources)
    fixed.emplace_back(s.unknown, -s.distance / parts_->length);
  Vector guess;
  if (!parts_->places.empty()) {
    std::vector<std::pair<int, double>> begin;
    for (const GeodesicSource& s : sources) begin.emplace_back(s.unknown, s.distance);
    guess = front_distances(parts_->heat, parts_->places, begin) / -parts_->length;
  }
  HeatSweeps heat =
      sweep_heat(parts_->heat, fixed, {parts_->options.tolerance, parts_->options.max_sweeps},
                 guess, progress.step("spread heat", 0.5));
  Signal w(heat.log_u.size(), 1);
  for (Eigen::Index i = 0; i < w.rows(); ++i)
    w(i, 0) = std::isfinite(heat.log_u[i]) ? -parts_->length * heat.log_u[i] : 0;
  heat.log_u = Vector();
  const Signal moments = unit_gradient_moments(parts_->space, w);
  Filtered filtered = parts_->poisson.solve_towards(w, moments, progress.step("solve", 0.5));
  Geodesic result{.distance = filtered.signal.col(0),
                  .sweeps = heat.sweeps,
                  .change = heat.change,
                  .report = std::move(filtered.report)};
  meet_sources(sources, parts_->component, result);
  return result;
}

}  // namespace mq
