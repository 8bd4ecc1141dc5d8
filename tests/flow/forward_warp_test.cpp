#include "mq/flow/forward_warp.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "flow/waves.h"
#include "mq/base/error.h"
#include "mq/flow/image_flow.h"

namespace mq::test {
namespace {


Image<float> no_cost(const Image<float>& field) {
  return Image<float>(field.width(), field.height(), 1);
}

TEST(ForwardWarpedField, IsItselfAtTheStart) {
  const Image<float> field = field_of(9, 7, [](double x, double y) {
    return std::array{3 * std::sin(x), y - 3};
  });
  const ForwardWarpedField start = forward_warp(field, 0, no_cost(field));
  EXPECT_EQ(start.field, field);
  EXPECT_EQ(std::ranges::count(start.seen.values(), 1), 63);
}

/// What moves out at one side comes in at none.
TEST(ForwardWarpedField, LeavesWhatNothingComesToUnseen) {
  for (const auto& [u, v] : {std::array{5, 0}, {-5, 0}, {0, 4}, {0, -4}, {3, -2}}) {
    const Image<float> field = field_of(30, 20, [&](double, double) { return std::array{double(u), double(v)}; });
    const ForwardWarpedField end = forward_warp(field, 1, no_cost(field));
    for (int y = 0; y < 20; ++y)
      for (int x = 0; x < 30; ++x)
        EXPECT_EQ(end.seen(x, y), x - u >= 0 && x - u < 30 && y - v >= 0 && y - v < 20) << u << ' ' << v << ": " << x << ' ' << y;
  }
}

/// u = A·p + b: what is at q at time t was at p = (1 + tA)⁻¹(q − tb).
TEST(ForwardWarpedField, IsExactForAffineMotions) {
  const double a = 0.1, b = -0.3, c = 0.2, d = 0.15, e = 1.5, f = -0.7;
  const Image<float> field = field_of(50, 40, [&](double x, double y) {
    return std::array{a * (x - 25) + b * (y - 20) + e, c * (x - 25) + d * (y - 20) + f};
  });
  for (const double t : {0.25, 0.5, 1.0}) {
    const ForwardWarpedField on_the_way = forward_warp(field, t, no_cost(field));
    const double determinant = (1 + t * a) * (1 + t * d) - t * t * b * c;
    for (int y = 14; y < 26; ++y)
      for (int x = 15; x < 35; ++x) {
        const double r = x - 25 - t * e, s = y - 20 - t * f;
        const double px = ((1 + t * d) * r - t * b * s) / determinant;
        const double py = ((1 + t * a) * s - t * c * r) / determinant;
        ASSERT_EQ(on_the_way.seen(x, y), 1);
        EXPECT_NEAR(on_the_way.field(x, y, 0), a * px + b * py + e, 1e-4);
        EXPECT_NEAR(on_the_way.field(x, y, 1), c * px + d * py + f, 1e-4);
      }
  }
}

/// Columns 20 to 39 move by 12 over what rests; what they come to lie on agrees with nothing.
TEST(ForwardWarpedField, ShowsWhatMovesOverWhatItHides) {
  const Image<float> field = field_of(80, 10, [](double x, double) {
    return std::array{x >= 20 && x < 40 ? 12.0 : 0.0, 0.0};
  });
  Image<float> cost = no_cost(field);
  for (int y = 0; y < 10; ++y)
    for (int x = 40; x < 52; ++x) cost(x, y) = 1;
  const ForwardWarpedField halfway = forward_warp(field, 0.5, cost);
  for (int y = 0; y < 10; ++y)
    for (int x = 0; x < 80; ++x) {
      if (x > 19 && x < 26) {
        EXPECT_EQ(halfway.seen(x, y), 0) << x;  // behind it nothing of the first is known
        continue;
      }
      EXPECT_EQ(halfway.seen(x, y), 1) << x;
      EXPECT_EQ(halfway.field(x, y, 0), x >= 26 && x < 46 ? 12 : 0) << x;
    }
}

TEST(ForwardWarpedField, CopesWithAnyField) {
  for (const auto& [width, height] : {std::pair{1, 1}, {1, 8}, {8, 1}, {6, 6}})
    for (const double far : {0.0, 0.4, 30.0, 1e8}) {
      const Image<float> field = field_of(width, height, [&](double x, double y) {
        return std::array{far * std::sin(9 * x + y), far * std::cos(7 * y - x)};
      });
      const ForwardWarpedField later = forward_warp(field, 0.5, no_cost(field));
      for (const float value : later.field.values()) EXPECT_TRUE(std::isfinite(value));
      const auto hidden = std::ranges::count(later.seen.values(), 0);
      EXPECT_TRUE(far > 0 || hidden == 0);
    }
  const Image<float> field(4, 4, 2);
  EXPECT_THROW(forward_warp(field, 0.5, Image<float>(3, 4, 1)), InvalidInput);
  EXPECT_THROW(forward_warp(Image<float>(4, 4, 1), 0.5, no_cost(field)), InvalidInput);
}

TEST(CompletedField, TakesWhatIsNotKnownFromTheNearest) {
  Image<float> field = field_of(5, 1, [](double x, double) { return std::array{x, 1.0}; });
  for (const int x : {1, 3, 4}) field(x, 0, 0) = field(x, 0, 1) = nan;
  const Image<float> whole = completed(field);
  EXPECT_EQ(whole(0, 0), 0);
  EXPECT_EQ(whole(3, 0), 2);
  EXPECT_EQ(whole(4, 0), 2);
  EXPECT_EQ(whole(1, 0, 1), 1);
  EXPECT_THROW(completed(Image<float>(3, 3, 2, nan)), InvalidInput);
}

/// A signal that spreads from the middle by a fifth, exactly known.
TEST(KnownFlow, ShowsWhatLiesBetween) {
  const Waves waves(8, 192);
  const double middle = 99.5;
  const auto spread_by = [&](double factor) {
    return drawn(200, 200, [&](double x, double y) {
      return waves(middle + (x - middle) / factor, middle + (y - middle) / factor);
    });
  };
  const Image<float> source = spread_by(1), target = spread_by(1.2);
  Image<float> displacement = field_of(200, 200, [&](double x, double y) {
    return std::array{0.2 * (x - middle), 0.2 * (y - middle)};
  });
  displacement(60, 70, 0) = displacement(60, 70, 1) = nan;
  const ImageFlow flow = known_flow(source, target, displacement);
  ASSERT_EQ(flow.error.size(), 2U);
  // What leaves counts as in the blend: 1 − 1/1.44 of the pixels, which differ more than the rest.
  EXPECT_LT(flow.error[1], 0.4 * flow.error[0]);
  EXPECT_EQ(interpolated(flow, source, target, 0), source);
  for (const double t : {0.25, 0.5, 0.75}) {
    const Image<float> between = interpolated(flow, source, target, t),
                       truth = spread_by(1 + 0.2 * t);
    double with_flow = 0, blend = 0;
    for (int y = 20; y < 180; ++y)
      for (int x = 20; x < 180; ++x) {
        with_flow += std::pow(between(x, y) - truth(x, y), 2);
        blend += std::pow((1 - t) * source(x, y) + t * target(x, y) - truth(x, y), 2);
      }
    EXPECT_LT(with_flow, 1e-4 * blend) << t;
  }
  EXPECT_THROW(known_flow(source, target, Image<float>(200, 199, 2)), InvalidInput);
}

}  // namespace
}  // namespace mq::test
