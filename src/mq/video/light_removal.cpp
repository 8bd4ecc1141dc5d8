#include "mq/video/light_removal.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numeric>
#include <vector>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/fem/multigrid_solver.h"
#include "mq/filter/screened_poisson.h"
#include "mq/linear/direct_solver.h"

namespace mq {
namespace {

/// Frames around the one that is filtered, and how texels go on between them.
class Window {
 public:
  /// Appends a frame.
  void add(TemporalFrame frame) {
    const int count = int(frame.psi.rows());
    std::vector<int> before(count, -1);
    if (!frames_.empty()) {
      std::vector<int> after(frames_.back().psi.rows(), -1);
      for (int t = 0; t < frame.links.rows(); ++t)
        if (const int s = frame.links.same(t); s >= 0) before[t] = s, after[s] = t;
      after_.back() = std::move(after);
    }
    before_.push_back(std::move(before));
    after_.emplace_back(count, -1);
    frames_.push_back(std::move(frame));
  }

  void drop_first() {
    frames_.pop_front();
    before_.pop_front();
    after_.pop_front();
  }

  int size() const { return int(frames_.size()); }
  const TemporalFrame& operator[](int i) const { return frames_[i]; }

  /// ψ̄ of one frame.
  Signal mean(int centre, int radius) const {
    const TemporalFrame& own = frames_[centre];
    const Eigen::Index count = own.psi.rows();
    Signal sum = window_weight(0, radius) * own.psi;
    Vector weights = Vector::Constant(count, window_weight(0, radius));
    for (const int step : {-1, 1}) {
      std::vector<int> at(count);
      std::iota(at.begin(), at.end(), 0);
      std::vector<ChartPlace> places;
      if (own.drift) places = own.drift->starts();
      for (int k = 1; k <= radius; ++k) {
        const int from = centre + step * (k - 1), to = from + step;
        if (to < 0 || to >= size()) break;
        const TemporalFrame& frame = frames_[to];
        const double weight = window_weight(k, radius);
        go_on(from, to, at, places);
        parallel_for(count, [&](std::int64_t t) {
          const int s = at[t];
          if (s < 0) return;
          sum.row(t) += weight * frame.psi.row(s);
          weights[t] += weight;
          if (!places.empty()) sum.row(t) += weight * frame.drift->change(frame.psi, s, places[t]);
        });
      }
    }
    return sum.array().colwise() / weights.array();
  }

 private:
  /// Texels of a frame and the places that their points slid to, on to the next or the one before. A texel that ends
  /// becomes −1.
  void go_on(int from, int to, std::vector<int>& at, std::vector<ChartPlace>& places) const {
    const std::vector<int>& next = to < from ? before_[from] : after_[from];
    const std::vector<int> was = at;
    for (int& t : at)
      if (t >= 0) t = next[t];
    if (places.empty()) return;
    const FrameDrift &here = *frames_[from].drift, &there = *frames_[to].drift;
    const FrameDrift& later = from > to ? here : there;
    if (later.follows()) {
      places = from > to ? later.before(places) : later.after(places);
      return;
    }
    parallel_for(std::ssize(at), [&](std::int64_t t) {
      if (at[t] < 0) return;
      const Vector2 slid = here.texel(places[t]) - here.texel(here.starts()[was[t]]);
      places[t] = there.beside(at[t], slid);
      if (places[t].chart < 0) at[t] = -1;
    });
  }

  std::deque<TemporalFrame> frames_;
  std::deque<std::vector<int>> before_, after_;
};

void check(const LightRemovalOptions& options) {
  require(options.radius >= 0, fmt::format("a window of radius {} was asked for; it must be 0 or "
                                           "more frames",
                                           options.radius));
  require(options.weight >= 0 && std::isfinite(options.weight),
          fmt::format("the weight of gradients is {}; it must be 0 or more, and finite",
                      options.weight));
}

/// The mean's part of a frame made steep: of L·(ψ̄ − ψ), which the thesis' equation adds to ψ, L·(3 − 2L) times that.
void steepen(const ScreenedPoisson& equation, const Signal& psi, Filtered& filtered, const Progress& progress) {
  const Signal none = Signal::Zero(psi.rows(), psi.cols()), gentle = filtered.signal - psi;
  const Filtered twice = equation.solve_towards(gentle, none, progress.step("solve", 0.5)),
                 thrice = equation.solve_towards(twice.signal, none, progress.step("solve", 0.5));
  filtered.signal = psi + 3 * twice.signal - 2 * thrice.signal;
  for (const Filtered* more : {&twice, &thrice}) {
    filtered.report.solve_seconds += more->report.solve_seconds;
    filtered.report.converged = filtered.report.converged && more->report.converged;
  }
}

}  // namespace

double window_weight(int k, int radius) {
  const double x = 2.0 * std::abs(k) / (radius + 1);
  if (x >= 2) return 0;
  return x < 1 ? 2.0 / 3 - x * x * (1 - x / 2) : (2 - x) * (2 - x) * (2 - x) / 6;
}

TemporalReport remove_lighting(int frames, const FrameSource& load,
                               const std::function<void(int, const TemporalFrame&, Signal)>& store,
                               const LightRemovalOptions& options, const Progress& progress) {
  check(options);
  TemporalReport report;
  report.look_ahead = options.radius;
  Window window;
  const int first = std::max(0, options.first), end = std::min(frames, options.end);
  int loaded = std::max(0, first - options.radius), centre = first - loaded;
  const bool steep = options.crossover == LightRemovalOptions::Crossover::steep;
  const auto window_end = [&](int f) { return int(std::min<std::int64_t>(frames, std::int64_t(f) + options.radius + 1)); };
  const double all_work = options.costs.loading(loaded, window_end(end - 1)) + (end - first) * (1 + options.costs.store);
  for (int f = first; f < end; ++f) {
    const double to_read = options.costs.loading(loaded, window_end(f)), work = to_read + 1 + options.costs.store;
    const Progress part = progress.step(fmt::format("frame {}", f), work / all_work);
    const Progress reading = part.step("read", to_read / work);
    for (; loaded < window_end(f); ++loaded) {
      const double share = to_read > 0 ? options.costs.loading(loaded, loaded + 1) / to_read : 0;
      window.add(load(loaded, reading.step("read", share)));
    }
    report.held = std::max(report.held, window.size());
    const TemporalFrame& frame = window[centre];
    require(frame.psi.rows() == frame.space->size() && frame.psi.allFinite(),
            fmt::format("frame {} has values that are not finite, or not one for each texel", f));
    const Signal mean = window.mean(centre, options.radius);
    const ScreenedPoisson equation(
        *frame.space, options.weight, std::vector<double>(frame.psi.rows(), 1.0),
        frame.texels ? multigrid_solver(*frame.texels, {.tolerance = options.tolerance})
                     : direct_solver(),
        part.step("prepare", 0.6 / work));
    Filtered filtered = equation.solve_towards(mean, frame.space->stiffness_times(frame.psi),
                                               part.step("solve", (steep ? 0.2 : 0.4) / work));
    if (steep) steepen(equation, frame.psi, filtered, part.step("solve", 0.2 / work));
    report.add(filtered.report);
    part.step("store", options.costs.store / work).at(0);
    store(f, frame, std::move(filtered.signal));
    if (centre < options.radius)
      ++centre;
    else
      window.drop_first();
  }
  return report;
}

}  // namespace mq
