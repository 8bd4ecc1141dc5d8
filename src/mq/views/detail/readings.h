#pragma once
/// What an observation says of exposure.

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <vector>

#include "mq/views/view_choice.h"

namespace mq {

/// Not where a channel is black or clipped, in light, nor what is rejected.
inline bool tells_exposure(const Observation& o) {
  constexpr float black = 0.01F, clipped = 0.98F;
  return !o.rejected && std::ranges::min(o.colour) >= black && std::ranges::max(o.colour) <= clipped;
}

/// What falloff is made of, at a radius.
inline Eigen::Vector2d falloff_bases(double radius) { return {radius * radius, std::pow(radius, 4)}; }

/// The upper one of an even number; reorders the values.
inline double median_of(std::vector<double>& values) {
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace mq
