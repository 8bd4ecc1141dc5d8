#include "mq/flow/flow_errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "flow/waves.h"
#include "mq/base/error.h"

namespace mq {
namespace {

using test::nan;

Image<float> row(const std::vector<std::array<float, 2>>& vectors) {
  Image<float> field(int(vectors.size()), 1, 2);
  for (std::size_t i = 0; i < vectors.size(); ++i)
    for (int c = 0; c < 2; ++c) field(int(i), 0, c) = vectors[i][std::size_t(c)];
  return field;
}

TEST(FlowErrors, AreDistancesAndAnglesInSpaceAndTime) {
  const FlowErrors one = flow_errors(row({{1, 0}}), row({{0, 0}}));
  EXPECT_EQ(one.pixels, 1);
  EXPECT_DOUBLE_EQ(one.endpoint, 1);
  EXPECT_NEAR(one.angular, 45, 1e-12);
  // (1, 0, 1) and (0, 1, 1) lie 60 degrees apart.
  EXPECT_NEAR(flow_errors(row({{1, 0}}), row({{0, 1}})).angular, 60, 1e-12);
  EXPECT_NEAR(flow_errors(row({{1e6F, 0}}), row({{-1e6F, 0}})).angular, 180, 1e-3);
  const FlowErrors two = flow_errors(row({{3, 4}, {7, 7}}), row({{0, 0}, {7, 7}}));
  EXPECT_DOUBLE_EQ(two.endpoint, 2.5);
  EXPECT_DOUBLE_EQ(two.endpoint_root_mean_square, 5 / std::numbers::sqrt2);
  // Small angles keep their digits: 1e-4 across one pixel a frame.
  EXPECT_NEAR(flow_errors(row({{1e-4F, 0}}), row({{0, 0}})).angular, 1e-4 * 180 / std::numbers::pi,
              1e-9);
}

TEST(FlowErrors, CountAsOutliersWhatIsFarOffAlsoBesideTheMotion) {
  const FlowErrors errors = flow_errors(row({{104, 0}, {14, 0}, {2.9F, 0}, {0, 0}}),
                                        row({{100, 0}, {10, 0}, {0, 0}, {0, 0}}));
  EXPECT_DOUBLE_EQ(errors.outliers, 0.25);
}

TEST(FlowErrors, LeaveOutWhereTheTruthIsNotKnown) {
  const Image<float> truth = row({{nan, nan}, {1, 1}}), field = row({{9, 9}, {1, 3}});
  EXPECT_EQ(flow_errors(field, truth).pixels, 1);
  EXPECT_DOUBLE_EQ(flow_errors(field, truth).endpoint, 2);
  EXPECT_TRUE(std::isnan(endpoint_errors(field, truth)(0, 0)));
  EXPECT_EQ(endpoint_errors(field, truth)(1, 0), 2);
  // A field without an answer there rests.
  EXPECT_DOUBLE_EQ(flow_errors(row({{0, 0}, {nan, nan}}), row({{0, 0}, {3, 4}})).endpoint, 2.5);
  EXPECT_THROW(flow_errors(field, row({{nan, 0}, {0, nan}})), InvalidInput);
  EXPECT_THROW(flow_errors(field, row({{0, 0}})), InvalidInput);
  EXPECT_THROW(flow_errors(field, Image<float>(2, 1, 3)), InvalidInput);
}

}  // namespace
}  // namespace mq
