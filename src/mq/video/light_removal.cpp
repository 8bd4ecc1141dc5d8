#include "mq/video/light_removal.h"

#include <algorithm>
#include <cmath>
#include <deque>
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
    const Signal& psi = frames_[centre].psi;
    Signal result(psi.rows(), psi.cols());
    parallel_for(psi.rows(), [&](std::int64_t t) {
      double sum = window_weight(0, radius);
      Eigen::RowVectorXd row = sum * psi.row(t);
      const auto walk = [&](int step, const std::deque<std::vector<int>>& next) {
        int at = int(t);
        for (int k = 1; k <= radius; ++k) {
          const int f = centre + step * (k - 1), to = f + step;
          if (to < 0 || to >= size() || (at = next[f][at]) < 0) break;
          row += window_weight(k, radius) * frames_[to].psi.row(at);
          sum += window_weight(k, radius);
        }
      };
      walk(-1, before_);
      walk(1, after_);
      result.row(t) = row / sum;
    });
    return result;
  }

 private:
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

}  // namespace

double window_weight(int k, int radius) {
  const double x = 2.0 * std::abs(k) / (radius + 1);
  if (x >= 2) return 0;
  return x < 1 ? 2.0 / 3 - x * x * (1 - x / 2) : (2 - x) * (2 - x) * (2 - x) / 6;
}

TemporalReport remove_lighting(int frames, const std::function<TemporalFrame(int)>& load,
                               const std::function<void(int, const TemporalFrame&, Signal)>& store,
                               const LightRemovalOptions& options, const Progress& progress) {
  check(options);
  TemporalReport report;
  report.look_ahead = options.radius;
  Window window;
  int loaded = 0, centre = 0;
  for (int f = 0; f < frames; ++f) {
    const Progress part = progress.step(fmt::format("frame {}", f), 1.0 / frames);
    for (; loaded < std::min(frames, f + options.radius + 1); ++loaded) {
      part.check();
      window.add(load(loaded));
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
        part.step("prepare", 0.6));
    Filtered filtered = equation.solve_towards(mean, frame.space->stiffness_times(frame.psi),
                                               part.step("solve", 0.4));
    report.add(filtered.report);
    store(f, frame, std::move(filtered.signal));
    if (centre < options.radius)
      ++centre;
    else
      window.drop_first();
  }
  return report;
}

}  // namespace mq
