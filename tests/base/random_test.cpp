#include "mq/base/random.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <vector>

namespace mq {
namespace {

TEST(Random, IsAFunctionOfSeedStreamAndCount) {
  EXPECT_EQ(Random(7).bits(123), Random(7).bits(123));
  EXPECT_NE(Random(7).bits(123), Random(8).bits(123));
  EXPECT_NE(Random(7).bits(123), Random(7, 1).bits(123));
  EXPECT_NE(Random(7).bits(123), Random(7).bits(124));
}

TEST(Random, IsUniform) {
  const Random random(1);
  const int n = 100000, bins = 100;
  std::vector<int> histogram(bins);
  double sum = 0;
  for (int i = 0; i < n; ++i) {
    const double x = random.uniform(std::uint64_t(i));
    ASSERT_TRUE(x >= 0 && x < 1);
    ++histogram[int(x * bins)];
    sum += x;
  }
  EXPECT_NEAR(sum / n, 0.5, 4 / std::sqrt(12.0 * n));
  double chi_squared = 0;  // mean 99, standard deviation 14 for uniform values
  for (const int k : histogram) chi_squared += std::pow(k - n / bins, 2) / (n / bins);
  EXPECT_NEAR(chi_squared, 99, 60);
}

TEST(Random, ChangesHalfTheBitsFromOneCountSeedOrStreamToTheNext) {
  double counts = 0, seeds = 0, streams = 0;
  const int n = 1000;
  for (std::uint64_t i = 0; i < n; ++i) {
    counts += std::popcount(Random(3).bits(i) ^ Random(3).bits(i + 1));
    seeds += std::popcount(Random(i).bits(5) ^ Random(i + 1).bits(5));
    streams += std::popcount(Random(3, i).bits(5) ^ Random(3, i + 1).bits(5));
  }
  for (const double flips : {counts, seeds, streams}) EXPECT_NEAR(flips / n, 32, 0.5);
}

}  // namespace
}  // namespace mq
