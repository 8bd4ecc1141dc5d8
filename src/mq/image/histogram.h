#pragma once
/// How often values occur, and how many lie beyond black and white.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "mq/base/parallel.h"

namespace mq {

struct Histogram {
  std::vector<std::int64_t> counts;  ///< of values in [i, i + 1) / size; the last also has 1
  std::int64_t below = 0, above = 0;  ///< 0 and 1 by more than rounding: what a picture of whole numbers clamps
  std::int64_t count = 0;            ///< of all values; those that are no numbers are in no bin

  /// Of all values, 0 to 1; 0 where there is none.
  double clamped_share() const { return count > 0 ? double(below + above) / double(count) : 0; }
};

/// Of value(0) to value(count − 1), called in parallel. What lies no further beyond 0 or 1 than `half_step`, half a step of the
/// picture that shows them, is in the first or last bin. Equal for any number of threads.
template <class Value>
Histogram histogram(std::int64_t count, int bins, double half_step, const Value& value) {
  constexpr std::int64_t block = 1 << 14;
  const std::int64_t blocks = (count + block - 1) / block;
  std::vector<Histogram> parts(std::size_t(std::max<std::int64_t>(blocks, 0)));
  parallel_for(blocks, [&](std::int64_t b) {
    Histogram& part = parts[std::size_t(b)];
    part.counts.assign(std::size_t(bins), 0);
    for (std::int64_t i = b * block; i < std::min(count, (b + 1) * block); ++i) {
      const double v = double(value(i));
      ++part.count;
      if (v < -half_step)
        ++part.below;
      else if (v > 1 + half_step)
        ++part.above;
      else if (!std::isnan(v))
        ++part.counts[std::size_t(std::clamp(int(v * bins), 0, bins - 1))];
    }
  }, 1);
  Histogram whole;
  whole.counts.assign(std::size_t(bins), 0);
  for (const Histogram& part : parts) {
    for (std::size_t i = 0; i < whole.counts.size(); ++i) whole.counts[i] += part.counts[i];
    whole.below += part.below;
    whole.above += part.above;
    whole.count += part.count;
  }
  return whole;
}

}  // namespace mq
