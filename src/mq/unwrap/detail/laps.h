#pragma once
/// How long the steps of a piece of work take.

#include <string>
#include <vector>

#include "mq/base/stopwatch.h"
#include "mq/unwrap/unwrap.h"

namespace mq {

/// Appends, step by step, the seconds since the last one.
class Laps {
 public:
  explicit Laps(std::vector<UnwrapFigures::Seconds>& seconds) : seconds_(seconds) {}

  void operator()(const std::string& step) {
    const double now = watch_.seconds();
    seconds_.push_back({step, now - before_});
    before_ = now;
  }

 private:
  std::vector<UnwrapFigures::Seconds>& seconds_;
  Stopwatch watch_;
  double before_ = 0;
};

}  // namespace mq
