#include "mq/video/flicker.h"

#include <cmath>

namespace mq {

void FlickerMeter::end_life(int row) {
  if (lived_[row] < 2) return;
  const double n = lived_[row];
  deviations_ += (squares_.row(row).array() - sum_.row(row).array().square() / n).sum();
  freedoms_ += (n - 1) * double(sum_.cols());
}

void FlickerMeter::add_along(const TimeLinks& links, const std::vector<char>& counted, const Signal& signal,
                             const FrameDrift& drift) {
  const FrameDrift::HalfWay at = drift.half_way();
  for (int t = 0; t < signal.rows(); ++t) {
    const int before = counted[t] ? links.same(t) : -1;
    if (before < 0 || lived_[before] == 0 || at.now[t].chart < 0) continue;
    along_ += 0.5 * (signal.row(t) + drift.change(signal, t, at.now[t]) - last_.row(before) -
                     drift.change(last_, before, at.before[t]))
                        .squaredNorm();
    along_count_ += double(signal.cols());
  }
}

void FlickerMeter::add(const TimeLinks& links, const std::vector<char>& counted,
                       const Signal& signal, const FrameDrift* drift) {
  if (drift != nullptr && drift->follows() && last_.rows() == signal.rows() && links.rows() == signal.rows())
    add_along(links, counted, signal, *drift);
  Signal sum = Signal::Zero(signal.rows(), signal.cols()), squares = sum;
  std::vector<int> lived(std::size_t(signal.rows()), 0);
  std::vector<char> goes_on(lived_.size(), 0);
  for (int t = 0; t < signal.rows(); ++t) {
    if (!counted[t]) continue;
    const int before = t < links.rows() ? links.same(t) : -1;
    if (before >= 0 && before < int(lived_.size()) && lived_[before] > 0 && !goes_on[before]) {
      goes_on[before] = 1;
      sum.row(t) = sum_.row(before);
      squares.row(t) = squares_.row(before);
      lived[t] = lived_[before];
      steps_ += 0.5 * (signal.row(t) - last_.row(before)).squaredNorm();
      step_count_ += double(signal.cols());
    }
    sum.row(t) += signal.row(t);
    squares.row(t).array() += signal.row(t).array().square();
    ++lived[t];
    ++values_;
  }
  for (int t = 0; t < int(lived_.size()); ++t)
    if (!goes_on[t]) end_life(t);
  sum_ = std::move(sum);
  squares_ = std::move(squares);
  lived_ = std::move(lived);
  last_ = signal;
}

Flicker FlickerMeter::finish() {
  for (int t = 0; t < int(lived_.size()); ++t) end_life(t);
  lived_.clear();
  return {.deviation = freedoms_ > 0 ? std::sqrt(std::max(0.0, deviations_ / freedoms_)) : 0,
          .step = step_count_ > 0 ? std::sqrt(steps_ / step_count_) : 0,
          .along = along_count_ > 0 ? std::optional(std::sqrt(along_ / along_count_)) : std::nullopt,
          .values = values_};
}

}  // namespace mq
