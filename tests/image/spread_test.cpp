// Values carried to where there are none.
#include "mq/image/spread.h"

#include <gtest/gtest.h>

#include <limits>

#include "fixtures.h"

namespace mq {
namespace {

TEST(Spread, FindsTheNearest) {
  for (const auto& [width, height, share] :
       {std::tuple{37, 23, 0.9}, {16, 64, 0.99}, {1, 9, 0.6}, {50, 1, 0.8}, {64, 64, 0.5}}) {
    const Image<float> noise = fixtures::noise(width, height, 1);
    Image<char> known(width, height, 1);
    std::vector<std::array<int, 2>> all;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        if (noise(x, y) > share) known(x, y) = 1, all.push_back({x, y});
    ASSERT_FALSE(all.empty());
    const Image<int> nearest = nearest_known(known);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        int least = std::numeric_limits<int>::max();
        for (const auto& [a, b] : all)
          least = std::min(least, (a - x) * (a - x) + (b - y) * (b - y));
        const int a = nearest(x, y) % width, b = nearest(x, y) / width;
        EXPECT_EQ((a - x) * (a - x) + (b - y) * (b - y), least) << x << ", " << y;
        EXPECT_EQ(known(a, b), 1);
      }
  }
}

TEST(Spread, StopsAtItsDistanceAndCopesWithNothing) {
  Image<char> known(9, 9, 1);
  Image<float> picture(9, 9, 2, 0.25F);
  spread(known, 3, picture);
  EXPECT_EQ(picture, Image<float>(9, 9, 2, 0.25F));
  known(4, 4) = 1;
  picture(4, 4, 0) = picture(4, 4, 1) = 1;
  spread(known, 2, picture);
  EXPECT_EQ(picture(4, 6), 1);
  EXPECT_EQ(picture(5, 5), 1);
  EXPECT_EQ(picture(6, 6), 0.25F);
  EXPECT_EQ(picture(4, 7), 0.25F);
}

TEST(Spread, TakesValuesFromSourcesOnlyWhereThereAreAny) {
  Image<char> source(9, 1, 1), known(9, 1, 1);
  Image<float> picture(9, 1, 1, 0.25F);
  known(6, 0) = 1;
  picture(6, 0) = 0.5F;
  spread(source, known, 1, picture);
  EXPECT_EQ(picture(5, 0), 0.5F);
  EXPECT_EQ(picture(4, 0), 0.25F);
  known(0, 0) = source(0, 0) = 1;
  picture(0, 0) = 1;
  spread(source, known, 2, picture);
  EXPECT_EQ(picture(6, 0), 0.5F);
  EXPECT_EQ(picture(4, 0), 1);
  EXPECT_EQ(picture(8, 0), 1);
  EXPECT_EQ(picture(3, 0), 0.25F);
}

}  // namespace
}  // namespace mq
