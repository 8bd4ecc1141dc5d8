#include "mq/filter/detail/fireflies.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "mq/base/parallel.h"

namespace mq {

namespace {

/// A texel that surpasses all around it by so many deviations of noise is none of it.
constexpr float outlying = 6;
constexpr int least_around = 5;

/// A texel and what it becomes.
using Replaced = std::pair<int, Eigen::RowVectorXf>;

/// The unknowns around a place of the window.
struct Around {
  Around(const ChartWindow& window, int x, int y) {
    for (int j = -1; j <= 1; ++j)
      for (int i = -1; i <= 1; ++i)
        if (const int u = window.unknowns[std::size_t((y + j) * window.width + x + i)]; (i != 0 || j != 0) && u >= 0)
          unknowns[std::size_t(count++)] = u;
  }

  /// Orders them.
  float median(const TexelValues& values, int channel) {
    std::ranges::sort(unknowns.begin(), unknowns.begin() + count, {},
                      [&](int u) { return std::pair(values(u, channel), u); });
    return values(unknowns[std::size_t(count / 2)], channel);
  }

  std::array<int, 8> unknowns{};
  int count = 0;
};

void find_fireflies(const ChartWindow& window, const NoiseCurve& noise, const TexelValues& values,
                   std::vector<Replaced>& found) {
  for (int y = 1; y + 1 < window.height; ++y)
    for (int x = 1; x + 1 < window.width; ++x) {
      const auto at = std::size_t(y * window.width + x);
      if (window.own[at] != 1) continue;
      Around around(window, x, y);
      if (around.count < least_around) continue;
      const float own = values(window.unknowns[at], 0);
      float most = values(around.unknowns[0], 0);
      for (int n = 1; n < around.count; ++n) most = std::max(most, values(around.unknowns[std::size_t(n)], 0));
      if (own <= most) continue;
      if (own <= most + outlying * float(noise.at(double(around.median(values, 0)), 0))) continue;
      Eigen::RowVectorXf median(values.cols());
      for (int c = 0; c < int(values.cols()); ++c) median[c] = around.median(values, c);
      found.emplace_back(window.unknowns[at], median);
    }
}

}  // namespace

int take_fireflies_off(const ChartWindows& windows, const NoiseCurve& noise, TexelValues& values) {
  int count = 0;
  for (int round = 0; round < 2; ++round) {
    std::vector<std::vector<Replaced>> found(std::size_t(windows.count()));
    parallel_for(
        windows.count(),
        [&](std::int64_t k) { find_fireflies(windows.window(int(k), 1), noise, values, found[std::size_t(k)]); }, 1);
    for (const auto& of_window : found)
      for (const auto& [u, median] : of_window) values.row(u) = median, ++count;
  }
  return count;
}

}  // namespace mq
