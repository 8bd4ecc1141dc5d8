// What sums of squares of noise hold, block by block.
#include "mq/filter/detail/noise_blocks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

namespace mq {
namespace {

BlockValues falling(double power) {
  BlockValues variance;
  for (int i = 0; i < block_side; ++i)
    for (int j = 0; j < block_side; ++j)
      variance[std::size_t(i * block_side + j)] = std::pow(1.0 + i + j, -power);
  return variance;
}

/// By drawing blocks of noise.
double drawn_share(const BlockValues& variance) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  std::vector<double> sums(20000, 0.0);
  for (double& sum : sums)
    for (int i = 0; i < block_side; ++i)
      for (int j = 0; j < block_side; ++j)
        if (i + j > 0 && i + j < first_high) {
          const double n = normal(random);
          sum += variance[std::size_t(i * block_side + j)] * n * n;
        }
  std::ranges::sort(sums);
  const auto quarter = sums.begin() + std::ptrdiff_t(sums.size() / 4);
  const double least = std::accumulate(sums.begin(), quarter, 0.0) / double(sums.size() / 4);
  return least / (std::accumulate(sums.begin(), sums.end(), 0.0) / double(sums.size()));
}

TEST(ShareOfLeast, IsThatOfDrawnNoise) {
  for (const double power : {0.0, 1.0, 2.0}) {
    const BlockValues variance = falling(power);
    EXPECT_NEAR(share_of_least(variance), drawn_share(variance), 0.02) << power;
  }
}

/// High frequencies and the mean of a block are in no sum.
TEST(ShareOfLeast, IsOfLowFrequenciesAlone) {
  const BlockValues variance = falling(1);
  for (int i = 0; i < block_side; ++i)
    for (int j = 0; j < block_side; ++j) {
      BlockValues other = variance;
      other[std::size_t(i * block_side + j)] *= 3;
      const bool counts = i + j > 0 && i + j < first_high;
      EXPECT_EQ(share_of_least(other) != share_of_least(variance), counts) << i << ' ' << j;
    }
}

}  // namespace
}  // namespace mq
