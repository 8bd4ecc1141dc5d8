#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "flow/waves.h"
#include "mq/base/random.h"
#include "mq/flow/image_flow.h"

namespace mq::test {
namespace {

/// A ground that moves far and a square thing on it that moves a little, at time t; seen in the middle of the way.
struct Layers {
  double ground = -60, thing = 6;  ///< how far they move to the right, pixels
  int width = 260, height = 180;
  double left = 100, top = 50, side = 70;  ///< of the thing halfway

  Image<float> at(double t) const {
    const Waves far(6, 60, 1, 60), near(6, 60, 2, 60);
    const double way = (t - 0.5) * thing;
    return drawn(width, height, [&](double x, double y) {
      return on_thing(x - way, y) ? near(x - way, y) + 0.5 : far(x - (t - 0.5) * ground, y);
    });
  }
  bool on_thing(double x, double y, double margin = 0) const {
    return x > left + margin && x < left + side - margin && y > top + margin && y < top + side - margin;
  }
};

/// The mean distance to (u, 0) over the pixels that are asked for.
double error_where(const Image<float>& field, double u, const std::function<bool(int, int)>& wanted) {
  double sum = 0;
  int count = 0;
  for (int y = 8; y < field.height() - 8; ++y)
    for (int x = 8; x < field.width() - 8; ++x)
      if (wanted(x, y)) sum += std::hypot(field(x, y, 0) - u, field(x, y, 1)), ++count;
  return sum / count;
}

double squared_difference(const Image<float>& a, const Image<float>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.values().size(); ++i) sum += std::pow(a.values()[i] - b.values()[i], 2);
  return sum / double(a.values().size());
}

ImageFlow without_search(const Image<float>& source, const Image<float>& target) {
  ImageFlowOptions options;
  options.search = FlowSearch::none;
  return image_flow(source, target, options);
}

TEST(TornFlow, FindsAThingOfSixPixelsOnAGroundOfSixty) {
  const Layers layers;
  const ImageFlow flow = image_flow(layers.at(0), layers.at(1));
  ASSERT_TRUE(flow.fit);
  EXPECT_TRUE(flow.fit->torn);
  EXPECT_LT(flow.fit->unfit, 0.05);
  EXPECT_LT(error_where(flow.field, 6, [&](int x, int y) { return layers.on_thing(x, y, 6); }), 0.5);
  // Beside the thing the ground is seen in one image alone.
  const auto clear = [&](int x, int y) {
    return x > 35 && x < layers.width - 35 && (y < layers.top - 8 || y > layers.top + layers.side + 8);
  };
  EXPECT_LT(error_where(flow.field, -60, clear), 0.5);
  EXPECT_EQ(flow.error.size(), flow.levels.size() + 1);
  EXPECT_TRUE(std::ranges::is_sorted(flow.error, std::greater()));
}

TEST(TornFlow, ShowsWhatIsHiddenInOneImageFromTheOther) {
  const Layers layers;
  const Image<float> source = layers.at(0), target = layers.at(1);
  const ImageFlow torn = image_flow(source, target), smooth = without_search(source, target);
  for (const double t : {0.25, 0.5, 0.75}) {
    const Image<float> truth = layers.at(t);
    EXPECT_LT(squared_difference(interpolated(torn, source, target, t), truth),
              0.3 * squared_difference(interpolated(smooth, source, target, t), truth))
        << t;
  }
  EXPECT_TRUE(interpolated(torn, source, target, 0) == source);
  EXPECT_TRUE(interpolated(torn, source, target, 1) == target);
}

TEST(TornFlow, SaysWhereTheSourcesPixelsGo) {
  const Layers layers;
  const Image<float> u = forward_displacement(image_flow(layers.at(0), layers.at(1)));
  EXPECT_LT(error_where(u, 6, [&](int x, int y) { return layers.on_thing(x + 3, y, 8); }), 0.5);
  const auto clear = [&](int x, int y) { return x > 70 && (y < layers.top - 8 || y > layers.top + layers.side + 8); };
  EXPECT_LT(error_where(u, -60, clear), 0.5);
}

TEST(TornFlow, IsTheOppositeForSwappedImagesBitForBit) {
  const Layers layers;
  const ImageFlow there = image_flow(layers.at(0), layers.at(1));
  ImageFlow back = image_flow(layers.at(1), layers.at(0));
  EXPECT_TRUE(there.fit->torn);
  for (float& value : back.field.values()) value = -value;
  EXPECT_TRUE(back.field == there.field);
  EXPECT_EQ(back.error, there.error);
}

TEST(TornFlow, DependsNeitherOnThreadsNorOnTheRangeOfValues) {
  const Layers layers;
  Image<float> source = layers.at(0), target = layers.at(1);
  std::vector<Image<float>> fields;
  for (const std::size_t threads : {1U, 2U, 7U}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    fields.push_back(image_flow(source, target).field);
  }
  EXPECT_TRUE(fields[1] == fields[0]);
  EXPECT_TRUE(fields[2] == fields[0]);
  for (Image<float>* image : {&source, &target})
    for (float& value : image->values()) value *= 4;
  EXPECT_TRUE(image_flow(source, target).field == fields[0]);
}

TEST(TornFlow, LeavesRepetitionAsTheWayFromLargeScalesHasIt) {
  // Bricks that move by a period and a half fit half a period the other way as well.
  const auto bricks = [](double x, double y) {
    const double row = std::floor(y / 16), column = x / 32 + 0.5 * std::fmod(row, 2);
    return std::tanh(6 * std::cos(2 * std::numbers::pi * column)) + 0.3 * std::cos(2 * std::numbers::pi * y / 16);
  };
  const Image<float> source = drawn(256, 160, bricks);
  const Image<float> target = drawn(256, 160, [&](double x, double y) { return bricks(x - 48, y); });
  const ImageFlow flow = image_flow(source, target), before = without_search(source, target);
  EXPECT_LE(flow.error.back(), before.error.back());
  const Image<float> truth = drawn(256, 160, [&](double x, double y) { return bricks(x - 24, y); });
  const Image<float> other = drawn(256, 160, [&](double x, double y) { return bricks(x - 8, y); });
  const auto off = [&](const ImageFlow& found) {
    const Image<float> between = interpolated(found, source, target, 0.5);
    return std::min(squared_difference(between, truth), squared_difference(between, other));
  };
  EXPECT_LE(off(flow), 1.02 * off(before));
}

TEST(TornFlow, BlendsWhereNothingFits) {
  const Waves waves(8, 192, 3, 60), other(4, 12, 9, 60);
  const Image<float> source = drawn(160, 160, [&](double x, double y) { return waves(x, y); });
  const Image<float> target = drawn(160, 160, [&](double x, double y) {
    return std::max(std::abs(x - 85), std::abs(y - 85)) < 25 ? 3 * other(x, y) : waves(x - 4, y + 3);
  });
  const ImageFlow flow = image_flow(source, target);
  EXPECT_GT(flow.fit->unfit, 0.02);
  EXPECT_LT(flow.fit->unfit, 0.2);
  const Image<float> between = interpolated(flow, source, target, 0.5);
  double largest = 0;
  for (int y = 75; y < 95; ++y)
    for (int x = 125; x < 145; ++x)
      largest = std::max(largest, std::abs(double(between(x, y)) - 0.5 * (source(x, y) + target(x, y))));
  EXPECT_LT(largest, 0.5);
}

TEST(TornFlow, BlendsImagesOfDifferentThings) {
  // Waves, and boxes of other values: whatever is laid over them, they are not alike.
  const Waves waves(8, 60, 3, 60), other(3, 9, 9, 60);
  const Image<float> source = drawn(160, 160, [&](double x, double y) { return waves(x, y); });
  const Image<float> target = drawn(160, 160, [&](double x, double y) { return std::tanh(4 * other(x, y)); });
  const ImageFlow flow = image_flow(source, target);
  ASSERT_TRUE(flow.fit);
  EXPECT_TRUE(flow.fit->unrelated);
  const Image<float> between = interpolated(flow, source, target, 0.25);
  for (std::size_t i = 0; i < between.values().size(); ++i)
    ASSERT_NEAR(between.values()[i], 0.75 * source.values()[i] + 0.25 * target.values()[i], 1e-5) << i;
  // Under noise a motion is one all the same.
  const Random random(4);
  const auto noisy = [&](double way, std::uint64_t seed) {
    std::uint64_t k = seed << 32;
    return drawn(160, 160, [&](double x, double y) { return waves(x - way, y) + 1.5 * (random.uniform(k++) - 0.5); });
  };
  const ImageFlow related = image_flow(noisy(0, 1), noisy(5, 2));
  EXPECT_TRUE(!related.fit || !related.fit->unrelated);
  EXPECT_FALSE(image_flow(Layers().at(0), Layers().at(1)).fit->unrelated);
}

/// Another exposure is seen by itself: what it is changes nothing then, and what lies between has the light of both.
TEST(TornFlow, MatchesLightWhereItIsAnother) {
  const Waves waves(5, 40, 3, 60);
  const auto at = [&](double way, double contrast, double offset) {
    return drawn(160, 120, [&](double x, double y) { return contrast * waves(x - way, y) + offset; });
  };
  const Image<float> source = at(0, 1, 0), target = at(6, 0.4, 2);
  const ImageFlow flow = image_flow(source, target);
  ASSERT_TRUE(flow.fit);
  EXPECT_EQ(flow.fit->light, ImageLight::matched);
  EXPECT_FALSE(flow.fit->unrelated);
  EXPECT_LT(error_where(flow.field, 6, [](int x, int y) { return x > 16 && x < 144 && y > 16 && y < 104; }), 0.2);
  const Image<float> between = interpolated(flow, source, target, 0.5), truth = at(3, 0.7, 1);
  double sum = 0, blend = 0;
  for (int y = 16; y < 104; ++y)
    for (int x = 16; x < 144; ++x) {
      sum += std::pow(between(x, y) - truth(x, y), 2);
      blend += std::pow(0.5 * (source(x, y) + target(x, y)) - truth(x, y), 2);
    }
  EXPECT_LT(sum, 0.05 * blend);
  // In one light nothing is matched, nor where that is asked for.
  EXPECT_EQ(image_flow(source, at(6, 1, 0)).fit->light, ImageLight::kept);
  ImageFlowOptions kept;
  kept.light = ImageLight::kept;
  EXPECT_EQ(image_flow(source, target, kept).fit->light, ImageLight::kept);
}

TEST(TornFlow, SearchesOnlyWhereAskedAndWhereSomethingIsLeft) {
  const Layers layers;
  const Image<float> source = layers.at(0), target = layers.at(1);
  EXPECT_FALSE(without_search(source, target).fit);
  EXPECT_FALSE(image_flow(source, target, ImageFlowOptions::thesis()).fit);
  ImageFlowOptions forward;
  forward.alignment = FlowAlignment::forward;
  EXPECT_FALSE(image_flow(source, target, forward).fit);
  const Waves waves(8, 192);
  const Image<float> one = drawn(128, 128, [&](double x, double y) { return waves(x, y); });
  const Image<float> moved = drawn(128, 128, [&](double x, double y) { return waves(x - 4, y + 3); });
  const ImageFlow easy = image_flow(one, moved);
  EXPECT_FALSE(easy.fit->torn);
  EXPECT_TRUE(easy.field == without_search(one, moved).field);
}

}  // namespace
}  // namespace mq::test
