#include "mq/filter/image_shock.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "filter/shock_images.h"
#include "fixtures.h"
#include "mq/image/gaussian.h"

namespace mq {
namespace {

using fixtures::noisy;
using fixtures::shapes;
using Method = ImageShockOptions::Method;

constexpr double for_ever = 1e6;

/// A step from 0 to 1 across a straight line at some angle, blurred.
Image<float> blurred_edge(int size, double angle) {
  Image<float> image(size, size, 1);
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const double d = (x - 0.5 * size) * std::cos(angle) + (y - 0.5 * size) * std::sin(angle);
      image(x, y) = float(0.5 + 0.5 * std::tanh(d / 5));
    }
  return image;
}

int between(const Image<float>& image, float low, float high) {
  int count = 0;
  for (int y = 12; y < image.height() - 12; ++y)
    for (int x = 12; x < image.width() - 12; ++x) count += image(x, y) > low && image(x, y) < high;
  return count;
}

TEST(SmoothedImage, IsASemigroupAndEndsInTheMean) {
  Image<float> image(24, 17, 1);
  const Random random(3);
  double mean = 0;
  for (std::size_t i = 0; i < image.values().size(); ++i)
    mean += image.values()[i] = float(random.uniform(i));
  mean /= double(image.values().size());
  // Deviations of 2 and 3, then 20 and 24 pixels, which reach over several mirror images.
  for (const auto& [a, b] : {std::pair(2.0, 4.5), std::pair(200.0, 300.0)}) {
    const Image<float> twice = smoothed(smoothed(image, a), b), once = smoothed(image, a + b);
    for (std::size_t i = 0; i < once.values().size(); ++i)
      EXPECT_NEAR(twice.values()[i], once.values()[i], 1e-4);
  }
  for (const double weight : {1e5, 1e18, 1e300}) {
    const Image<float> flat = smoothed(image, weight);
    for (const float value : flat.values()) EXPECT_NEAR(value, mean, 1e-6) << weight;
  }
}

TEST(ImageShock, NeverLeavesTheRangeOfAnyChannel) {
  const Image<float> image = noisy(shapes(70, 41, 4), 0.1);
  for (const Method method : {Method::transport, Method::composed, Method::iterated})
    for (const Concavity concavity : {Concavity::along_gradient, Concavity::laplacian})
      for (const double tau : {0.5, 10.0, for_ever}) {
        const ShockedImage shocked = shock(image, {.method = method,
                                                   .concavity = concavity,
                                                   .weights = {0.5, 0.5},
                                                   .time = {ShockTime::Unit::relative, tau},
                                                   .steps = 4});
        EXPECT_EQ(shocked.counts.cut_short, 0);
        EXPECT_LT(shocked.counts.triangles, 50 * shocked.counts.paths);
        for (int c = 0; c < 4; ++c) {
          float low = 2, high = -2, low_after = 2, high_after = -2;
          for (int y = 0; y < 41; ++y)
            for (int x = 0; x < 70; ++x) {
              low = std::min(low, image(x, y, c));
              high = std::max(high, image(x, y, c));
              low_after = std::min(low_after, shocked.image(x, y, c));
              high_after = std::max(high_after, shocked.image(x, y, c));
            }
          EXPECT_GE(low_after, low);
          EXPECT_LE(high_after, high);
        }
      }
}

TEST(ImageShock, LeavesEdgesWhereTheyAreInAnyNumberOfStepsByTheLaplacian) {
  // The Laplacian is 0 outside curved edges: fields that were smoothed anew would let them grow.
  Image<float> image(72, 72, 2, 0.1F);
  for (int y = 0; y < 72; ++y)
    for (int x = 0; x < 72; ++x)
      for (const auto& [i, j, r] :
           {std::array{20, 20, 11}, std::array{50, 22, 6}, std::array{36, 54, 8}})
        image(x, y, 0) += 0.8F / (1 + std::exp(2 * float(std::hypot(x - i, y - j) - r)));
  const auto bright = [](const Image<float>& of) {
    int count = 0;
    for (int y = 0; y < 72; ++y)
      for (int x = 0; x < 72; ++x) count += of(x, y, 0) > 0.5F;
    return count;
  };
  const Image<float> speckled = noisy(image, 0.1);
  for (const Method method : {Method::composed, Method::iterated})
    for (const double tau : {2.0, 12.0, for_ever})
      for (const int steps : {1, 8, 32}) {
        const ImageShockOptions options{.method = method,
                                        .concavity = Concavity::laplacian,
                                        .weights = {0.6, 0.6},
                                        .time = {ShockTime::Unit::relative, tau},
                                        .steps = steps};
        const ShockedImage sharp = shock(image, options), rough = shock(speckled, options);
        EXPECT_NEAR(bright(sharp.image), bright(image), 0.12 * bright(image))
            << tau << " " << steps;
        ImageShockOptions at_once = options;
        at_once.steps = 1;
        EXPECT_NEAR(bright(sharp.image), bright(shock(image, at_once).image), 0.05 * bright(image))
            << tau << " " << steps;
        for (const ShockedImage& one : {sharp, rough}) {
          EXPECT_EQ(one.counts.cut_short, 0);
          EXPECT_LT(one.counts.triangles, 12 * one.counts.paths);
        }
      }
}

TEST(ImageShock, SharpensEdgesAlikeInAllDirections) {
  int widths[7], before[7];
  for (int i = 0; i < 7; ++i) {
    const Image<float> edge = blurred_edge(96, i * std::numbers::pi / 12);
    before[i] = between(edge, 0.1F, 0.9F);
    widths[i] = between(
        shock(edge, {.weights = {1, 1}, .time = {ShockTime::Unit::relative, 3}}).image, 0.1F, 0.9F);
  }
  // Pixels per length of edge: the square is crossed by edges of length up to 72·√2.
  for (int i = 0; i < 7; ++i) EXPECT_LT(widths[i], 0.3 * before[i]) << i;
}

TEST(ImageShock, IsTheSameForAllMethodsInOneStep) {
  const Image<float> image = noisy(shapes(40, 40, 3), 0.05);
  ImageShockOptions options{.weights = {1, 1}, .time = {ShockTime::Unit::relative, 2}};
  const Image<float> expected = shock(image, options).image;
  EXPECT_NE(expected, image);
  for (const Method method : {Method::composed, Method::iterated}) {
    options.method = method;
    EXPECT_EQ(shock(image, options).image, expected);
  }
}

TEST(ImageShock, ComposesTheFlowOfAFixedFieldExactly) {
  // Values that a linear signal has are places: composed steps end where one long step ends.
  const Image<float> image = shapes(50, 40);
  const std::vector<double> P = shock_potential(image, {2, 2});
  const GridFlow flow = GridFlow::downhill(50, 40, P);
  const double time = 2 / potential_rate(50, 40, P);
  const Traced whole = flow.trace_pixels(time);
  std::vector<SurfacePoint> ends = flow.trace_pixels(time / 8).ends;
  for (int k = 1; k < 8; ++k) ends = flow.trace(ends, time / 8).ends;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const auto a = flow.place(whole.ends[i]), b = flow.place(ends[i]);
    EXPECT_NEAR(a[0], b[0], 1e-9);
    EXPECT_NEAR(a[1], b[1], 1e-9);
  }
}

TEST(ImageShock, BlursLessWhenFlowsAreComposedThanWhenImagesAreSampledAgain) {
  // Figure 3.3: thin lines that sampling again and again would lose.
  Image<float> image(96, 96, 1, 0.2F);
  for (int y = 0; y < 96; ++y)
    for (int x = 0; x < 96; ++x)
      for (const int line : {20, 41, 62, 80})
        image(x, y) += 0.6F * float(std::exp(-0.5 * std::pow((x + 0.3 * y - line - 10) / 1.2, 2)));
  ImageShockOptions options{
      .weights = {0.3, 0.3}, .time = {ShockTime::Unit::relative, 6}, .steps = 40};
  const auto contrast = [&](Method method) {
    options.method = method;
    const ShockedImage shocked = shock(image, options);
    double sum = 0;
    for (const float v : shocked.image.values()) sum += std::abs(v - 0.2);
    return sum;
  };
  double before = 0;
  for (const float v : image.values()) before += std::abs(v - 0.2);
  const double composed = contrast(Method::composed), iterated = contrast(Method::iterated),
               transported = contrast(Method::transport);
  EXPECT_GT(composed, 1.05 * iterated);
  EXPECT_NEAR(transported, composed, 0.25 * before);
}

TEST(ImageShock, KeepsAMonotoneRampMonotoneAndAConstantAsItIs) {
  Image<float> ramp(80, 6, 1);
  for (int y = 0; y < 6; ++y)
    for (int x = 0; x < 80; ++x) ramp(x, y) = float(0.5 + 0.5 * std::tanh((x - 37.3) / 9));
  for (const double tau : {0.3, 1.0, 10.0, for_ever}) {
    const Image<float> after =
        shock(ramp, {.weights = {}, .time = {ShockTime::Unit::relative, tau}}).image;
    for (int y = 0; y < 6; ++y)
      for (int x = 1; x < 80; ++x) EXPECT_GE(after(x, y), after(x - 1, y) - 1e-7F);
  }
  const Image<float> constant(17, 9, 3, 0.3F);
  EXPECT_EQ(
      shock(constant, {.weights = {1, 1}, .time = {ShockTime::Unit::absolute, for_ever}}).image,
      constant);
  for (const auto& [w, h] : {std::pair(1, 1), std::pair(1, 9), std::pair(9, 1)}) {
    const Image<float> narrow = fixtures::noise(w, h, 2);
    const Image<float> after =
        shock(narrow, {.weights = {}, .time = {ShockTime::Unit::relative, 1}}).image;
    EXPECT_EQ(after.width(), w);
    EXPECT_EQ(after.height(), h);
  }
}

TEST(ImageShock, DoesNotDependOnTheSizeOfValues) {
  const Image<float> image = shapes(48, 40, 3);
  ImageShockOptions options{.weights = {1, 1}, .time = {ShockTime::Unit::relative, 2}};
  const Image<float> expected = shock(image, options).image;
  Image<float> scaled = image;
  for (float& v : scaled.values()) v *= 256;
  const Image<float> after = shock(scaled, options).image;
  for (std::size_t i = 0; i < expected.values().size(); ++i)
    ASSERT_EQ(after.values()[i], 256 * expected.values()[i]);
}

/// A straight edge that crosses a row every five pixels: of each pixel next to it as much is bright as lies beyond.
TEST(ImageShock, LeavesPixelsOnAnOutlineTheMeanOfBothSides) {
  const double slope = std::atan(0.2);
  const auto beyond = [&](int x, int y) { return (y - 30.3) * std::cos(slope) - (x - 30) * std::sin(slope); };
  Image<float> image(61, 61, 1);
  for (int y = 0; y < 61; ++y)
    for (int x = 0; x < 61; ++x) image(x, y) = float(0.5 + 0.4 * std::tanh(beyond(x, y) / 1.5));
  const Image<float> sharp = shock(image, {.weights = {1, 1}, .time = {ShockTime::Unit::relative, 12}}).image;
  double error = 0;
  int count = 0;
  for (int y = 10; y < 51; ++y)
    for (int x = 10; x < 51; ++x) {
      if (std::abs(beyond(x, y)) > 0.45) continue;
      error += std::abs(sharp(x, y) - (0.5 + 0.8 * beyond(x, y) / std::cos(slope)));
      ++count;
    }
  EXPECT_LT(error / count, 0.17);  // 0.22 where a pixel is of one side or the other
}

TEST(ImageShock, HasTheTimeOfTheMirroredImage) {
  Image<float> image(31, 25, 1), mirrored = image, turned = image;
  const Random random(4);
  for (int y = 0; y < 25; ++y)
    for (int x = 0; x < 31; ++x) {
      image(x, y) = float(std::sin(0.4 * x) * std::cos(0.3 * y * y / 9) + 0.2 * random.uniform(std::uint64_t(y * 31 + x)));
      mirrored(30 - x, y) = turned(x, 24 - y) = image(x, y);
    }
  const ImageShockOptions options{.weights = {1, 1}, .time = {ShockTime::Unit::relative, 2}};
  const ShockedImage found = shock(image, options);
  EXPECT_GT(found.time, 0);
  for (const Image<float>& other : {mirrored, turned}) {
    const ShockedImage there = shock(other, options);
    EXPECT_NEAR(there.time, found.time, 1e-9 * found.time);
    EXPECT_NEAR(there.rate, found.rate, 1e-9 * found.rate);
  }
}

/// The same closed forms as on meshes, and a side of one pixel as if repeated.
TEST(ImageShock, HasAPotentialOfClosedFormOnRampsAndParabolas) {
  for (const int height : {1, 9}) {
    Image<float> ramp(12, height, 2), parabola(12, height, 1);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < 12; ++x) {
        ramp(x, y, 0) = float(0.25 * x), ramp(x, y, 1) = float(-0.5 * x);
        parabola(x, y) = float(0.5 * 0.25 * x * x);
      }
    for (const double P : shock_potential(ramp, {})) EXPECT_NEAR(P, 0.5 * (0.0625 + 0.25), 1e-12);
    const std::vector<double> P = shock_potential(parabola, {});
    ASSERT_EQ(P.size(), 12U * std::size_t(height));
    for (int y = 0; y < height; ++y)
      for (int x = 1; x < 11; ++x)
        EXPECT_NEAR(P[std::size_t(y * 12 + x)], 0.5 * 0.0625 * (x * x + 0.25), 1e-12) << height;
  }
}

TEST(GridFlow, FindsThePointAtAPlace) {
  const GridFlow flow = GridFlow::along(7, 5, std::vector<std::array<double, 2>>(24));
  for (double y = 0; y <= 4; y += 0.25)
    for (double x = 0; x <= 6; x += 0.25) {
      const SurfacePoint point = flow.point(x, y);
      EXPECT_GE(point.barycentric.minCoeff(), 0);
      EXPECT_EQ(flow.place(point), (std::array<double, 2>{x, y}));
    }
  EXPECT_EQ(flow.place(flow.point(-1, 9)), (std::array<double, 2>{0, 4}));
}

TEST(GridFlow, FallsToPixelsThatAreMinima) {
  const int width = 61, height = 37;
  std::vector<double> P;
  const Random random(8);
  for (int i = 0; i < width * height; ++i)
    P.push_back(std::sin(0.2 * (i % width)) * std::cos(0.3 * (i / width)) +
                0.2 * random.uniform(std::uint64_t(i)));
  const GridFlow flow = GridFlow::downhill(width, height, P);
  const Traced traced = flow.trace_pixels(std::numeric_limits<double>::infinity());
  EXPECT_EQ(traced.counts.cut_short, 0);
  EXPECT_EQ(traced.counts.resting, width * height);
  for (const SurfacePoint& end : traced.ends) {
    const auto [column, row] = flow.place(end);
    ASSERT_EQ(column, std::floor(column));
    ASSERT_EQ(row, std::floor(row));
    const int x = int(column), y = int(row);
    const auto at = [&](int i, int j) {
      return P[std::size_t(std::clamp(j, 0, height - 1) * width + std::clamp(i, 0, width - 1))];
    };
    for (const auto& [dx, dy] :
         {std::pair(1, 0), std::pair(-1, 0), std::pair(0, 1), std::pair(0, -1)})
      EXPECT_GE(at(x + dx, y + dy), at(x, y));
  }
}

TEST(GridFlow, FollowsAConstantFieldStraightToTheBorder) {
  const std::vector<std::array<double, 2>> field(19 * 9, {1.0, 0.31});
  const GridFlow flow = GridFlow::along(20, 10, field);
  const Traced traced = flow.trace_pixels(2.5);
  for (int y = 0; y < 10; ++y)
    for (int x = 0; x < 20; ++x) {
      const auto [column, row] = flow.place(traced.ends[std::size_t(y * 20 + x)]);
      EXPECT_NEAR(column, std::min(19.0, x + 2.5), 1e-12);
      if (x + 2.5 < 19) {
        EXPECT_NEAR(row, std::min(9.0, y + 2.5 * 0.31), 1e-12);
      }
    }
}

TEST(GridFlow, LeavesWholeTurnsOut) {
  // Round the middle pixel of four cells on diamonds: 4·r lengths of √2 at speed √2.
  const GridFlow flow = GridFlow::along(3, 3, {{{1, -1}, {1, 1}, {-1, -1}, {-1, 1}}});
  const double radius = 0.37, turn = 4 * radius;
  const auto start = [&] {
    for (const SurfacePoint& p : flow.trace_pixels(0).ends)
      if (flow.place(p) == std::array{1.0, 1.0}) return p;
    return SurfacePoint{};
  }();
  SurfacePoint from = start;
  for (int k = 0; k < 3; ++k) {
    SurfacePoint beside = start;
    beside.barycentric = (1 - radius) * start.barycentric + radius * Vector3::Unit(k);
    const auto [column, row] = flow.place(beside);
    if (std::abs(std::abs(column - 1) + std::abs(row - 1) - radius) < 1e-12) from = beside;
  }
  ASSERT_NE(flow.place(from), flow.place(start));
  const std::vector<SurfacePoint> starts{from};
  for (const double part : {0.0, 0.3, 0.8}) {
    const Traced once = flow.trace(starts, part * turn);
    const Traced often = flow.trace(starts, (1e4 + part) * turn);
    EXPECT_EQ(often.counts.cut_short, 0);
    EXPECT_LT(often.counts.triangles, 1000);
    for (int i = 0; i < 2; ++i)
      EXPECT_NEAR(flow.place(often.ends[0])[i], flow.place(once.ends[0])[i], 1e-6) << part;
  }
  const Traced ever = flow.trace(starts, std::numeric_limits<double>::infinity());
  EXPECT_EQ(ever.counts.cut_short, 1);
  EXPECT_LT(ever.counts.triangles, 1000);
}

TEST(GridFlow, WindsIntoAPixelInAFewTurns) {
  // Each turn is nearer by the same factor: without end in crossings, not in time.
  const auto inward = [](double x, double y) { return std::array{-y - 0.3 * x, x - 0.3 * y}; };
  const GridFlow flow =
      GridFlow::along(3, 3, {inward(-1, -1), inward(1, -1), inward(-1, 1), inward(1, 1)});
  const Traced traced = flow.trace_pixels(1e9);
  EXPECT_EQ(traced.counts.cut_short, 0);
  EXPECT_LT(traced.counts.triangles, 9000);
  for (const SurfacePoint& end : traced.ends) EXPECT_EQ(flow.place(end), (std::array{1.0, 1.0}));
}

TEST(GridFlow, RefusesWhatIsNoImage) {
  EXPECT_THROW(GridFlow::downhill(1, 5, std::vector<double>(5)), InvalidInput);
  EXPECT_THROW(GridFlow::downhill(3, 3, std::vector<double>(8)), InvalidInput);
  EXPECT_THROW(GridFlow::downhill(2, 2, {0, NAN, 0, 0}), InvalidInput);
  EXPECT_THROW(shock(Image<float>(), {}), InvalidInput);
  EXPECT_THROW(shock(Image<float>(4, 4, 1, INFINITY), {}), InvalidInput);
  EXPECT_THROW(shock(Image<float>(4, 4, 1), {.weights = {}, .time = {}, .steps = 0}), InvalidInput);
}

}  // namespace
}  // namespace mq
