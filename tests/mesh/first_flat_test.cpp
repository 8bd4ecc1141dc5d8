// How far vertices in the plane may move until a triangle is flat.

#include <gtest/gtest.h>

#include <cmath>

#include "mq/mesh/first_flat.h"

namespace mq {
namespace {

const std::vector<Triangle> one = {{0, 1, 2}};
const std::vector<Vector2> corner = {{0, 0}, {1, 0}, {0, 1}};

TEST(FirstFlat, IsWhereTheApexMeetsTheBase) {
  const std::vector<Vector2> down = {{0, 0}, {0, 0}, {0, -0.5}};
  EXPECT_DOUBLE_EQ(first_flat(one, corner, down), 2);
}

TEST(FirstFlat, IsInfiniteWhereNothingTurnsOver) {
  const std::vector<Vector2> shift(3, {3, -2}), up = {{0, 0}, {0, 0}, {0, 1}};
  EXPECT_TRUE(std::isinf(first_flat(one, corner, shift)));
  EXPECT_TRUE(std::isinf(first_flat(one, corner, up)));
  EXPECT_TRUE(std::isinf(first_flat({}, {}, {})));
}

TEST(FirstFlat, IsThatOfTheFirstTriangle) {
  const std::vector<Triangle> two = {{0, 1, 2}, {1, 3, 2}};
  const std::vector<Vector2> square = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
  const std::vector<Vector2> inward = {{0, 0}, {0, 0}, {0, 0}, {-1, -1}};
  EXPECT_DOUBLE_EQ(first_flat(two, square, inward), 0.5);
}

}  // namespace
}  // namespace mq
