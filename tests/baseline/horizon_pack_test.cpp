#include "mq/baseline/horizon_pack.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mq/base/error.h"
#include "mq/base/random.h"

namespace mq {
namespace {

PackChart rectangle(double width, double height, int first = 0, int last = 0) {
  return {{{{0, 0}, {width, 0}, {width, height}, {0, height}}}, width * height, first, last};
}

/// Stars of three to seven spikes, and every fourth of them with a hole.
std::vector<PackChart> stars(int count, int frames) {
  const Random random(5);
  std::vector<PackChart> charts;
  for (int i = 0; i < count; ++i) {
    const auto draw = [&](int k) { return random.uniform(4 * std::uint64_t(i) + std::uint64_t(k)); };
    const int spikes = 3 + i % 5;
    const double radius = 0.05 + draw(0);
    const double pi = std::numbers::pi;
    PackChart chart{{{}}, spikes * radius * radius / 2 * std::sin(pi / spikes), int(draw(2) * frames), 0};
    chart.last = std::min(frames - 1, chart.first + int(draw(3) * frames));
    const auto add = [&](double size) {
      for (int k = 0; k < 2 * spikes; ++k) {
        const double angle = 6 * draw(1) + pi * k / spikes, r = k % 2 == 0 ? size : size / 2;
        chart.loops.back().push_back({r * std::cos(angle), r * std::sin(angle)});
      }
    };
    add(radius);
    if (i % 4 == 0) {
      chart.loops.emplace_back();
      add(radius / 2);
      chart.area *= 0.75;
    }
    charts.push_back(chart);
  }
  return charts;
}

/// Texels of `other` at most `gutter` away from those of `one`.
int conflicts(const std::vector<char>& one, const std::vector<char>& other, const HorizonPackOptions& size) {
  int count = 0;
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      if (!one[std::size_t(y) * size.width + x]) continue;
      for (int v = std::max(0, y - size.gutter); v <= std::min(size.height - 1, y + size.gutter); ++v)
        for (int u = std::max(0, x - size.gutter); u <= std::min(size.width - 1, x + size.gutter); ++u)
          count += other[std::size_t(v) * size.width + u];
    }
  return count;
}

void expect_apart(const std::vector<PackChart>& charts, const HorizonPackOptions& options) {
  const Packing packing = horizon_pack(charts, options);
  EXPECT_GT(packing.occupancy, 0.2);
  EXPECT_LE(packing.occupancy, 1);
  EXPECT_GE(packing.bound, 1);
  std::vector<std::vector<char>> texels;
  const double margin = (options.gutter + 1) / 2;
  for (std::size_t c = 0; c < charts.size(); ++c) {
    const Placement& place = packing.places[c];
    texels.push_back(touched_texels(charts[c], place, packing.scale, options.width, options.height));
    EXPECT_GT(std::ranges::count(texels[c], 1), 0) << "chart " << c << " lies nowhere";
    for (const auto& loop : charts[c].loops)
      for (const Vector2& p : loop) {
        const double s = std::sin(place.angle), k = std::cos(place.angle);
        const Vector2 q = packing.scale * Vector2(k * p.x() - s * p.y(), s * p.x() + k * p.y()) + place.shift;
        EXPECT_GE(q.minCoeff(), margin);
        EXPECT_LE(q.x(), options.width - margin);
        EXPECT_LE(q.y(), options.height - margin);
      }
  }
  for (std::size_t c = 0; c < charts.size(); ++c)
    for (std::size_t d = c + 1; d < charts.size(); ++d) {
      if (charts[c].first > charts[d].last || charts[d].first > charts[c].last) continue;
      EXPECT_EQ(conflicts(texels[c], texels[d], options), 0) << c << " and " << d;
    }
}

TEST(HorizonPack, LeavesTheGutterFreeBetweenAllCharts) {
  for (const int gutter : {0, 1, 2, 5})
    for (const int directions : {1, 4}) {
      SCOPED_TRACE(gutter);
      expect_apart(stars(24, 1), {.width = 300, .height = 220, .gutter = gutter, .directions = directions});
    }
}

TEST(HorizonPack, LeavesTheGutterFreeBetweenChartsThatLiveTogether) {
  expect_apart(stars(30, 7), {.width = 200, .height = 256, .gutter = 3});
}

TEST(HorizonPack, GivesChartsThatNeverMeetTheSamePlace) {
  std::vector<PackChart> charts;
  for (int frame = 0; frame < 6; ++frame) charts.push_back(rectangle(1, 1.001, frame, frame));
  const Packing packing = horizon_pack(charts, {.width = 128, .height = 128, .gutter = 0});
  for (const Placement& place : packing.places) EXPECT_LT((place.shift - packing.places[0].shift).norm(), 1e-9);
}

TEST(HorizonPack, FillsTheTextureWithOneRectangleOfItsShape) {
  // Its diagonal is turned upright; among sixteen directions of a square, whose diagonal is at 45°, is the right one.
  const Packing packing = horizon_pack({rectangle(1, 1)}, {.width = 128, .height = 128, .gutter = 0, .directions = 16});
  EXPECT_GT(packing.occupancy, 0.97);
  EXPECT_LT(horizon_pack({rectangle(1, 1)}, {.width = 128, .height = 128, .gutter = 0}).occupancy, 0.55);
}

TEST(HorizonPack, HasMoreRoomWithMoreLinesAndDirections) {
  const std::vector<PackChart> charts = stars(24, 1);
  const auto occupancy = [&](int lines, int directions) {
    return horizon_pack(charts, {.width = 256, .height = 256, .lines = lines, .directions = directions}).occupancy;
  };
  EXPECT_GT(occupancy(16, 1), occupancy(1, 1));
  EXPECT_GT(occupancy(16, 16), occupancy(16, 1));
}

TEST(HorizonPack, RefusesWhatCannotBePlaced) {
  EXPECT_THROW(horizon_pack({}), InvalidInput);
  EXPECT_THROW(horizon_pack({rectangle(0, 1)}), InvalidInput);
  EXPECT_THROW(horizon_pack({rectangle(1, 1, 3, 2)}), InvalidInput);
  EXPECT_THROW(horizon_pack({rectangle(1, 1)}, {.lines = 0}), InvalidInput);
  EXPECT_THROW(horizon_pack({rectangle(1, 1)}, {.gutter = -1}), InvalidInput);
  EXPECT_THROW(horizon_pack(std::vector<PackChart>(400, rectangle(1, 1)), {.width = 16, .height = 16}), InvalidInput);
}

}  // namespace
}  // namespace mq
