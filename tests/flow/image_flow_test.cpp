#include "mq/flow/image_flow.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "flow/waves.h"
#include "mq/base/error.h"

namespace mq::test {
namespace {

using Alignment = FlowAlignment;
using Scales = ImageFlowOptions::Scales;

struct Pair {
  Image<float> source, target;
};

/// The signal and the same moved by (u, v).
Pair translated(int size, double u, double v) {
  const Waves waves(8, 192);
  return {drawn(size, size, [&](double x, double y) { return waves(x, y); }),
          drawn(size, size, [&](double x, double y) { return waves(x - u, y - v); })};
}

double error_of(const Pair& pair, const ImageFlowOptions& options, double u, double v, int margin) {
  const ImageFlow flow = image_flow(pair.source, pair.target, options);
  return endpoint_error(forward_displacement(flow), margin, [&](double, double) {
    return std::array{u, v};
  });
}

TEST(ImageFlow, FindsTranslationsOfOneToFortyPixels) {
  for (const double shift : {1.0, 5.0, 20.0}) {
    const Pair pair = translated(256, 0.8 * shift, 0.6 * shift);
    for (const Alignment alignment : {Alignment::halfway, Alignment::forward}) {
      ImageFlowOptions options;
      options.alignment = alignment;
      options.largest = {20, Length::Unit::texels};
      EXPECT_LT(error_of(pair, options, 0.8 * shift, 0.6 * shift, int(shift) + 8), 0.1)
          << shift << ' ' << int(alignment);
    }
  }
  const Pair far = translated(448, 32, -24);
  EXPECT_LT(error_of(far, {}, 32, -24, 48), 0.1);
}

TEST(ImageFlow, NeedsScalesForLargeMotions) {
  const Pair pair = translated(160, 12, 9);
  ImageFlowOptions single;
  single.scales = Scales::single;
  single.steps = 20;
  EXPECT_GT(error_of(pair, single, 12, 9, 24), 2);
  ImageFlowOptions full;
  full.scales = Scales::full;
  EXPECT_LT(error_of(pair, full, 12, 9, 24), 0.1);
  // What moves by less than the signal's waves needs none.
  EXPECT_LT(error_of(translated(160, 0.8, 0.6), single, 0.8, 0.6, 10), 0.1);
}

TEST(ImageFlow, FindsRotationsAndExpansions) {
  const Waves waves(8, 160);
  const double turn = 0.08, growth = 1.05, middle = 100;
  const auto motion = [&](double x, double y) {
    const double a = x - middle, b = y - middle;
    return std::array{growth * (std::cos(turn) * a - std::sin(turn) * b) - a,
                      growth * (std::sin(turn) * a + std::cos(turn) * b) - b};
  };
  // The target at growth·R·a shows what the source shows at a.
  const Image<float> source = drawn(201, 201, [&](double x, double y) { return waves(x, y); });
  const Image<float> target = drawn(201, 201, [&](double x, double y) {
    const double a = (x - middle) / growth, b = (y - middle) / growth;
    return waves(middle + std::cos(turn) * a + std::sin(turn) * b,
                 middle - std::sin(turn) * a + std::cos(turn) * b);
  });
  for (const FlowPath path : {FlowPath::integrated, FlowPath::straight}) {
    ImageFlowOptions options;
    options.path = path;
    const ImageFlow flow = image_flow(source, target, options);
    EXPECT_LT(endpoint_error(forward_displacement(flow), 25, motion), 0.1);
    const AlignedImages met = aligned(flow, source, target);
    double left = 0, before = 0;
    for (int y = 20; y < 181; ++y)
      for (int x = 20; x < 181; ++x) {
        left += std::pow(met.target(x, y) - met.source(x, y), 2);
        before += std::pow(target(x, y) - source(x, y), 2);
      }
    EXPECT_LT(left, 1e-3 * before);
  }
}

TEST(ImageFlow, IsTheOppositeForSwappedImagesBitForBit) {
  const Pair pair = translated(90, 3, -2);
  for (const double robust : {0.0, 0.5}) {
    ImageFlowOptions options;
    options.robust_data = robust;
    options.robust_smoothness = robust;
    const ImageFlow there = image_flow(pair.source, pair.target, options);
    ImageFlow back = image_flow(pair.target, pair.source, options);
    for (float& value : back.field.values()) value = -value;
    EXPECT_EQ(back.field, there.field);
    EXPECT_EQ(back.error, there.error);
    EXPECT_GT(*std::ranges::max_element(there.field.values()), 2);
  }
}

TEST(ImageFlow, DoesNotDependOnTheRangeOfValues) {
  const Pair pair = translated(80, 2, 1);
  const auto whole = [](const Image<float>& image, float factor) {
    Image<float> result = image;
    for (float& value : result.values()) value = factor * std::round(60 * value);
    return result;
  };
  const ImageFlow one = image_flow(whole(pair.source, 1), whole(pair.target, 1));
  const ImageFlow three = image_flow(whole(pair.source, 3), whole(pair.target, 3));
  for (std::size_t i = 0; i < one.field.values().size(); ++i)
    EXPECT_NEAR(three.field.values()[i], one.field.values()[i], 1e-9);
}

TEST(ImageFlow, MeansTheSameAtAnyResolution) {
  const Waves waves(24, 160);
  ImageFlowOptions options;
  options.smallest = {2, Length::Unit::percent};
  std::vector<Image<float>> fields;
  for (const int scale : {1, 2}) {
    const auto at = [&](double x) { return (x + 0.5) / scale - 0.5; };
    const auto moved = [&](double x, double y) {
      return waves(at(x) - 3 - 0.02 * at(y), at(y) + 2);
    };
    const Image<float> source =
        drawn(128 * scale, 128 * scale, [&](double x, double y) { return waves(at(x), at(y)); });
    fields.push_back(image_flow(source, drawn(128 * scale, 128 * scale, moved), options).field);
  }
  const Image<float> half = resized_field(fields[1], 128, 128);
  const double difference = endpoint_error(half, 4, [&](double x, double y) {
    return std::array{double(fields[0](int(x), int(y), 0)), double(fields[0](int(x), int(y), 1))};
  });
  EXPECT_LT(difference, 0.02 * 4.5);  // the motion's mean length
}

TEST(ImageFlow, NeverRisesInErrorAndNeverTakesScalesBelowOne) {
  const Waves one(6, 60, 1), other(6, 60, 2);
  const Pair pair = translated(96, 5, 3);
  const Image<float> unrelated = drawn(96, 96, [&](double x, double y) { return other(x, y); });
  for (const Image<float>* target : {&pair.target, &unrelated})
    for (const double robust : {0.0, 0.3}) {
      ImageFlowOptions options;
      options.robust_data = robust;
      const ImageFlow flow = image_flow(pair.source, *target, options);
      ASSERT_EQ(flow.error.size(), flow.levels.size() + 1);
      for (std::size_t l = 0; l < flow.levels.size(); ++l) {
        EXPECT_LE(flow.error[l + 1], flow.error[l]);
        EXPECT_TRUE(flow.levels[l].cycles == 0 || flow.levels[l].scale >= 1 - 1e-3) << l;
      }
      EXPECT_LT(flow.error.back(), flow.error.front());
    }
}

TEST(ImageFlow, IsRobustAgainstWhatHasNoCounterpart) {
  Pair pair = translated(160, 4, 3);
  const Waves other(8, 40, 9);
  for (int y = 60; y < 100; ++y)
    for (int x = 60; x < 100; ++x) pair.target(x, y) = float(2 * other(x, y));
  const auto truth = [](double, double) { return std::array{4.0, 3.0}; };
  const auto around = [&](const ImageFlowOptions& options) {
    const Image<float> u = forward_displacement(image_flow(pair.source, pair.target, options));
    double sum = 0;
    int count = 0;
    for (int y = 20; y < 140; ++y)
      for (int x = 20; x < 140; ++x)
        if (x < 45 || y < 45 || x > 115 || y > 115) {
          const auto [a, b] = truth(x, y);
          sum += std::hypot(u(x, y, 0) - a, u(x, y, 1) - b);
          ++count;
        }
    return sum / count;
  };
  ImageFlowOptions robust;
  robust.robust_data = 0.05;
  robust.robust_smoothness = 0.1;
  EXPECT_LT(around(robust), 0.6 * around({}));
}

TEST(ImageFlow, SeesThroughChangesOfLight) {
  Pair pair = translated(160, 3, -2);
  for (int y = 0; y < 160; ++y)
    for (int x = 0; x < 160; ++x) pair.target(x, y) += float(0.8 * std::sin(0.03 * x + 0.02 * y));
  const double plain = error_of(pair, {}, 3, -2, 16);
  ImageFlowOptions without_light, by_slopes;
  without_light.detail = {8, Length::Unit::texels};
  by_slopes.gradient_weight = 5;
  EXPECT_LT(error_of(pair, without_light, 3, -2, 16), 0.5 * plain);
  EXPECT_LT(error_of(pair, by_slopes, 3, -2, 16), 0.5 * plain);
}

TEST(ImageFlow, SeesThroughAnotherExposureWhenAsked) {
  Pair pair = translated(160, 6, -3);
  ImageFlowOptions matched;
  matched.light = ImageLight::matched;
  const ImageFlow same = image_flow(pair.source, pair.target, matched);
  for (float& value : pair.target.values()) value = 0.6F * value + 0.2F;
  ImageFlowOptions kept;
  kept.light = ImageLight::kept;
  const double plain = error_of(pair, kept, 6, -3, 16);
  EXPECT_LT(error_of(pair, matched, 6, -3, 16), 0.3 * plain);
  ImageFlowOptions slopes_too = matched;
  slopes_too.gradient_weight = 5;
  EXPECT_LT(error_of(pair, slopes_too, 6, -3, 16), 0.1 * plain);
  const ImageFlow flow = image_flow(pair.source, pair.target, matched);
  // What exposure was does not matter, and who is first does not either.
  double largest = 0;
  for (std::size_t i = 0; i < flow.field.values().size(); ++i)
    largest = std::max(largest, std::abs(double(flow.field.values()[i]) - same.field.values()[i]));
  EXPECT_LT(largest, 0.01);
  const ImageFlow back = image_flow(pair.target, pair.source, matched);
  for (std::size_t i = 0; i < flow.field.values().size(); ++i)
    ASSERT_EQ(back.field.values()[i], -flow.field.values()[i]);
  // A constant picture has no contrast to match.
  const Image<float> grey(160, 160, 1, 0.5F);
  EXPECT_NO_THROW(image_flow(pair.source, grey, matched));
}

TEST(ImageFlow, HasThePublishedScalesAndOneStepOfEach) {
  const Pair pair = translated(64, 1.5, 1);
  const ImageFlow flow = image_flow(pair.source, pair.target, ImageFlowOptions::thesis());
  ASSERT_EQ(flow.levels.size(), 7U);
  for (const ImageFlowLevel& level : flow.levels) {
    EXPECT_EQ(level.steps, 1);
    EXPECT_EQ(level.width, 64);
  }
  EXPECT_NEAR(flow.levels[0].deviation, std::sqrt(6e-3) * 64, 1e-9);
  EXPECT_NEAR(flow.levels[0].length / flow.levels[6].length, 64, 1e-9);
  EXPECT_LT(flow.error.back(), 0.2 * flow.error.front());
}

TEST(ImageFlow, StaysWhereNothingSaysWhereToGo) {
  const Image<float> grey(30, 20, 3, 0.5F);
  const ImageFlow flow = image_flow(grey, grey);
  EXPECT_EQ(flow.field, Image<float>(30, 20, 2));
  EXPECT_EQ(flow.error.back(), 0);
  const Waves waves(5, 20);
  for (const auto& [width, height] : {std::pair{1, 1}, std::pair{1, 40}, std::pair{40, 2}}) {
    const Image<float> image =
        drawn(width, height, [&](double x, double y) { return waves(x, y); });
    const ImageFlow small = image_flow(image, image);
    EXPECT_EQ(small.field, Image<float>(width, height, 2)) << width << ' ' << height;
  }
}

TEST(ImageFlow, GivesTheSameBitsForAnyNumberOfThreads) {
  const Pair pair = translated(100, 4, 3);
  std::vector<Image<float>> fields;
  for (const std::size_t threads : {1U, 2U, 7U}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    fields.push_back(image_flow(pair.source, pair.target).field);
  }
  EXPECT_EQ(fields[1], fields[0]);
  EXPECT_EQ(fields[2], fields[0]);
}

TEST(ImageFlow, SaysWhatItCannotAlign) {
  const Image<float> a(8, 8, 1), b(9, 8, 1), c(8, 8, 3);
  EXPECT_THROW(image_flow(a, b), InvalidInput);
  EXPECT_THROW(image_flow(a, c), InvalidInput);
  EXPECT_THROW(image_flow({}, {}), InvalidInput);
  Image<float> bad = a;
  bad(3, 3) = std::numeric_limits<float>::infinity();
  EXPECT_THROW(image_flow(a, bad), InvalidInput);
  ImageFlowOptions options;
  options.smallest = {0, Length::Unit::texels};
  EXPECT_THROW(image_flow(a, a, options), InvalidInput);
}

TEST(ImageInterpolation, MovesWhatLiesBetween) {
  const Waves waves(8, 192);
  const Pair pair = translated(200, 8, -6);
  const ImageFlow flow = image_flow(pair.source, pair.target);
  EXPECT_EQ(interpolated(flow, pair.source, pair.target, 0), pair.source);
  EXPECT_EQ(interpolated(flow, pair.source, pair.target, 1), pair.target);
  for (const double t : {0.25, 0.5}) {
    const Image<float> between = interpolated(flow, pair.source, pair.target, t);
    double with_flow = 0, blend = 0;
    for (int y = 20; y < 180; ++y)
      for (int x = 20; x < 180; ++x) {
        const double truth = waves(x - 8 * t, y + 6 * t);
        with_flow += std::pow(between(x, y) - truth, 2);
        blend += std::pow((1 - t) * pair.source(x, y) + t * pair.target(x, y) - truth, 2);
      }
    EXPECT_LT(with_flow, 1e-3 * blend) << t;
  }
  EXPECT_THROW(interpolated(flow, pair.source, pair.target, 1.5), InvalidInput);
}

TEST(ImageInterpolation, ShowsFromOneImageWhatTheOtherHasNot) {
  // All moves to the right: what enters at the left border is in the target alone.
  const Pair pair = translated(200, 10, 0);
  const Waves waves(8, 192);
  const ImageFlow flow = image_flow(pair.source, pair.target);
  const Image<float> between = interpolated(flow, pair.source, pair.target, 0.5);
  double sum = 0;
  for (int y = 20; y < 180; ++y) sum += std::abs(between(2, y) - waves(2 - 5.0, y));
  EXPECT_LT(sum / 160, 0.05);
}

}  // namespace
}  // namespace mq::test
