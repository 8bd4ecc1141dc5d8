#include "mq/flow/detail/image_warp.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "flow/waves.h"
#include "mq/base/error.h"
#include "mq/base/random.h"
#include "mq/flow/detail/image_aligner.h"

namespace mq::test {
namespace {

TEST(ImagePaths, FollowCirclesOfARotation) {
  const double turn = 0.8;
  const Image<float> field = field_of(101, 101, [&](double x, double y) {
    return std::array{-turn * (y - 50), turn * (x - 50)};
  });
  const Image<float> d = displacement(field, 1);
  const double error = endpoint_error(d, 25, [&](double x, double y) {
    const double a = x - 50, b = y - 50;
    return std::array{std::cos(turn) * a - std::sin(turn) * b - a,
                      std::sin(turn) * a + std::cos(turn) * b - b};
  });
  EXPECT_LT(error, 36 * std::pow(turn, 5) / 120);  // one step, 36 pixels from the middle at most
  EXPECT_GT(endpoint_error(
                displacement(field, 1, FlowPath::straight), 25,
                [&](double x, double y) {
                  return std::array{double(d(int(x), int(y), 0)), double(d(int(x), int(y), 1))};
                }),
            3);  // straight paths leave the circles
}

TEST(ImagePaths, GoBackWhereTheyCameFrom) {
  const Waves u(40, 80, 1), v(40, 80, 2);
  const Image<float> field = field_of(120, 90, [&](double x, double y) {
    return std::array{6 * u(x, y), 6 * v(x, y)};
  });
  const Image<float> there = displacement(field, 0.5), back = displacement(field, -0.5);
  const Image<float> back_there = displaced(back, there);
  EXPECT_LT(
      endpoint_error(
          back_there, 10,
          [&](double x, double y) {
            return std::array{-double(there(int(x), int(y), 0)), -double(there(int(x), int(y), 1))};
          }),
      2e-3);
}

TEST(ImagePaths, HaveTheOppositeFieldForTheOppositeTimeBitForBit) {
  const Waves u(20, 60, 1), v(20, 60, 2);
  Image<float> field = field_of(60, 50, [&](double x, double y) {
    return std::array{9 * u(x, y), 9 * v(x, y)};
  });
  const Image<float> there = displacement(field, -0.5);
  for (float& value : field.values()) value = -value;
  EXPECT_EQ(displacement(field, 0.5), there);
}

TEST(ImageWarp, ReproducesQuadraticFunctionsAndKeepsPixelsThatStay) {
  const auto quadratic = [](double x, double y) {
    return 1 + 0.2 * x - 0.1 * y + 0.01 * x * y + 0.02 * x * x;
  };
  const Image<float> image = drawn(40, 30, quadratic);
  const Image<float> d = field_of(40, 30, [](double, double) { return std::array{2.3, -1.7}; });
  const Image<float> moved = displaced(image, d, Overshoot::kept);
  for (int y = 6; y < 24; ++y)
    for (int x = 6; x < 34; ++x)
      EXPECT_NEAR(moved(x, y), quadratic(x + 2.3, y - 1.7), 2e-5) << x << ' ' << y;
  EXPECT_EQ(displaced(image, Image<float>(40, 30, 2)), image);
}

TEST(ImageWarp, LeavesNoRangeUnlessAskedTo) {
  Image<float> step(20, 4, 5);
  for (int y = 0; y < 4; ++y)
    for (int x = 10; x < 20; ++x)
      for (float& value : step.pixel(x, y)) value = 1;
  const Image<float> d = field_of(20, 4, [](double, double) { return std::array{0.4, 0.2}; });
  const Image<float> cut = displaced(step, d);
  for (const float value : cut.values()) {
    EXPECT_GE(value, 0);
    EXPECT_LE(value, 1);
  }
  const Image<float> kept = displaced(step, d, Overshoot::kept);
  EXPECT_GT(*std::ranges::max_element(kept.values()), 1.01F);
}

TEST(ImageWarp, TakesPlacesFarOutsideAsTheBorder) {
  const Image<float> image = drawn(5, 5, [](double x, double y) { return x + 10 * y; });
  const Image<float> d = field_of(5, 5, [](double, double) { return std::array{1e30, -1e30}; });
  const Image<float> moved = displaced(image, d);
  for (const float value : moved.values()) EXPECT_EQ(value, 4);
}

TEST(ImageWarp, ScalesFieldsWithTheirImages) {
  const Image<float> field = field_of(12, 8, [](double, double) { return std::array{3.0, -2.0}; });
  const Image<float> larger = resized_field(field, 24, 24);
  EXPECT_EQ(larger(5, 5, 0), 6);
  EXPECT_EQ(larger(5, 5, 1), -6);
}

/// A linear field is linear at any size, at the same places: the middle of pixel x of n lies at (x + ½) / n.
TEST(ImageWarp, ScalesFieldsWhereTheirPixelsLie) {
  const auto field = [](int width, int height) {
    return field_of(width, height, [&](double x, double y) {
      const double s = (x + 0.5) / width, t = (y + 0.5) / height;
      return std::array{width * (0.1 + 0.2 * s - 0.1 * t), height * (0.3 * t - 0.1 * s)};
    });
  };
  const Image<float> small = field(16, 12);
  for (const auto& [width, height] : {std::array{32, 24}, {16, 30}, {40, 12}, {16, 12}}) {
    const Image<float> found = resized_field(small, width, height), truth = field(width, height);
    ASSERT_EQ(found.width(), width);
    ASSERT_EQ(found.height(), height);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        if (const double s = (x + 0.5) / width, t = (y + 0.5) / height; std::min({s, t, 1 - s, 1 - t}) > 0.1) {
          EXPECT_NEAR(found(x, y, 0), truth(x, y, 0), 1e-4);
          EXPECT_NEAR(found(x, y, 1), truth(x, y, 1), 1e-4);
        }
  }
}

/// Of more pixels than a thread takes at once.
TEST(MovedImages, AreComparedWhereBothAreInside) {
  MovedImages before, after;
  const Random random(3);
  const int count = 70000;
  double sum = 0, other = 0;
  for (int k = 0; k < count; ++k) {
    const auto i = std::uint64_t(4 * k);
    before.inside.push_back(random.uniform(i) < 0.8);
    after.inside.push_back(random.uniform(i + 1) < 0.8);
    before.cost.push_back(float(random.uniform(i + 2)));
    after.cost.push_back(float(2 * random.uniform(i + 3)));
    if (before.inside.back() && after.inside.back()) sum += before.cost.back(), other += after.cost.back();
  }
  const MovedCosts found = compared(before, after);
  EXPECT_NEAR(found.before, sum, 1e-6 * sum);
  EXPECT_NEAR(found.after, other, 1e-6 * other);
}

TEST(ImageWarp, SaysWhatItNeeds) {
  EXPECT_THROW(displacement(Image<float>(4, 4, 3), 1), InvalidInput);
  EXPECT_THROW(displaced(Image<float>(4, 4, 3), Image<float>(4, 4, 1)), InvalidInput);
}

}  // namespace
}  // namespace mq::test
