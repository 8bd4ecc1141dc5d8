#include "mq/draw/flow_colour.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace mq {
namespace {

TEST(FlowColour, IsWhiteAtRestAndFullAtTheLongest) {
  EXPECT_EQ(flow_colour(0, 0), (Colour{1, 1, 1}));
  EXPECT_EQ(flow_colour(1, 0), (Colour{1, 0, 0}));
  EXPECT_EQ(flow_colour(0.5, 0), (Colour{1, 0.5F, 0.5F}));
  EXPECT_EQ(flow_colour(2, 0), (Colour{0.75F, 0, 0}));
}

TEST(FlowColour, GoesRoundThroughYellowGreenCyanBlueAndMagenta) {
  // Places of the pure colours on a circle of 55 parts.
  const std::array<std::pair<double, Colour>, 6> pure = {{{0, {1, 0, 0}},
                                                          {15, {1, 1, 0}},
                                                          {21, {0, 1, 0}},
                                                          {25, {0, 1, 1}},
                                                          {36, {0, 0, 1}},
                                                          {49, {1, 0, 1}}}};
  for (const auto& [place, colour] : pure) {
    const double angle = 2 * std::numbers::pi * place / 55;
    const Colour found = flow_colour(std::cos(angle), std::sin(angle));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], colour[c], 1e-6) << place;
  }
}

TEST(FlowColour, ChangesLittleWhereTheVectorDoes) {
  for (int i = 0; i < 1000; ++i) {
    const double a = 2 * std::numbers::pi * i / 1000, b = 2 * std::numbers::pi * (i + 1) / 1000;
    const Colour one = flow_colour(std::cos(a), std::sin(a)),
                 next = flow_colour(std::cos(b), std::sin(b));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(one[c], next[c], 0.02);
  }
}

TEST(FlowColour, ShowsUnknownVectorsBlack) {
  Image<float> field(3, 1, 2);
  field(0, 0, 0) = 4;
  field(1, 0, 0) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(longest(field), 4);
  const Image<float> picture = flow_picture(field, longest(field));
  EXPECT_EQ(picture(1, 0, 0), 0);
  EXPECT_EQ(picture(2, 0, 1), 1);
  EXPECT_NEAR(picture(0, 0, 1), 0, 1e-5);
  const Image<float> both = flow_picture_with_wheel(field, 4);
  EXPECT_GT(both.width(), 80);
  EXPECT_GT(both.height(), 80);
  EXPECT_EQ(flow_picture(Image<float>(2, 2, 2), 0), Image<float>(2, 2, 3, 1));
}

}  // namespace
}  // namespace mq
