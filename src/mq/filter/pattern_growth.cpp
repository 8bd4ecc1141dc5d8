// Seeds and most of the time where a wave has a dozen vertices, the rest on the space.

#include "mq/filter/pattern_growth.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "mq/base/error.h"
#include "mq/base/stopwatch.h"

namespace mq {

namespace {

/// Of the cost, what the evenly spaced surface must save to be worth its making.
constexpr double worth = 0.5;

/// Entries of a row at a vertex, and at a texel.
constexpr double entries_of_vertex = 7, entries_of_texel = 9;

double bytes(const PatternGrowth::Stage& stage) { return double(stage.process->bytes_per_step()) * stage.steps; }

double bytes(const std::vector<PatternGrowth::Stage>& stages) {
  double all = 0;
  for (const PatternGrowth::Stage& stage : stages) all += bytes(stage);
  return all;
}

using Pairs = Eigen::Matrix<float, Eigen::Dynamic, 2, Eigen::RowMajor>;

Signal as_signal(const Substances& state) {
  return Eigen::Map<const Pairs>(state.data(), std::ssize(state) / 2, 2).cast<double>();
}

Substances as_substances(const Signal& values) {
  Substances state(std::size_t(values.size()));
  Eigen::Map<Pairs>(state.data(), values.rows(), 2) = values.cast<float>();
  return state;
}

}  // namespace

PatternGrowth::PatternGrowth(const SignalSpace& space, const Surface* surface, std::array<double, 2> diffusivity,
                             double wave_length, double time, const Progress& progress)
    : space_(space),
      wave_length_(wave_length),
      time_(time),
      process_(space, diffusivity, 1, progress.step("weights", 0.3)) {
  const double spacing = wave_length / vertices_per_wave;
  const double here = double(process_.size()) / process_.time_step();
  if (surface && time > 2 * last_time &&
      EvenlySpacedSurface::expected_size(*surface, spacing) * entries_of_vertex < worth * here * entries_of_texel) {
    even_ = std::make_unique<EvenlySpacedSurface>(*surface, spacing, progress.step("evenly spaced surface", 0.7));
    even_process_.emplace(even_->space(), diffusivity);
  }
  progress.at(1);
}

std::vector<PatternGrowth::Stage> PatternGrowth::stages() const {
  const auto stage = [](const ReactionDiffusion& process, double time) {
    return Stage{&process, std::ceil(time / process.time_step())};
  };
  if (!even_) return {stage(process_, time_)};
  return {stage(*even_process_, time_ - last_time), stage(process_, last_time)};
}

double PatternGrowth::cost() const { return bytes(stages()) / double(process_.bytes_per_step()); }

Substances PatternGrowth::seeds(std::uint64_t seed) const {
  return seeded_substances(even_ ? even_->space().positions() : space_.positions(), wave_length_, seed);
}

Substances PatternGrowth::grow(const Reaction& reaction, Substances state, const Expect& expect,
                               const Progress& progress) const {
  constexpr int timed = 4;
  const std::vector<Stage> all = stages();
  const double total = std::max(1.0, bytes(all));
  require(std::ranges::all_of(all, [](const Stage& stage) { return stage.steps <= std::numeric_limits<int>::max(); }),
          fmt::format("a time of {:g} takes {:.3g} steps", time_, all.front().steps));
  for (const Stage& stage : all) {
    const bool is_last = &stage == &all.back();
    const Progress here = progress.step(is_last ? "grow" : "grow on even spacing", bytes(stage) / total);
    if (&stage != &all.front()) state = as_substances(even_->at(space_.positions(), as_signal(state)));
    int steps = int(stage.steps);
    if (&stage == &all.front() && expect && steps > timed) {
      const Stopwatch watch;
      stage.process->run(reaction, timed, state);
      expect(watch.seconds() * (total / (bytes(stage) * timed / steps) - 1));
      steps -= timed;
    }
    stage.process->run(reaction, steps, state, here);
  }
  return state;
}

}  // namespace mq
