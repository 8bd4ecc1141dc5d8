#include "mq/baseline/osher_rudin.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "filter/shock_images.h"
#include "fixtures.h"
#include "mq/image/gaussian.h"

namespace mq {
namespace {

using fixtures::noisy;
using fixtures::shapes;

std::vector<double> wavy_signal(int count) {
  std::vector<double> signal;
  const Random random(9);
  for (int i = 0; i < count; ++i)
    signal.push_back(std::sin(0.13 * i) + 0.3 * std::sin(0.41 * i) +
                     0.02 * random.uniform(std::uint64_t(i)));
  return signal;
}

double total_variation(const std::vector<double>& v) {
  double sum = 0;
  for (std::size_t i = 1; i < v.size(); ++i) sum += std::abs(v[i] - v[i - 1]);
  return sum;
}

TEST(OsherRudin, KeepsExtremaMonotonicityAndTotalVariationOfALine) {
  const std::vector<double> signal = wavy_signal(400);
  for (const double time : {0.5, 5.0, 500.0}) {
    const Evolved evolved = osher_rudin(signal, time);
    const std::vector<double>& after = evolved.values;
    EXPECT_GT(evolved.steps, 0);
    // Total variation is the sum of jumps between extrema: it is kept to rounding.
    EXPECT_NEAR(total_variation(after), total_variation(signal), 1e-9 * total_variation(signal));
    for (std::size_t i = 1; i + 1 < signal.size(); ++i) {
      const double back = signal[i] - signal[i - 1], ahead = signal[i + 1] - signal[i];
      if (back * ahead <= 0) {
        EXPECT_EQ(after[i], signal[i]);
      }
      EXPECT_GE((after[i] - after[i - 1]) * back, -1e-15);
    }
  }
  const Evolved sharp = osher_rudin(signal, 500);
  double steepest = 0, before = 0;
  for (std::size_t i = 1; i < signal.size(); ++i) {
    steepest = std::max(steepest, std::abs(sharp.values[i] - sharp.values[i - 1]));
    before = std::max(before, std::abs(signal[i] - signal[i - 1]));
  }
  EXPECT_GT(steepest, 2 * before);
}

TEST(OsherRudin, HoldsExtremaOfAnImageAndMakesNoNewValues) {
  for (const Concavity concavity : {Concavity::laplacian, Concavity::along_gradient}) {
    Image<float> image = noisy(shapes(64, 48, 1), 0.02);
    const auto range = std::ranges::minmax(image.values());
    for (int step = 0; step < 50; ++step) {
      const Image<float> after =
          osher_rudin(image, {.time = 1e9, .concavity = concavity, .most_steps = 1}).image;
      int extrema = 0;
      for (int y = 1; y + 1 < 48; ++y)
        for (int x = 1; x + 1 < 64; ++x) {
          const float v = image(x, y);
          const auto [low, high] =
              std::minmax({image(x - 1, y), image(x + 1, y), image(x, y - 1), image(x, y + 1)});
          if (v <= low || v >= high) {
            ++extrema;
            EXPECT_EQ(after(x, y), v);
          }
          EXPECT_GE(after(x, y), std::min(low, v));
          EXPECT_LE(after(x, y), std::max(high, v));
        }
      EXPECT_GT(extrema, 10);
      image = after;
    }
    EXPECT_GT(osher_rudin(image, {.time = 1e9, .concavity = concavity, .most_steps = 1}).left, 0);
    // So the largest and the smallest value stay where they are for ever.
    EXPECT_EQ(std::ranges::minmax(image.values()).min, range.min);
    EXPECT_EQ(std::ranges::minmax(image.values()).max, range.max);
  }
}

TEST(OsherRudin, KeepsExtremaOfNoiseForEver) {
  const Image<float> image = fixtures::noise(40, 31, 2);
  for (const Concavity concavity : {Concavity::laplacian, Concavity::along_gradient})
    for (const double time : {1.0, 100.0}) {
      const EvolvedImage evolved = osher_rudin(image, {.time = time, .concavity = concavity});
      EXPECT_NE(evolved.image, image);
      int extrema = 0;
      for (int y = 1; y < 30; ++y)
        for (int x = 1; x < 39; ++x)
          for (int c = 0; c < 2; ++c) {
            const float v = image(x, y, c);
            const auto [low, high] = std::minmax(
                {image(x - 1, y, c), image(x + 1, y, c), image(x, y - 1, c), image(x, y + 1, c)});
            if (v > low && v < high) continue;
            ++extrema;
            EXPECT_EQ(evolved.image(x, y, c), v);
            // And no neighbour has passed it.
            const auto [least, most] =
                std::minmax({evolved.image(x - 1, y, c), evolved.image(x + 1, y, c),
                             evolved.image(x, y - 1, c), evolved.image(x, y + 1, c)});
            EXPECT_TRUE(v <= least || v >= most);
          }
      EXPECT_GT(extrema, 500);
    }
}

TEST(OsherRudin, SaysBeforehandHowManyStepsItTakes) {
  // Steep from the start, and blurred so that steps become shorter twenty times over.
  const Image<float> steep = noisy(shapes(64, 48, 2), 0.02);
  for (const Image<float>& image : {steep, smoothed(steep, 9.0)})
    for (const Concavity concavity : {Concavity::laplacian, Concavity::along_gradient})
      for (const double time : {0.5, 20.0, 500.0}) {
        const OsherRudinOptions options{.time = time, .concavity = concavity};
        const double expected = osher_rudin_steps(image, options);
        const int steps = osher_rudin(image, options).steps;
        EXPECT_GT(steps, 0.4 * expected - 10) << time;
        EXPECT_LT(steps, 2.5 * expected + 10) << time;
      }
  EXPECT_EQ(osher_rudin_steps(Image<float>(4, 4, 1, 0.5F), {.time = 10}), 0);
}

TEST(OsherRudin, EndsWhereNothingChangesAnyMore) {
  Image<float> edge(40, 6, 1);
  for (int y = 0; y < 6; ++y)
    for (int x = 0; x < 40; ++x) edge(x, y) = float(0.5 + 0.4 * std::tanh((x - 19.3) / 4));
  const EvolvedImage rested = osher_rudin(edge, {.time = 1e9, .least_change = 0.5 / 255});
  EXPECT_EQ(rested.left, 0);
  EXPECT_LT(rested.steps, 20'000);
  // Four times as many steps hardly change it.
  const EvolvedImage longer =
      osher_rudin(edge, {.time = 1e9, .most_steps = 4 * rested.steps, .least_change = 0});
  for (int y = 0; y < 6; ++y)
    for (int x = 0; x < 40; ++x) EXPECT_NEAR(longer.image(x, y), rested.image(x, y), 1.0 / 255);
}

TEST(OsherRudin, IsOneDimensionalOnRows) {
  const std::vector<double> line = wavy_signal(64);
  Image<float> image(64, 5, 1);
  std::vector<double> as_float;
  for (int x = 0; x < 64; ++x) {
    as_float.push_back(float(line[std::size_t(x)]));
    for (int y = 0; y < 5; ++y) image(x, y) = float(line[std::size_t(x)]);
  }
  // The steps differ (CFL of 1/4 and 1/2): the same evolution to first order in the step.
  const Image<float> after = osher_rudin(image, {.time = 0.2}).image;
  const std::vector<double> expected = osher_rudin(as_float, 0.2).values;
  for (int x = 0; x < 64; ++x) EXPECT_NEAR(after(x, 2), expected[std::size_t(x)], 2e-3);
}

/// A maximum on a low ridge along x that falls slowly, beside a pixel whose column is steep: |∇φ| there is that of the
/// column, and the pixel rises past the maximum.
Image<float> maximum_beside_a_slope() {
  Image<float> image(5, 5, 1, 0.0F);
  for (int y = 0; y < 5; ++y) image(3, y) = float(0.3 * y);
  image(2, 2) = 0.605F;  // all around are lower: 0.6 on its right
  return image;
}

TEST(OsherRudin, AsPrintedLetsAPixelPassAMaximumWhichTheBoundedOneForbids) {
  const Image<float> image = maximum_beside_a_slope();
  const auto after = [&](OsherRudinOptions::Scheme scheme) {
    return osher_rudin(image, {.scheme = scheme, .time = 1, .most_steps = 1}).image;
  };
  const Image<float> bounded = after(OsherRudinOptions::Scheme::bounded),
                     printed = after(OsherRudinOptions::Scheme::as_printed);
  EXPECT_EQ(bounded(2, 2), 0.605F);
  EXPECT_LE(bounded(3, 2), 0.605F);
  EXPECT_EQ(printed(2, 2), 0.605F);
  EXPECT_GT(printed(3, 2), 0.605F);
  EXPECT_EQ(passed_extrema(image, bounded).passed, 0);
  EXPECT_EQ(passed_extrema(image, bounded).furthest, 0);
  const PassedExtrema passed = passed_extrema(image, printed);
  EXPECT_EQ(passed.passed, 1);
  EXPECT_EQ(passed.extrema, passed_extrema(image, bounded).extrema);
  EXPECT_FLOAT_EQ(float(passed.furthest), printed(3, 2) - 0.605F);
}

/// On rows there is no slope at right angles, so that nothing passes.
TEST(OsherRudin, IsTheSameWithAndWithoutBoundsWhereNothingPasses) {
  const std::vector<double> line = wavy_signal(64);
  Image<float> image(64, 3, 1);
  for (int x = 0; x < 64; ++x)
    for (int y = 0; y < 3; ++y) image(x, y) = float(line[std::size_t(x)]);
  const auto after = [&](OsherRudinOptions::Scheme scheme) {
    return osher_rudin(image, {.scheme = scheme, .time = 2}).image;
  };
  const Image<float> bounded = after(OsherRudinOptions::Scheme::bounded),
                     printed = after(OsherRudinOptions::Scheme::as_printed);
  EXPECT_NE(bounded, image);
  // Steps differ, as |L| counts at extrema too.
  for (int x = 0; x < 64; ++x) EXPECT_NEAR(printed(x, 1), bounded(x, 1), 5e-3);
  for (const Image<float>* image_after : {&bounded, &printed}) {
    const PassedExtrema passed = passed_extrema(image, *image_after);
    EXPECT_GT(passed.extrema, 4);
    EXPECT_EQ(passed.passed, 0);
  }
}

/// A step moves a pixel by less than the way to the farthest of its neighbours, also as printed.
TEST(OsherRudin, PassesExtremaOfNoiseAsPrintedAndKeepsTheRange) {
  const Image<float> image = fixtures::noise(40, 31, 2);
  const auto range = std::ranges::minmax(image.values());
  for (const Concavity concavity : {Concavity::laplacian, Concavity::along_gradient}) {
    const auto after = [&](OsherRudinOptions::Scheme scheme) {
      return osher_rudin(image, {.scheme = scheme, .time = 2, .concavity = concavity}).image;
    };
    const Image<float> bounded = after(OsherRudinOptions::Scheme::bounded),
                       printed = after(OsherRudinOptions::Scheme::as_printed);
    EXPECT_GT(passed_extrema(image, bounded).extrema, 500);
    EXPECT_EQ(passed_extrema(image, bounded).passed, 0);
    EXPECT_GT(passed_extrema(image, printed).passed, 50);
    EXPECT_GT(passed_extrema(image, printed).furthest, 0.05);
    const auto now = std::ranges::minmax(printed.values());
    EXPECT_GE(now.min, range.min);
    EXPECT_LE(now.max, range.max);
  }
}

TEST(OsherRudin, RefusesANegativeTime) {
  EXPECT_THROW(osher_rudin(Image<float>(4, 4, 1), OsherRudinOptions{.time = -1}), InvalidInput);
}

}  // namespace
}  // namespace mq
