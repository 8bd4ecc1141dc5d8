#pragma once
/// Curves of photographs' pixels, of which there are so many that powers and exponentials take longer than reading them.

#include <cmath>
#include <vector>

#include "mq/image/colour.h"

namespace mq {

/// A smooth function from 0 to `end`, straight between `intervals` + 1 places; no more is asked of it.
class TabledCurve {
 public:
  TabledCurve(const auto& function, double end, int intervals)
      : scale_(float(intervals / end)), values_(std::size_t(intervals) + 2) {
    for (std::size_t k = 0; k < values_.size(); ++k) values_[k] = float(function(double(k) * end / intervals));
  }

  float operator()(float x) const {
    const float place = x * scale_;
    const auto k = std::size_t(place);
    return values_[k] + (place - float(k)) * (values_[k + 1] - values_[k]);
  }

 private:
  float scale_;
  std::vector<float> values_;
};

/// `srgb_from_linear` to a part in a million of white: over the root of light it is nearly straight.
inline float display_of_light(float light) {
  constexpr double end = 2;
  static const TabledCurve curve([](double root) { return srgb_from_linear(root * root); }, end, 1 << 14);
  if (!(light >= 0 && light < end * end)) return float(srgb_from_linear(light));
  return curve(std::sqrt(light));
}

}  // namespace mq
