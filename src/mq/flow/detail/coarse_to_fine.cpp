#include "mq/flow/detail/coarse_to_fine.h"

#include <algorithm>

#include <fmt/format.h>

#include "mq/base/stopwatch.h"

namespace mq {
namespace {

/// α* of (4.8) is cut off where linear models end.
constexpr double largest_scale = 4;

/// X ← X + α*Y, or less of it until the error falls; returns whether it gained enough to go on.
bool follow(FlowDomain& domain, double scale, FlowLevel& level, const FlowOptions& options,
            const FlowPolicy& policy, const Progress& progress) {
  if (options.step_length == FlowStepLength::scaled) {
    domain.attempt(scale);
    domain.take();
    ++level.steps;
    return true;
  }
  const std::optional<FlowErrorChange> change = take_what_gains(domain, scale, policy.halvings, progress);
  if (!change) return false;
  ++level.steps;
  return change->after < (1 - options.least_gain) * change->before;
}

/// IterativeFlowCorrection.
void correct_level(FlowDomain& domain, FlowLevel& level, const FlowOptions& options,
                   const FlowPolicy& policy, const Progress& progress) {
  const int steps = domain.most_steps();
  for (int step = 0; step < steps; ++step) {
    const double error = domain.level_error();
    if (!(error > 0)) return;
    progress.at(double(step) / steps, fmt::format("error {:.3g}", error));
    const double scale = domain.correct(progress, 1.0 / steps);
    if (!(scale > 0) || !follow(domain, scale, level, options, policy, progress)) return;
  }
}

/// The best field's error measured, where `best` was an estimate: none above the blend's is kept, and
/// no earlier level is said to have been better.
void settle(FlowDomain& domain, double& best, std::vector<double>& errors) {
  const std::optional<double> settled = domain.settled_error();
  if (!settled) return;
  best = *settled;
  if (!(best < errors.front())) {
    best = errors.front();
    domain.forget();
  }
  for (double& error : errors) error = std::max(error, best);
}

}  // namespace

std::optional<FlowErrorChange> take_what_gains(FlowCorrection& correction, double scale, int halvings,
                                               const Progress& progress) {
  double factor = std::min(scale, largest_scale);
  for (int half = 0; half <= halvings; ++half, factor /= 2) {
    progress.check();
    const FlowErrorChange change = correction.attempt(factor);
    if (change.after < change.before) {
      correction.take();
      return change;
    }
    correction.leave();
  }
  return {};
}

std::vector<FlowScale> halved_scales(double largest, double above, int most) {
  std::vector<FlowScale> scales;
  for (double length = largest; length > above && std::ssize(scales) < most; length /= 2)
    scales.push_back({length});
  return scales;
}

std::vector<double> coarse_to_fine(FlowDomain& domain, const std::vector<FlowScale>& scales,
                                   const FlowOptions& options, const FlowPolicy& policy,
                                   const Progress& progress) {
  double best = domain.blend_error();
  std::vector<double> errors{best};
  double work = 0;
  for (const FlowScale& scale : scales) work += domain.work(scale);
  bool worse = false;  // X is not the best field
  for (const FlowScale& scale : scales) {
    const Stopwatch watch;
    const Progress step =
        progress.step(domain.name(scale), policy.share * domain.work(scale) / work);
    FlowLevel& level = domain.enter(scale);
    level.length = scale.length;
    if (worse && policy.after_worse == FlowPolicy::AfterWorse::better) domain.go_back_if_better();
    domain.look_up();
    settle(domain, best, errors);
    correct_level(domain, level, options, policy, step);
    const double error = domain.measure();
    worse = !(error < best) && options.step_length == FlowStepLength::falling_error;
    if (!worse) {
      domain.keep();
      best = error;
    }
    errors.push_back(best);
    level.seconds = watch.seconds();
    step.at(1);
  }
  domain.finish();
  settle(domain, best, errors);
  return errors;
}

}  // namespace mq
