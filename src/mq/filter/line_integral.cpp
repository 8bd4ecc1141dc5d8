// (M_Y + w·S_Y)·φ = M_Y·ψ for noise ψ, then (M + w'·S)·φ' = M·φ + β·w'·S·φ.

#include "mq/filter/line_integral.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/base/random.h"
#include "mq/linear/conjugate_gradients.h"

namespace mq {

namespace {

/// The count of a node of the grid, for `Random`: nodes 2²¹ apart along one axis share it.
std::uint64_t node(std::int64_t x, std::int64_t y, std::int64_t z) {
  constexpr std::uint64_t mask = (1U << 21) - 1;
  return (std::uint64_t(x) & mask) | (std::uint64_t(y) & mask) << 21 |
         (std::uint64_t(z) & mask) << 42;
}

double noise_at(const Random& random, const Vector3& p) {
  const Vector3 low = p.array().floor(), f = p - low;
  double value = 0;
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    std::int64_t at[3];
    for (int k = 0; k < 3; ++k) {
      const int up = corner >> k & 1;
      weight *= up ? f[k] : 1 - f[k];
      at[k] = std::int64_t(low[k]) + up;
    }
    value += weight * random.uniform(node(at[0], at[1], at[2]));
  }
  return value;
}

}  // namespace

Signal solid_noise(std::span<const Vector3> places, double spacing, std::uint64_t seed) {
  require(spacing > 0 && std::isfinite(spacing), "noise needs a spacing above 0");
  const Random random(seed);
  Signal values(std::ssize(places), 1);
  parallel_for(values.rows(),
               [&](std::int64_t i) { values(i, 0) = noise_at(random, places[i] / spacing); });
  return values;
}

LineIntegral line_integral(const SignalSpace& across, const SignalSpace& surface,
                           const Signal& noise, const LineIntegralOptions& options,
                           const SolverFactory& factory, const Progress& progress) {
  require(across.size() == surface.size() && noise.rows() == surface.size(),
          "noise and both spaces need the same unknowns");
  require(options.weight >= 0 && std::isfinite(options.weight),
          fmt::format(
              "the weight of a line integral convolution is {}; it must be 0 or more, and finite",
              options.weight));
  LineIntegral result;
  if (options.weight == 0) {
    result.signal = noise;
  } else {
    // The change from the mean, not from the noise, to which the lines have little likeness:
    // (M_Y + w·S_Y)·(φ − mean) = M_Y·(ψ − mean).
    const Signal mean = noise.colwise().mean().replicate(noise.rows(), 1);
    Signal moments = across.mass() * (noise - mean);
    moments /= options.weight;
    const ScreenedPoisson equation(across, options.weight, factory, progress.step("prepare", 0.2));
    Filtered spread = equation.solve_change(mean, moments, progress.step("spread", 0.3));
    result.signal = std::move(spread.signal);
    result.spread = std::move(spread.report);
  }
  // One equation for both: its levels stay, its values are others.
  std::optional<ScreenedPoisson> equation;
  if (options.sharpen_weight > 0) {
    equation.emplace(surface, options.sharpen_weight, factory, progress.step("prepare", 0.1));
    Filtered sharp = equation->solve(result.signal, options.sharpen_beta, progress.step("sharpen", 0.2));
    result.signal = std::move(sharp.signal);
    result.sharpen = std::move(sharp.report);
  }
  if (options.even_weight > 0) {
    const Progress preparing = progress.step("prepare", 0.08);
    if (equation)
      equation->set_weight(options.even_weight, preparing);
    else
      equation.emplace(surface, options.even_weight, factory, preparing);
    result.signal = evened(*equation, result.signal, progress.step("even", 0.12));
  }
  return result;
}

double finest_grain(const SurfaceScale& scale) {
  return std::max(0.0025 * std::sqrt(scale.area), 2 * scale.texel_spacing);
}

double usual_grain(const SignalSpace& space) {
  require(space.size() > 0, "a space without unknowns has no grain");
  const Vector mass = space.mass() * Vector::Ones(space.size());
  std::vector<double> areas(mass.begin(), mass.end());
  std::ranges::sort(areas);
  double left = 0.2 * mass.sum();
  std::size_t i = areas.size();
  while (i > 1 && left > 0) left -= areas[--i];
  SurfaceScale scale = space.scale();
  if (!(scale.texel_spacing > 0)) scale.texel_spacing = std::sqrt(scale.area / double(space.size()));
  return std::max(finest_grain(scale), std::sqrt(areas[i]));
}

Signal evened(const ScreenedPoisson& means, const Signal& lines, const Progress& progress) {
  Signal result = lines - means.solve(lines, 0, progress.step("means", 0.5)).signal;
  const Signal squares = means.solve(result.cwiseAbs2(), 0, progress.step("contrast", 0.5)).signal;
  for (Eigen::Index c = 0; c < result.cols(); ++c) {
    const double least = 0.01 * squares.col(c).mean();
    // Of a constant nothing is left but rounding.
    if (!(least > 1e-24 * lines.col(c).squaredNorm() / double(lines.rows())))
      result.col(c).setZero();
    else
      result.col(c).array() /= squares.col(c).array().max(least).sqrt();
  }
  return result;
}

void watch_lines_form(const SignalSpace& across, const Signal& noise, double weight, int steps,
                      const std::function<void(int, const Signal&)>& shown,
                      const Progress& progress) {
  shown(0, noise);
  if (weight == 0) return;
  const SparseMatrix A = across.regularised_system(1, weight);
  const Signal B = across.mass() * noise;
  const Preconditioner jacobi = jacobi_preconditioner(A);
  Signal X = noise;
  for (int done = 0, next = 1; next <= steps; next *= 2) {
    conjugate_gradients(A, B, X, jacobi, {.tolerance = 0, .max_cycles = next - done});
    done = next;
    progress.at(double(done) / steps);
    shown(done, X);
  }
}

Signal with_contrast(const Signal& signal, double deviations) {
  require(deviations > 0, "the number of standard deviations must be above 0");
  Signal result = signal;
  for (Eigen::Index c = 0; c < result.cols(); ++c) {
    auto values = result.col(c).array();
    const double mean = values.mean();
    const double deviation = std::sqrt((values - mean).square().mean());
    // A constant differs from its mean by rounding.
    if (deviation <= 1e-12 * std::abs(mean))
      values.setConstant(0.5);
    else
      values = ((values - mean) / (2 * deviations * deviation) + 0.5).max(0.0).min(1.0);
  }
  return result;
}

Signal lines_over(const Signal& colours, const Signal& grey, int channels) {
  require(colours.rows() == grey.rows() && grey.cols() == 1 && channels <= colours.cols(),
          fmt::format(
              "{} × {} colours, {} of them without alpha, and {} × {} greys of lines: wanted as "
              "many rows, and one column of greys",
              colours.rows(), colours.cols(), channels, grey.rows(), grey.cols()));
  Signal over = colours;
  const Eigen::ArrayXd t = 2 * grey.col(0).array() - 1;
  constexpr double part = 0.4;
  for (int c = 0; c < channels; ++c) {
    const auto colour = colours.col(c).array();
    over.col(c) = (colour + part * (t.max(0) * (1 - colour).max(0) + t.min(0) * colour.max(0))).matrix();
  }
  return over;
}

}  // namespace mq
