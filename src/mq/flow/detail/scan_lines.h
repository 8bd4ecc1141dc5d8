#pragma once
/// Labels of pixels, summed along lines.

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "mq/base/parallel.h"

namespace mq {

/// What labels cost at each pixel: pixel by pixel, row by row, `count` numbers each.
struct LabelCosts {
  int width = 0, height = 0, count = 0;
  std::vector<float> values;
  LabelCosts(int w, int h, int labels)
      : width(w), height(h), count(labels), values(std::size_t(w) * std::size_t(h) * std::size_t(labels)) {}
  float* at(std::int64_t pixel) { return values.data() + pixel * count; }
  const float* at(std::int64_t pixel) const { return values.data() + pixel * count; }
};

/// Semi-global matching [hirschmuller2008stereo] along rows and columns, both ways:
///
///     Σ_q L_q(p, k),    L_q(p, k) = C(p, k) + M_q(k) − min_j M_q(j),    M_q(k) = min_j (L(q, j) + V(q, j, p, k)),
///
/// q the neighbour of p that a line comes from. `message(q, L(q, ·), p, M)` writes M. Lines run side by side; the sums
/// do not depend on the number of threads.
template <class Message>
LabelCosts summed_along_lines(const LabelCosts& costs, const Message& message) {
  LabelCosts sums(costs.width, costs.height, costs.count);
  const int labels = costs.count;
  const auto follow = [&](std::int64_t first, std::int64_t step, int pixels) {
    std::vector<float> last(costs.at(first), costs.at(first) + labels), next(last);
    for (int i = 0; i < pixels; ++i) {
      const std::int64_t p = first + i * step;
      if (i > 0) {
        message(p - step, last.data(), p, next.data());
        const float least = *std::min_element(next.begin(), next.end());
        const float* cost = costs.at(p);
        for (int k = 0; k < labels; ++k) next[std::size_t(k)] += cost[k] - least;
      }
      float* sum = sums.at(p);
      for (int k = 0; k < labels; ++k) sum[k] += next[std::size_t(k)];
      std::swap(last, next);
    }
  };
  const std::int64_t width = costs.width, height = costs.height;
  parallel_for(
      height,
      [&](std::int64_t y) {
        follow(y * width, 1, costs.width);
        follow(y * width + width - 1, -1, costs.width);
      },
      1);
  parallel_for(
      width,
      [&](std::int64_t x) {
        follow(x, width, costs.height);
        follow(x + (height - 1) * width, -width, costs.height);
      },
      1);
  return sums;
}

}  // namespace mq
