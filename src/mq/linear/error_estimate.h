#pragma once
/// How far an iteration still is from its limit.

#include <algorithm>

namespace mq {

/// A residual says little of the error where rows of a matrix differ by orders of magnitude, as those
/// of a chart stretched a hundred times do. What the steps of an iteration change tells more: were each
/// ρ times the one before, Δ·ρ/(1 − ρ) would be missing after a change of Δ. ρ is the larger of the last
/// two ratios, and no less than a tenth.
class ErrorEstimate {
 public:
  /// Missing at most this many tolerances of the largest value: with a tolerance of 1e-6 a quarter of a
  /// step of 16 bits where a value changes from 0 to 1.
  static constexpr double tolerances = 4;

  /// The largest change of a value by one step, and the largest value after it.
  void add_step(double change, double largest) {
    const double ratio = change_ > 0 ? change / change_ : 0.5;
    const double rate = std::clamp(std::max(ratio, ratio_), 0.1, 0.99);
    relative_ = largest > 0 ? change * rate / (1 - rate) / largest : 0;
    change_ = change;
    ratio_ = ratio;
  }

  /// The largest error, relative to the largest value; 0 before the first step.
  double relative() const { return relative_; }
  bool within(double tolerance) const { return relative_ <= tolerances * tolerance; }

 private:
  double change_ = 0, ratio_ = 0, relative_ = 0;
};

}  // namespace mq
