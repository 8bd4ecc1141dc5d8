#pragma once
/// Squares that distances are measured on.

#include <limits>

#include "fem/cut_squares.h"

namespace mq::fixtures {

inline CutOptions whole_square() {
  CutOptions options;
  options.parts = 1;
  options.scale = 1;
  options.jitter = 0;
  return options;
}

inline CutOptions four_charts() { return turned(odd_angle); }

inline int nearest(const Texels& texels, const Vector3& point) {
  int best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < texels.size(); ++i) {
    const auto& p = texels.positions[i];
    const double d = (Vector3(p[0], p[1], p[2]) - point).norm();
    if (d < least) least = d, best = i;
  }
  return best;
}

inline Vector3 position(const Texels& texels, int i) {
  const auto& p = texels.positions[i];
  return {p[0], p[1], p[2]};
}

}  // namespace mq::fixtures
