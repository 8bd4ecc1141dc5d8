// Seeds and most of the time where a wave has a dozen vertices, the rest where it has twice as many.

#include "mq/filter/pattern_growth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "mq/base/error.h"
#include "mq/base/stopwatch.h"

namespace mq {

namespace {

/// More than the space has unknowns, at most, for the sake of memory.
constexpr double most_vertices = 4e6;

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

/// As many steps as take a quarter of a second, or all; how many these were and how long they took.
std::pair<int, double> run_for(const ReactionDiffusion& process, const Reaction& reaction, int steps, Substances& state) {
  constexpr double long_enough = 0.25;
  const Stopwatch watch;
  int taken = 0;
  while (taken < steps && watch.seconds() < long_enough) {
    const int more = std::min(std::max(1, taken), steps - taken);
    process.run(reaction, more, state);
    taken += more;
  }
  return {taken, watch.seconds()};
}

/// What the unknowns of a space find on a surface where they are.
Substances taken(const EvenlySpacedSurface& from, const SignalSpace& space, const std::vector<int>& components,
                 const Substances& state, const Progress& progress = {}) {
  const std::vector<Vector3> points = space.positions();
  return as_substances(from.at({points, components}, as_signal(state), progress));
}

}  // namespace

PatternGrowth::PatternGrowth(const SignalSpace& space, const Surface* surface, std::vector<int> components,
                             std::array<double, 2> diffusivity, double wave_length, double time,
                             const Progress& progress)
    : space_(space), components_(std::move(components)), wave_length_(wave_length) {
  const double spacing = wave_length / vertices_per_wave, size = space.size();
  const auto vertices = [&](double apart) { return EvenlySpacedSurface::expected_size(*surface, apart); };
  constexpr double more = (vertices_per_wave / least_texels) * (vertices_per_wave / least_texels);
  if (!surface || vertices(spacing) > std::max(size, std::min(more * size, most_vertices))) {
    places_.push_back({nullptr, std::make_unique<ReactionDiffusion>(space, diffusivity, 1, progress), time});
    return;
  }
  const bool is_seen_finely = vertices(spacing / 2) < size && time > 2 * last_time;
  const auto grow_at = [&](double apart, double how_long, const Progress& here) {
    Place place{std::make_unique<EvenlySpacedSurface>(*surface, apart, here), nullptr, how_long};
    place.process = std::make_unique<ReactionDiffusion>(place.surface->space(), diffusivity);
    places_.push_back(std::move(place));
  };
  grow_at(spacing, is_seen_finely ? time - last_time : time, progress.step("evenly spaced surface", 0.3));
  if (is_seen_finely) grow_at(spacing / 2, last_time, progress.step("evenly spaced surface", 0.7));
  progress.at(1);
}

const SignalSpace& PatternGrowth::at(const Place& place) const {
  return place.surface ? static_cast<const SignalSpace&>(place.surface->space()) : space_;
}

std::vector<PatternGrowth::Stage> PatternGrowth::stages() const {
  std::vector<Stage> stages;
  for (const Place& place : places_) stages.push_back({place.process.get(), std::ceil(place.time / place.process->time_step())});
  return stages;
}

Substances PatternGrowth::seeds(std::uint64_t seed) const {
  return seeded_substances(at(places_.front()).positions(), wave_length_, seed);
}

Substances PatternGrowth::grow(const Reaction& reaction, Substances state, const Expect& expect,
                               const Progress& progress) const {
  const std::vector<Stage> all = stages();
  const double total = std::max(1.0, bytes(all));
  require(std::ranges::all_of(all, [](const Stage& stage) { return stage.steps <= std::numeric_limits<int>::max(); }),
          fmt::format("a time of {:g} takes {:.3g} steps", places_.front().time, all.front().steps));
  for (std::size_t k = 0; k < all.size(); ++k) {
    const Stage& stage = all[k];
    const Progress here = progress.step("grow", 0.96 * bytes(stage) / total);
    if (k > 0) state = taken(*places_[k - 1].surface, places_[k].surface->space(), places_[k].surface->components(), state);
    int steps = int(stage.steps);
    if (k == 0 && expect) {
      const auto [taken, seconds] = run_for(*stage.process, reaction, steps, state);
      steps -= taken;
      if (steps > 0) expect(seconds * (total / (bytes(stage) * taken / stage.steps) - 1));
    }
    stage.process->run(reaction, steps, state, here);
  }
  const Place& last = places_.back();
  if (!last.surface) return state;
  return taken(*last.surface, space_, components_, state, progress.step("take values", 0.04));
}

}  // namespace mq
