#pragma once
/// Several places of a texel or a pixel, where one would make stairs of an outline.

#include <algorithm>
#include <array>
#include <cmath>

#include "mq/linear/matrix.h"

namespace mq {

/// From its centre, to the right and down: no two in one row or column but their mirror images, so that an outline that
/// moves on takes them one after the other whichever way it runs.
inline constexpr std::array<std::array<double, 2>, 8> texel_parts{{{-0.375, -0.125},
                                                                   {-0.375, 0.125},
                                                                   {-0.125, -0.375},
                                                                   {-0.125, 0.375},
                                                                   {0.125, -0.375},
                                                                   {0.125, 0.375},
                                                                   {0.375, -0.125},
                                                                   {0.375, 0.125}}};

/// What a path finds, and of what the texel itself has over the signal `before` at the path's start what is left; between
/// both values.
inline double faded(double found, double left, double own, double before) {
  const auto [low, high] = std::minmax(own, found);
  return std::clamp(found + left * (own - before), low, high);
}

/// Per channel by how much neighbours differ where there may be an outline: a twentieth of its standard deviation.
inline Signal least_jumps(const Signal& signal) {
  Signal least(1, signal.cols());
  for (Eigen::Index c = 0; c < signal.cols(); ++c) {
    const auto values = signal.col(c).array();
    least(0, c) = 0.05 * std::sqrt((values - values.mean()).square().mean());
  }
  return least;
}

}  // namespace mq
