#include "mq/video/relight_meter.h"

#include <algorithm>
#include <cmath>

namespace mq {

void RelightMeter::Sums::compare(const SignalSpace& space, const std::vector<char>& counted,
                                 const Signal& signal, const Signal& truth) {
  compared = true;
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
                             const Signal& signal, const Signal* truth) {
  flicker.add(frame.links, frame.texels->interior, signal);
  gradients += signal.cwiseProduct(space.stiffness_times(signal)).sum();
  if (truth != nullptr) compare(space, frame.texels->interior, signal, *truth);
}

RelightMeasures::Side RelightMeter::Sums::finish() {
  RelightMeasures::Side side{flicker.finish(), {}};
  if (!compared) return side;
  const double factor = products / squares;
  side.truth =
      TruthComparison{factor, std::sqrt(std::max(0.0, truths - factor * products) / values),
                      mixed_gradients / true_gradients};
  return side;
}

void RelightMeter::add(const TemporalFrame& frame, const SignalSpace& space, const Signal& was,
                       const Signal& is, const Signal* truth) {
  before_.add(frame, space, was, truth);
  after_.add(frame, space, is, truth);
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
