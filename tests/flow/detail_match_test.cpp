// Whether what a field brings together is the same thing: detail that is alike, and how the field bends.
#include "mq/flow/detail/detail_match.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "flow/waves.h"
#include "mq/base/random.h"
#include "mq/flow/image_flow.h"

namespace mq::test {
namespace {

constexpr int width = 200, height = 160;

/// Detail that is stronger here and weaker there, as photographs have it.
Image<float> scene(double way, std::uint64_t seed) {
  const Waves waves(4, 60, seed, 80);
  return drawn(width, height, [&](double x, double y) {
    const double strength = 0.5 + 0.5 * std::sin((x - way) / 12) * std::sin(y / 12);
    return 1.5 * std::max(0.02, strength * strength) * waves(x - way, y);
  });
}

DetailMatch match_of(const Image<float>& source, const Image<float>& target, const Motion& motion) {
  return detail_match({source, target}, field_of(width, height, motion), std::vector<char>(width * height, 1));
}

const Motion right_by_six = [](double, double) { return std::array{6.0, 0.0}; };

TEST(DetailMatch, IsAllAlongTheMotionItself) {
  const DetailMatch found = match_of(scene(0, 3), scene(6, 3), right_by_six);
  EXPECT_GT(found.alike, 0.95);
  EXPECT_NEAR(found.bend, 0, 1e-6);
}

TEST(DetailMatch, IsLittleOfDifferentThings) {
  EXPECT_LT(match_of(scene(0, 3), scene(6, 4), right_by_six).alike, 0.2);
  EXPECT_LT(match_of(scene(0, 3), scene(6, 3), [](double, double) { return std::array{-9.0, 5.0}; }).alike, 0.2);
}

/// Nobody can tell by what has no detail, nor by what is hidden.
TEST(DetailMatch, IsOfWhatHasDetailAndIsSeen) {
  const Image<float> flat(width, height, 1);
  EXPECT_EQ(match_of(flat, flat, right_by_six).alike, 1);
  const Image<float> other = scene(6, 4);
  Image<float> half = scene(6, 3);
  std::vector<char> seen(width * height, 1);
  for (int y = 0; y < height; ++y)
    for (int x = width / 2; x < width; ++x) half(x, y) = other(x, y), seen[std::size_t(y * width + x)] = 0;
  EXPECT_GT(detail_match({scene(0, 3), half}, field_of(width, height, right_by_six), seen).alike, 0.85);
}

TEST(DetailMatch, KnowsABendFromATurn) {
  const Image<float> flat(width, height, 1);
  const Motion turn = [](double x, double y) { return std::array{0.3 * (y - 80), -0.3 * (x - 100)}; };
  const Motion bent = [](double x, double y) { return std::array{8 * std::sin(x / 8), 8 * std::sin(y / 8)}; };
  EXPECT_LT(match_of(flat, flat, turn).bend, 0.01);
  EXPECT_GT(match_of(flat, flat, bent).bend, 0.6);
}

/// A scene and its mirror image, whose values a field brings together all the same.
TEST(ImageFlow, BlendsMirrorImages) {
  const Image<float> source = scene(0, 3);
  const Image<float> target = drawn(width, height, [&](double x, double y) { return source(width - 1 - int(x), int(y)); });
  const ImageFlow flow = image_flow(source, target);
  ASSERT_TRUE(flow.fit);
  EXPECT_LT(flow.fit->alike, 0.35);
  EXPECT_GT(flow.fit->bend, 0.3);
  EXPECT_TRUE(flow.fit->unrelated);
  const Image<float> between = interpolated(flow, source, target, 0.5);
  for (std::size_t i = 0; i < between.values().size(); i += 31)
    EXPECT_NEAR(between.values()[i], 0.5 * (source.values()[i] + target.values()[i]), 1e-5);
}

/// A ball that turns: hardly by 4 degrees, and by 50, where half of what one sees is hidden in the other.
TEST(ImageFlow, SaysWherePartsMayBeMangled) {
  const Waves paint(12, 60, 7, 80);
  const auto turned = [&](double degrees) {
    const double by = degrees * std::numbers::pi / 180;
    return drawn(width, height, [&](double x, double y) {
      const double u = (x - 100) / 75, v = (y - 80) / 75, depth = 1 - u * u - v * v;
      if (depth <= 0) return 0.0;
      return 2 + paint(90 * (std::atan2(u, std::sqrt(depth)) - by), 90 * std::asin(v));
    });
  };
  const ImageFlow little = image_flow(turned(-2), turned(2)), far = image_flow(turned(-25), turned(25));
  ASSERT_TRUE(little.fit && far.fit);
  EXPECT_FALSE(little.fit->strained || little.fit->unrelated);
  EXPECT_TRUE(far.fit->strained || far.fit->unrelated) << far.fit->alike << ' ' << far.fit->bend;
}

}  // namespace
}  // namespace mq::test
