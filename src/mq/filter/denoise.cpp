// (M + w Σ c_e S_e)·φ = M·ψ,   c_e = Π 1 / (1 + (h̄ |∇g|_e / edge)²), g the guides and the last φ.
//
// The first, slight smoothing is solved by conjugate gradients without levels: its matrix is the
// mass and little more. Later steps keep of their solver what does not depend on values.

#include "mq/filter/denoise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/fem/weighted_stiffness_space.h"
#include "mq/linear/conjugate_gradients.h"

namespace mq {

namespace {

/// A conductivity below this is none, but keeps the system in one piece.
constexpr float least_conductivity = 1e-6F;

/// Over how many spacings the first step smooths, whose edges the second goes by (Catté, Lions,
/// Morel and Coll 1992): enough for noise from one unknown to the next, little enough for edges to
/// stay.
constexpr double first_spacings = 1.5;

/// A quartile that is a smaller part of the largest gradient is what smoothing leaves of an edge far away.
constexpr float no_noise = 1e-5F;

double spacing_of(const SignalSpace& space) { return denoising::spacing(space.scale(), space.size()); }

void stop_at_edges(const SignalSpace& space, const Signal& guide, double edge,
                   std::vector<float>& conductivity) {
  require(edge > 0, fmt::format("an edge is {}; it must be more than 0", edge));
  if (std::isinf(edge)) return;
  require(guide.rows() == space.size() && guide.allFinite(),
          fmt::format("a guide of {} rows was given for {} unknowns, or it is not finite",
                      guide.rows(), space.size()));
  denoising::stop_at_edges(space.gradient_norms(guide), spacing_of(space), edge, conductivity);
}

/// ψ with noise from one unknown to the next taken off: (M + w S)·δ = −w S·ψ, φ = ψ + δ. Where
/// rounding leaves the matrix not quite positive definite, the solver of the other steps does it,
/// which knows what to do.
Signal slightly_smoothed(const SignalSpace& space, const Signal& psi, double most_weight,
                         const SolverFactory& factory, const Progress& progress) {
  const double weight = denoising::first_weight(most_weight, spacing_of(space));
  Signal change = space.stiffness_times(psi);
  if (change.isZero(0)) return psi;
  try {
    const SparseMatrix A = space.regularised_system(1, weight, progress.step("assemble", 0.2));
    change *= -weight;
    Signal smoothed = Signal::Zero(psi.rows(), psi.cols());
    conjugate_gradients(A, change, smoothed, jacobi_preconditioner(A), denoising::first_stop(),
                        progress.step("solve", 0.8));
    smoothed += psi;
    return smoothed;
  } catch (const NotPositiveDefinite&) {
    const ScreenedPoisson equation(space, weight, factory, progress.step("prepare", 0.2));
    return equation.solve(psi, 0, progress.step("solve", 0.4)).signal;
  }
}

}  // namespace

namespace denoising {

double spacing(const SurfaceScale& scale, std::int64_t unknowns) {
  return scale.texel_spacing > 0 ? scale.texel_spacing : std::sqrt(scale.area / double(unknowns));
}

double first_weight(double weight, double spacing) { return std::min(weight, std::pow(first_spacings * spacing, 2)); }

ConjugateGradientOptions first_stop() { return {.tolerance = 1e-2, .max_cycles = 60}; }

std::vector<float> surface_gradients(const SignalSpace& space, const Signal& smoothed, std::span<const char> counts) {
  std::vector<float> norms = space.gradient_norms(smoothed);
  // Positions change everywhere but in cells of a texture that no chart reaches.
  const std::vector<Vector3> positions = space.positions();
  Signal places(space.size(), 3);
  for (int i = 0; i < space.size(); ++i)
    places.row(i) = (positions[std::size_t(i)] - positions.front()).transpose();
  const std::vector<float> everywhere = space.gradient_norms(places);
  std::size_t count = 0;
  for (std::size_t e = 0; e < norms.size(); ++e)
    if (everywhere[e] > 0 && (counts.empty() || counts[e])) norms[count++] = norms[e];
  norms.resize(count);
  return norms;
}

double edge_from(float quartile, float largest, double spacing) {
  return quartile <= no_noise * largest ? 0 : spacing * double(quartile);
}

void stop_at_edges(std::span<const float> gradient_norms, double spacing, double edge, std::vector<float>& conductivity) {
  const double scale = spacing / edge;
  parallel_for(std::ssize(gradient_norms), [&](std::int64_t e) {
    const double steps = scale * double(gradient_norms[std::size_t(e)]);
    float& c = conductivity[std::size_t(e)];
    c = std::max(least_conductivity, float(double(c) / (1 + steps * steps)));
  });
}

}  // namespace denoising

double usual_denoise_weight(const SignalSpace& space) {
  return std::pow(usual_denoise_length.value * spacing_of(space), 2);
}

double measured_edge(const SignalSpace& space, const Signal& smoothed) {
  std::vector<float> norms = denoising::surface_gradients(space, smoothed);
  if (norms.empty()) return 0;
  const float largest = *std::ranges::max_element(norms);
  const auto quartile = norms.begin() + std::ptrdiff_t(norms.size() / 4);
  std::ranges::nth_element(norms, quartile);
  return denoising::edge_from(*quartile, largest, spacing_of(space));
}

Denoised denoise(const SignalSpace& space, const Signal& psi, const std::vector<Guide>& guides,
                 const DenoiseOptions& options, const SolverFactory& factory,
                 const Progress& progress) {
  require(options.steps >= 1, "denoising takes at least one step");
  require(psi.rows() == space.size() && psi.allFinite(),
          fmt::format("a signal of {} rows was given for {} unknowns, or it is not finite",
                      psi.rows(), space.size()));
  require(options.strength > 0 && std::isfinite(options.strength),
          fmt::format("denoising has a strength of {}; it must be more than 0", options.strength));
  std::vector<float> of_guides;  // none: no guide, 1 everywhere
  if (!guides.empty()) of_guides.assign(std::size_t(space.element_count()), 1.0F);
  for (const Guide& guide : guides) stop_at_edges(space, guide.values, guide.edge, of_guides);
  require(!options.edge || *options.edge > 0,
          fmt::format("an edge is {}; it must be more than 0", options.edge.value_or(0)));
  const bool own_edges = !options.edge || !std::isinf(*options.edge);
  std::optional<WeightedStiffnessSpace> weighted_system;
  if (!guides.empty()) weighted_system.emplace(space, of_guides);
  const auto guided = [&]() -> const SignalSpace& {
    return weighted_system ? static_cast<const SignalSpace&>(*weighted_system) : space;
  };
  Denoised result{{psi, {}}, options.edge.value_or(0)};
  if (own_edges)
    result.signal = slightly_smoothed(guided(), psi, options.weight, factory,
                                      progress.step("look for edges", 0.2));
  if (!options.edge) result.edge = std::max(1.0, options.strength) * measured_edge(space, result.signal);
  if (result.edge == 0) {
    result.signal = psi;
    result.report.converged = true;
    return result;
  }
  std::optional<ScreenedPoisson> equation;
  const int steps = own_edges ? options.steps : 1;
  for (int k = 0; k < steps; ++k) {
    const Progress step =
        progress.step(fmt::format("step {}", k + 1), (own_edges ? 0.8 : 1) / steps);
    if (own_edges) {
      std::vector<float> conductivity = of_guides;
      conductivity.resize(std::size_t(space.element_count()), 1.0F);
      stop_at_edges(space, result.signal, result.edge, conductivity);
      if (weighted_system)
        weighted_system->set_conductivity(std::move(conductivity));
      else
        weighted_system.emplace(space, std::move(conductivity));
    }
    const Progress preparing = step.step("prepare", 0.6);
    if (equation)
      equation->set_weight(options.weight, preparing);
    else
      equation.emplace(guided(), options.weight, factory, preparing);
    static_cast<Filtered&>(result) = equation->solve(psi, 0, step.step("solve", 0.4));
  }
  if (options.strength < 1) result.signal = psi + options.strength * (result.signal - psi);
  return result;
}

}  // namespace mq
