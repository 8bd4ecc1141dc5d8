#include <gtest/gtest.h>

#include <limits>
#include <numeric>
#include <vector>

#include "mq/image/histogram.h"

namespace mq::test {
namespace {

TEST(Histograms, CountValuesInBinsAndBeyondThem) {
  const std::vector<double> values = {-0.5, 0, 0.2, 0.25, 0.999, 1, 1.5, 2,
                                      std::numeric_limits<double>::quiet_NaN()};
  const Histogram found =
      histogram(std::ssize(values), 4, 0, [&](std::int64_t i) { return values[std::size_t(i)]; });
  EXPECT_EQ(found.counts, (std::vector<std::int64_t>{2, 1, 0, 2}));
  EXPECT_EQ(found.below, 1);
  EXPECT_EQ(found.above, 2);
  EXPECT_EQ(found.count, 9);
  EXPECT_DOUBLE_EQ(found.clamped_share(), 3.0 / 9);
}

TEST(Histograms, TakeWhatRoundsToBlackAndWhiteForThese) {
  const std::vector<double> values = {-0.0015, -0.0025, 1.0015, 1.0025, 0.5};
  const Histogram found =
      histogram(std::ssize(values), 2, 0.002, [&](std::int64_t i) { return values[std::size_t(i)]; });
  EXPECT_EQ(found.counts, (std::vector<std::int64_t>{1, 2}));
  EXPECT_EQ(found.below, 1);
  EXPECT_EQ(found.above, 1);
}

TEST(Histograms, MissNoValueOfMany) {
  const std::int64_t count = 100003;
  const Histogram found = histogram(count, 10, 0, [&](std::int64_t i) { return double(i) / double(count); });
  EXPECT_EQ(std::accumulate(found.counts.begin(), found.counts.end(), std::int64_t(0)), count);
  for (const std::int64_t one : found.counts) EXPECT_NEAR(double(one), double(count) / 10, 1);
}

TEST(Histograms, OfNothingAreEmpty) {
  const Histogram found = histogram(0, 3, 0, [](std::int64_t) { return 0.0; });
  EXPECT_EQ(found.count, 0);
  EXPECT_EQ(found.clamped_share(), 0);
}

}  // namespace
}  // namespace mq::test
