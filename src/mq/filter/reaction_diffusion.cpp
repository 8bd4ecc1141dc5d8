// w_i ← w_i + τ R(w)_i + D Σ_j (−τ S_ij / m_i)(w_j − w_i): differences, so that a constant stays
// exactly.

#include "mq/filter/reaction_diffusion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/filter/line_integral.h"

namespace mq {

namespace {

/// Unknowns that a reaction is asked for at a time.
constexpr std::int64_t run_length = 1024;

/// Of τ D Σ|S_ij| / m_i; 1 is where explicit steps of the fastest wave stop to decay.
constexpr double stable = 0.75;

/// Diffusivity of u for which presets were measured.
constexpr double measured_diffusivity = 0.16;

/// Share of the unknowns that may ask for a shorter step: those at seams, of which a chart shows a
/// part, are some per cent of an atlas.
constexpr double may_be_slow = 0.1;

/// τ for which no larger share asks for less.
double step_for_most(std::vector<double> fastest, double longest) {
  const auto place =
      fastest.begin() + std::ptrdiff_t((1 - may_be_slow) * double(fastest.size() - 1));
  std::nth_element(fastest.begin(), place, fastest.end());
  return *place > 0 ? std::min(longest, stable / *place) : longest;
}

/// The value that this share of a column reaches, one of them at least.
double exceeded_by(const Signal& column, double share) {
  std::vector<double> values(column.data(), column.data() + column.size());
  if (values.empty()) return 0;
  const auto place = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
  std::nth_element(values.begin(), place, values.end(), std::greater<>());
  return *place;
}

}  // namespace

Reaction gray_scott(const GrayScott& rates) {
  const float feed = float(rates.feed), loss = float(rates.feed + rates.kill);
  return [=](std::span<const float> state, std::span<float> rate) {
    for (std::size_t k = 0; k < state.size(); k += 2) {
      const float u = state[k], v = state[k + 1], uvv = u * v * v;
      rate[k] = feed * (1 - u) - uvv;
      rate[k + 1] = uvv - loss * v;
    }
  };
}

const std::vector<GrayScottPreset>& gray_scott_presets() {
  static const std::vector<GrayScottPreset> presets = {{"spots", {0.030, 0.062}, 11.2},
                                                       {"stripes", {0.029, 0.057}, 11.7},
                                                       {"holes", {0.0405, 0.0585}, 11.9},
                                                       {"coral", {0.0545, 0.062}, 11.2}};
  return presets;
}

std::array<double, 2> diffusivities(const GrayScottPreset& preset, double wave_length) {
  const double length = wave_length / preset.wave_length;
  return {measured_diffusivity * length * length, measured_diffusivity / 2 * length * length};
}

ReactionDiffusion::ReactionDiffusion(const SignalSpace& space, std::array<double, 2> diffusivity,
                                     double longest_step, const Progress& progress)
    : diffusivity_{float(diffusivity[0]), float(diffusivity[1])} {
  for (const double d : diffusivity)
    require(d >= 0 && std::isfinite(d), fmt::format("a diffusivity is {}", d));
  require(longest_step > 0, "a step must be longer than 0");
  const SparseMatrix S = space.regularised_system(0, 1, progress.step("assemble", 0.8));
  const Vector mass = space.lumped_mass();
  const double most = std::max(diffusivity[0], diffusivity[1]);
  std::vector<double> coupling(std::size_t(S.rows()), 0), fastest(coupling.size());
  parallel_for(S.rows(), [&](std::int64_t i) {
    for (SparseMatrix::InnerIterator it(S, i); it; ++it)
      if (it.col() != i) coupling[i] += std::abs(it.value());
    fastest[i] = most * coupling[i] / mass[i];
  });
  step_ = step_for_most(fastest, longest_step);
  begin_.assign(coupling.size() + 1, 0);
  for (int i = 0; i < S.rows(); ++i)
    begin_[i + 1] = begin_[i] + S.outerIndexPtr()[i + 1] - S.outerIndexPtr()[i] - 1;
  column_.resize(std::size_t(begin_.back()));
  weight_.resize(column_.size());
  parallel_for(S.rows(), [&](std::int64_t i) {
    const double m = std::max(mass[i], step_ * most * coupling[i] / stable);
    int at = begin_[i];
    for (SparseMatrix::InnerIterator it(S, i); it; ++it) {
      if (it.col() == i) continue;
      column_[at] = int(it.col());
      weight_[at++] = float(-step_ * it.value() / m);
    }
  });
  std::int64_t slow = 0;
  for (const double f : fastest) slow += step_ * f > stable * (1 + 1e-9);
  slowed_ = double(slow) / double(std::max<std::size_t>(1, fastest.size()));
  progress.at(1);
}

std::int64_t ReactionDiffusion::bytes_per_step() const {
  return std::int64_t(column_.size()) * 8 + std::int64_t(size()) * (4 + 2 * 8);
}

void ReactionDiffusion::advance(const Reaction& reaction, const Substances& from,
                                Substances& to) const {
  const float step = float(step_), du = diffusivity_[0], dv = diffusivity_[1];
  parallel_blocks(size(), run_length, [&](std::int64_t first, std::int64_t end) {
    std::array<float, 2 * run_length> rate;
    const std::size_t count = std::size_t(2 * (end - first));
    reaction(std::span(from).subspan(std::size_t(2 * first), count), std::span(rate).first(count));
    for (std::int64_t i = first; i < end; ++i) {
      const float u = from[2 * i], v = from[2 * i + 1];
      float spread_u = 0, spread_v = 0;
      for (int e = begin_[i]; e < begin_[i + 1]; ++e) {
        const float* other = from.data() + 2 * std::ptrdiff_t(column_[e]);
        spread_u += weight_[e] * (other[0] - u);
        spread_v += weight_[e] * (other[1] - v);
      }
      to[2 * i] = u + du * spread_u + step * rate[2 * (i - first)];
      to[2 * i + 1] = v + dv * spread_v + step * rate[2 * (i - first) + 1];
    }
  });
}

void ReactionDiffusion::run(const Reaction& reaction, int steps, Substances& state,
                            const Progress& progress) const {
  require(
      std::ssize(state) == 2 * size(),
      fmt::format("{} amounts were given for two substances on {} unknowns", state.size(), size()));
  Substances next(state.size());
  for (int k = 0; k < steps; ++k) {
    advance(reaction, state, next);
    state.swap(next);
    progress.at(double(k + 1) / steps);
  }
}

Substances seeded_substances(std::span<const Vector3> places, double spacing, std::uint64_t seed) {
  const Signal noise = solid_noise(places, spacing, seed);
  Substances state(2 * places.size());
  const double least = std::min(0.65, exceeded_by(noise, 0.02));
  for (std::size_t i = 0; i < places.size(); ++i) {
    const bool spot = noise(Eigen::Index(i), 0) >= least;
    state[2 * i] = spot ? 0.5F : 1.0F;
    state[2 * i + 1] = spot ? 0.25F : 0.0F;
  }
  return state;
}

}  // namespace mq
