#include "mq/unwrap/detail/pack.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mq/base/error.h"
#include "mq/base/random.h"
#include "mq/unwrap/detail/pack_shape.h"

namespace mq {
namespace {

PackChart rectangle(double width, double height, int first = 0, int last = 0) {
  return {{{{0, 0}, {width, 0}, {width, height}, {0, height}}}, width * height, first, last};
}

/// A star of `spikes` spikes, its inner radius half the outer one.
PackChart star(double radius, int spikes, double turn, int first, int last) {
  PackChart chart;
  chart.loops.emplace_back();
  for (int i = 0; i < 2 * spikes; ++i) {
    const double angle = turn + std::numbers::pi * i / spikes, r = i % 2 == 0 ? radius : radius / 2;
    chart.loops[0].push_back({r * std::cos(angle), r * std::sin(angle)});
  }
  chart.area = spikes * radius * radius / 2 * std::sin(std::numbers::pi / spikes);
  chart.first = first;
  chart.last = last;
  return chart;
}

std::vector<PackChart> stars(int count, int frames) {
  const Random random(5);
  std::vector<PackChart> charts;
  for (int i = 0; i < count; ++i) {
    const auto draw = [&](int k) {
      return random.uniform(4 * std::uint64_t(i) + std::uint64_t(k));
    };
    const int first = int(draw(2) * frames),
              last = std::min(frames - 1, first + int(draw(3) * frames));
    charts.push_back(star(0.05 + draw(0), 3 + i % 5, 6 * draw(1), first, last));
  }
  return charts;
}

/// The touched texels of a chart, and the number of those of `other` at most `gutter` away.
int conflicts(const std::vector<char>& one, const std::vector<char>& other, int width, int height,
              int gutter) {
  int count = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (!one[std::size_t(y) * width + x]) continue;
      for (int v = std::max(0, y - gutter); v <= std::min(height - 1, y + gutter); ++v)
        for (int u = std::max(0, x - gutter); u <= std::min(width - 1, x + gutter); ++u)
          count += other[std::size_t(v) * width + u];
    }
  return count;
}

void expect_apart(const std::vector<PackChart>& charts, const PackOptions& options) {
  const Packing packing = pack(charts, options);
  std::vector<std::vector<char>> texels;
  for (std::size_t c = 0; c < charts.size(); ++c) {
    texels.push_back(
        touched_texels(charts[c], packing.places[c], packing.scale, options.width, options.height));
    EXPECT_GT(std::ranges::count(texels[c], 1), 0) << "chart " << c << " lies nowhere";
    const int margin = (options.gutter + 1) / 2;
    for (const auto& loop : charts[c].loops)
      for (const Vector2& p : loop) {
        const double a = packing.places[c].angle;
        const Vector2 q = packing.scale * Vector2(std::cos(a) * p.x() - std::sin(a) * p.y(),
                                                  std::sin(a) * p.x() + std::cos(a) * p.y()) +
                          packing.places[c].shift;
        EXPECT_GE(q.minCoeff(), margin);
        EXPECT_LE(q.x(), options.width - margin);
        EXPECT_LE(q.y(), options.height - margin);
      }
  }
  for (std::size_t c = 0; c < charts.size(); ++c)
    for (std::size_t d = c + 1; d < charts.size(); ++d) {
      if (charts[c].first > charts[d].last || charts[d].first > charts[c].last) continue;
      EXPECT_EQ(conflicts(texels[c], texels[d], options.width, options.height, options.gutter), 0)
          << c << " and " << d;
    }
}

TEST(Pack, LeavesTheGutterFreeBetweenAllCharts) {
  for (const int gutter : {0, 1, 2, 5}) {
    SCOPED_TRACE(gutter);
    expect_apart(stars(30, 1), {.width = 300, .height = 300, .gutter = gutter, .trials = 3});
  }
}

TEST(Pack, LeavesTheGutterFreeWhereOrdersAreTriedAtALowerResolution) {
  expect_apart(stars(12, 1), {.width = 1024, .height = 640, .gutter = 2, .trials = 5});
}

TEST(Pack, LeavesTheGutterFreeBetweenChartsThatLiveTogether) {
  expect_apart(stars(40, 9), {.width = 256, .height = 200, .gutter = 2, .trials = 3});
}

TEST(Pack, GivesChartsThatNeverMeetTheSamePlace) {
  std::vector<PackChart> charts;
  for (int frame = 0; frame < 6; ++frame) charts.push_back(rectangle(1, 1, frame, frame));
  const Packing packing = pack(charts, {.width = 128, .height = 128, .gutter = 0});
  EXPECT_GT(packing.occupancy, 0.96);
  EXPECT_LT(packing.bound, 1.04);
  for (const Placement& place : packing.places) EXPECT_EQ(place.shift, packing.places[0].shift);
}

/// A square cut into rectangles, which could fill it again.
std::vector<PackChart> perfect_rectangles(int count) {
  const Random random(11);
  std::vector<Vector2> sizes{{1, 1}};
  for (int i = 0; std::ssize(sizes) < count; ++i) {
    std::ranges::stable_sort(sizes, std::ranges::greater{},
                             [](const Vector2& s) { return s.prod(); });
    Vector2& cut = sizes.front();
    const double share = random.uniform(std::uint64_t(i), 0.3, 0.7);
    Vector2 rest = cut;
    const int axis = cut.x() >= cut.y() ? 0 : 1;
    cut[axis] *= share;
    rest[axis] *= 1 - share;
    sizes.push_back(rest);
  }
  std::vector<PackChart> charts;
  for (const Vector2& size : sizes) charts.push_back(rectangle(size.x(), size.y()));
  return charts;
}

TEST(Pack, FillsASquareWithTheRectanglesItWasCutInto) {
  for (const int count : {12, 25, 60}) {
    const Packing packing =
        pack(perfect_rectangles(count), {.width = 512, .height = 512, .gutter = 0});
    EXPECT_GE(packing.occupancy, 0.85) << count;
    EXPECT_NEAR(packing.bound, 1 / packing.occupancy, 1e-9);
  }
}

TEST(Pack, IsTheSameForEveryUnit) {
  std::vector<PackChart> charts = stars(20, 1);
  const Packing packing = pack(charts, {.width = 300, .height = 300, .trials = 3});
  for (PackChart& chart : charts) {
    for (Vector2& p : chart.loops[0]) p *= 64;
    chart.area *= 64 * 64;
  }
  const Packing larger = pack(charts, {.width = 300, .height = 300, .trials = 3});
  EXPECT_DOUBLE_EQ(larger.scale * 64, packing.scale);
  for (std::size_t c = 0; c < charts.size(); ++c)
    EXPECT_NEAR((larger.places[c].shift - packing.places[c].shift).norm(), 0, 1e-9);
}

TEST(Pack, RefusesWhatCannotBePlaced) {
  EXPECT_THROW(pack({}), InvalidInput);
  EXPECT_THROW(pack({rectangle(0, 1)}), InvalidInput);
  EXPECT_THROW(pack({rectangle(1, 1, 3, 2)}), InvalidInput);
  EXPECT_THROW(pack(std::vector<PackChart>(400, rectangle(1, 1)), {.width = 16, .height = 16}),
               InvalidInput);
}

TEST(PackShape, TouchesExactlyTheCellsOfARectangle) {
  const PackShape shape = make_shape(rectangle(3.5, 2), 0, 1, 0, 1);
  // From a hair above 0 to a hair above 3.5, and to a hair above 2.
  EXPECT_EQ(shape.width, 4 + 2);
  EXPECT_EQ(shape.height, 3 + 2);
  int touched = 0, wide = 0;
  for (const CellRun& run : shape.touched) touched += run.end - run.begin;
  for (const CellRun& run : shape.wide) wide += run.end - run.begin;
  EXPECT_EQ(touched, 4 * 3);
  EXPECT_EQ(wide, 6 * 5);
}

TEST(PackVolume, FindsTheFirstFreePlaceAmongThoseWhoLiveThen) {
  PackVolume volume(10, 3, 4);
  const PackShape shape = make_shape(rectangle(2.5, 0.5), 0, 1, 0, 0);
  ASSERT_EQ(shape.width, 3);
  volume.take({{0, 2, 4}}, 0, 0, 1, 2);
  volume.look(0, 0);
  EXPECT_EQ(volume.find(shape, 0, 0), 0);
  volume.look(0, 1);
  EXPECT_EQ(volume.find(shape, 0, 0), 4);
  EXPECT_EQ(volume.find(shape, 5, 0), 5);
  volume.look(3, 3);
  EXPECT_EQ(volume.find(shape, 0, 0), 0);
  volume.take({{0, 6, 7}}, 0, 0, 0, 3);
  volume.look(2, 3);
  EXPECT_EQ(volume.find(shape, 0, 0), 7);
  EXPECT_EQ(volume.find(shape, 8, 0), -1);
}

/// The outline of a placed chart in texels from the lower left corner.
std::vector<Vector2> placed(const PackChart& chart, const Placement& place, double scale) {
  std::vector<Vector2> polygon;
  const double c = std::cos(place.angle), s = std::sin(place.angle);
  for (const Vector2& p : chart.loops[0])
    polygon.push_back(scale * Vector2(c * p.x() - s * p.y(), s * p.x() + c * p.y()) + place.shift);
  return polygon;
}

TEST(PackBeside, LeavesTheGutterFreeToWhatIsThere) {
  const PackOptions options{.width = 200, .height = 160, .gutter = 3, .trials = 12};
  const std::vector<PackChart> charts = stars(14, 1);
  const std::vector<PackChart> first(charts.begin(), charts.begin() + 6),
      second(charts.begin() + 6, charts.end());
  const double scale = 0.8 * pack(charts, options).scale;
  const auto before = pack_beside(first, scale, {}, options);
  for (const auto& place : before) ASSERT_TRUE(place.has_value());
  std::vector<std::vector<Vector2>> taken;
  for (std::size_t c = 0; c < first.size(); ++c)
    taken.push_back(placed(first[c], *before[c], scale));
  const auto after = pack_beside(second, scale, taken, options);
  for (const auto& place : after) ASSERT_TRUE(place.has_value());
  std::vector<std::vector<char>> texels;
  for (std::size_t c = 0; c < charts.size(); ++c)
    texels.push_back(touched_texels(charts[c], c < 6 ? *before[c] : *after[c - 6], scale,
                                    options.width, options.height));
  for (std::size_t c = 0; c < charts.size(); ++c) {
    EXPECT_GT(std::ranges::count(texels[c], 1), 0);
    for (std::size_t d = c + 1; d < charts.size(); ++d)
      EXPECT_EQ(conflicts(texels[c], texels[d], options.width, options.height, options.gutter), 0)
          << c << " and " << d;
  }
}

TEST(PackBeside, FillsAHoleAndSaysWhereThereIsNone) {
  // A frame of 100 × 100 texels around a hole of 40 × 40.
  const std::vector<std::vector<Vector2>> taken = {{{0, 0}, {100, 0}, {100, 30}, {0, 30}},
                                                   {{0, 70}, {100, 70}, {100, 100}, {0, 100}},
                                                   {{0, 30}, {30, 30}, {30, 70}, {0, 70}},
                                                   {{70, 30}, {100, 30}, {100, 70}, {70, 70}}};
  const PackOptions options{.width = 100, .height = 100, .gutter = 2};
  const auto places = pack_beside({rectangle(1, 1)}, 33, taken, options);
  ASSERT_TRUE(places[0].has_value());
  for (const Vector2& p : placed(rectangle(1, 1), *places[0], 33)) {
    EXPECT_GT(p.minCoeff(), 32);
    EXPECT_LT(p.maxCoeff(), 68);
  }
  EXPECT_FALSE(pack_beside({rectangle(1, 1)}, 37, taken, options)[0].has_value());
  // The larger one first, then what there is room for beside it.
  const auto three =
      pack_beside({rectangle(0.1, 0.2), rectangle(1, 0.8), rectangle(1, 0.7)}, 33, taken, options);
  EXPECT_TRUE(three[0].has_value());
  EXPECT_TRUE(three[1].has_value());
  EXPECT_FALSE(three[2].has_value());
}

}  // namespace
}  // namespace mq
