// Curves in tables, against the formulas that they stand for.
#include "mq/model/detail/tabled_curve.h"

#include <gtest/gtest.h>

namespace mq {
namespace {

TEST(TabledCurve, OfDisplayValuesIsWhatIsTabled) {
  double most = 0;
  for (int k = 0; k <= 500'000; ++k) {
    const float light = float(k) * 1e-5F;  // beyond what is tabled, too
    most = std::max(most, std::abs(double(display_of_light(light)) - srgb_from_linear(light)));
  }
  EXPECT_LT(most, 1e-6);
  for (const float light : {0.0F, 1.0F}) EXPECT_NEAR(display_of_light(light), light, 1e-7);
  EXPECT_EQ(display_of_light(-0.3F), float(srgb_from_linear(-0.3F)));
  EXPECT_EQ(display_of_light(9.0F), float(srgb_from_linear(9.0F)));
  EXPECT_TRUE(std::isnan(display_of_light(NAN)));
}

TEST(TabledCurve, IsStraightBetweenItsPlaces) {
  const TabledCurve square([](double x) { return x * x; }, 2, 4);
  EXPECT_FLOAT_EQ(square(0.5F), 0.25F);
  EXPECT_FLOAT_EQ(square(0.75F), 0.625F);
  EXPECT_FLOAT_EQ(square(2), 4);
}

}  // namespace
}  // namespace mq
