// (M + w Σ c_e S_e)·φ = M·ψ,   c_e = Π 1 / (1 + (h̄ |∇g|_e / edge)²), g the guides and the last φ.

#include "mq/filter/denoise.h"

#include <fmt/format.h>

#include <cmath>

#include "mq/base/error.h"
#include "mq/fem/conducting_space.h"

namespace mq {

namespace {

/// A conductivity below this is none, but keeps the system in one piece.
constexpr float least_conductivity = 1e-6F;

/// Over how many spacings the first step smooths, whose edges the second goes by (Catté, Lions,
/// Morel and Coll 1992): enough for noise from one unknown to the next, little enough for edges to
/// stay.
constexpr double first_spacings = 1.5;

double mean_spacing(const SignalSpace& space) {
  const SurfaceScale scale = space.scale();
  return scale.texel_spacing > 0 ? scale.texel_spacing : std::sqrt(scale.area / space.size());
}

void stop_at_edges(const SignalSpace& space, const Signal& guide, double edge,
                   std::vector<float>& conductivity) {
  require(edge > 0, fmt::format("an edge is {}; it must be more than 0", edge));
  if (std::isinf(edge)) return;
  require(guide.rows() == space.size() && guide.allFinite(),
          fmt::format("a guide of {} rows was given for {} unknowns, or it is not finite",
                      guide.rows(), space.size()));
  const double scale = mean_spacing(space) / edge;
  const std::vector<float> norms = space.gradient_norms(guide);
  for (std::size_t e = 0; e < norms.size(); ++e) {
    const double steps = scale * norms[e];
    conductivity[e] = std::max(least_conductivity, float(conductivity[e] / (1 + steps * steps)));
  }
}

}  // namespace

Filtered denoise(const SignalSpace& space, const Signal& psi, const std::vector<Guide>& guides,
                 const DenoiseOptions& options, const SolverFactory& factory,
                 const Progress& progress) {
  require(options.steps >= 1, "denoising takes at least one step");
  std::vector<float> of_guides(std::size_t(space.element_count()), 1.0F);
  for (const Guide& guide : guides) stop_at_edges(space, guide.values, guide.edge, of_guides);
  require(options.edge > 0, fmt::format("an edge is {}; it must be more than 0", options.edge));
  const bool own_edges = !std::isinf(options.edge);
  const int steps = own_edges ? options.steps + 1 : 1;
  const double first = first_spacings * mean_spacing(space);
  Filtered result{psi, {}};
  for (int k = 0; k < steps; ++k) {
    const Progress step = progress.step(fmt::format("step {}", k + 1), 1.0 / steps);
    std::vector<float> conductivity = of_guides;
    if (k > 0) stop_at_edges(space, result.signal, options.edge, conductivity);
    const ConductingSpace conducting(space, std::move(conductivity));
    const bool looks_for_edges = own_edges && k == 0;
    const double weight =
        looks_for_edges ? std::min(options.weight, first * first) : options.weight;
    const ScreenedPoisson equation(conducting, weight, factory, step.step("prepare", 0.6));
    result = equation.solve(psi, 0, step.step("solve", 0.4));
  }
  return result;
}

}  // namespace mq
