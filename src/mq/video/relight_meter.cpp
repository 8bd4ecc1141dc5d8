#include "mq/video/relight_meter.h"

#include <algorithm>
#include <cmath>

namespace mq {

void RelightMeter::Sums::compare_steps(const TemporalFrame& frame, const Signal& signal, const Signal& truth) {
  const std::vector<char>& counted = frame.texels->interior;
  for (int t = 0; t < frame.links.rows() && last.rows() > 0; ++t) {
    const int before = counted[t] ? frame.links.same(t) : -1;
    if (before < 0 || before >= last.rows() || !last_counted[before]) continue;
    const Eigen::RowVectorXd step = signal.row(t) - last.row(before), true_step = truth.row(t) - last_truth.row(before);
    steps += step.squaredNorm();
    mixed_steps += step.dot(true_step);
    true_steps += true_step.squaredNorm();
    step_count += double(signal.cols());
  }
  last = signal;
  last_truth = truth;
  last_counted = counted;
}

void RelightMeter::Sums::compare(const TemporalFrame& frame, const SignalSpace& space, const Signal& signal,
                                 const Signal& truth) {
  compared = true;
  compare_steps(frame, signal, truth);
  const std::vector<char>& counted = frame.texels->interior;
  for (int t = 0; t < signal.rows(); ++t) {
    if (!counted[t]) continue;
    products += signal.row(t).dot(truth.row(t));
    squares += signal.row(t).squaredNorm();
    truths += truth.row(t).squaredNorm();
    values += double(signal.cols());
  }
  const Signal gradient = space.stiffness_times(truth);
  mixed_gradients += signal.cwiseProduct(gradient).sum();
  true_gradients += truth.cwiseProduct(gradient).sum();
}

void RelightMeter::Sums::add(const TemporalFrame& frame, const SignalSpace& space,
                             const Signal& signal, const Signal* truth, const FrameDrift* drift) {
  flicker.add(frame.links, frame.texels->interior, signal, drift);
  gradients += signal.cwiseProduct(space.stiffness_times(signal)).sum();
  if (truth != nullptr) compare(frame, space, signal, *truth);
}

RelightMeasures::Side RelightMeter::Sums::finish() {
  RelightMeasures::Side side{flicker.finish(), {}};
  if (!compared) return side;
  const double factor = products / squares;
  side.truth =
      TruthComparison{.factor = factor,
                      .error = std::sqrt(std::max(0.0, truths - factor * products) / values),
                      .sharpness = mixed_gradients / true_gradients};
  const double changes = factor * (factor * steps - 2 * mixed_steps) + true_steps;
  if (step_count > 0) side.truth->flicker = std::sqrt(std::max(0.0, 0.5 * changes / step_count));
  return side;
}

void RelightMeter::add(const TemporalFrame& frame, const SignalSpace& space, const Signal& was,
                       const Signal& is, const Signal* truth, const FrameDrift* drift) {
  before_.add(frame, space, was, truth, drift);
  after_.add(frame, space, is, truth, drift);
}

RelightMeasures RelightMeter::finish() {
  RelightMeasures measures;
  measures.before = before_.finish();
  measures.after = after_.finish();
  if (before_.gradients > 0)
    measures.gradients = std::sqrt(std::max(0.0, after_.gradients) / before_.gradients);
  return measures;
}

}  // namespace mq
