#include "mq/video/gutter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mq/base/error.h"

namespace mq {
namespace {

TEST(Gutter, StaysAsItWasWhereNobodyLooks) {
  Image<char> inside(20, 12, 1);
  for (int y = 4; y < 7; ++y)
    for (int x = 5; x < 9; ++x) inside(x, y) = 1;
  Image<float> before(20, 12, 3, 0.25F), picture(20, 12, 3, 0.75F);
  hold_gutter(inside, 2.5, before, picture);
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 20; ++x) {
      const int dx = std::max({5 - x, x - 8, 0}), dy = std::max({4 - y, y - 6, 0});
      for (int c = 0; c < 3; ++c)
        EXPECT_EQ(picture(x, y, c), std::hypot(dx, dy) <= 2.5 ? 0.75F : 0.25F) << x << " " << y;
    }
}

TEST(Gutter, IsAllThereIsWithoutCharts) {
  Image<float> picture(4, 4, 1, 1.0F);
  const Image<float> before(4, 4, 1, 0.5F);
  hold_gutter(Image<char>(4, 4, 1), 2.5, before, picture);
  EXPECT_TRUE(picture == before);
  EXPECT_THROW(hold_gutter(Image<char>(4, 4, 1), 2.5, Image<float>(4, 5, 1), picture),
               InvalidInput);
}

TEST(Gutter, HasTheValuesOfTheNearestTexelOfAChart) {
  Texels texels;
  texels.places = {{.texture = 0, .x = 1, .y = 2}, {.texture = 0, .x = 6, .y = 2}};
  Image<float> picture(8, 5, 1, 0.0F);
  picture(1, 2) = 0.25F;
  picture(6, 2) = 0.75F;
  const Image<char> inside = spread_from_charts(texels, picture);
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 8; ++x) {
      EXPECT_EQ(inside(x, y), y == 2 && (x == 1 || x == 6)) << x << " " << y;
      EXPECT_EQ(picture(x, y), x < 4 ? 0.25F : 0.75F) << x << " " << y;
    }
}

}  // namespace
}  // namespace mq
