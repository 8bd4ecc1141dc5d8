#include "mq/atlas/clip.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "mq/base/random.h"

namespace mq {
namespace {

using Corners = std::array<TexelPoint, 3>;

double area_of(const Corners& c) {
  return std::abs(double(orientation(c[0], c[1], c[2]))) / 2 / std::pow(double(TexelPoint::one), 2);
}

template <class Visit>
void for_each_cell(const Corners& corners, const Visit& visit) {
  const auto [first, end] = rows_of(corners);
  for (int row = first; row < end; ++row)
    clip_row(corners, row, visit, [&](int r, int from, int to) {
      for (int column = from; column <= to; ++column) visit(whole_cell(r, column));
    });
}

void expect_tiles(const Corners& corners) {
  double sum = 0;
  std::map<std::pair<int, int>, int> seen;
  for_each_cell(corners, [&](const Piece& piece) {
    sum += piece.area();
    ++seen[{piece.row, piece.column}];
    EXPECT_GE(piece.count, 3);
    EXPECT_LE(piece.count, 7);
    for (int k = 0; k < piece.count; ++k) {
      const Piece::Vertex& v = piece.vertices[k];
      EXPECT_TRUE(v.x >= 0 && v.x <= 1 && v.y >= 0 && v.y <= 1) << v.x << ' ' << v.y;
    }
  });
  EXPECT_NEAR(sum, area_of(corners), 1e-13 * std::max(1.0, area_of(corners)));
  for (const auto& [cell, count] : seen) EXPECT_EQ(count, 1);
}

/// Coordinates drawn from texel lines, centres of cells, hairs beside lines and anywhere.
TexelPoint random_point(const Random& random, std::uint64_t at) {
  const auto coordinate = [&](std::uint64_t k) {
    const std::int64_t whole = std::int64_t(random.uniform(4 * k, -3, 12));
    switch (int(random.uniform(4 * k + 1, 0, 5))) {
      case 0: return whole * TexelPoint::one;
      case 1: return whole * TexelPoint::one + TexelPoint::one / 2;
      case 2: return whole * TexelPoint::one + 1;
      case 3: return whole * TexelPoint::one - 1;
      default: return std::int64_t(random.uniform(4 * k + 2, -3, 12) * double(TexelPoint::one));
    }
  };
  return {coordinate(2 * at), coordinate(2 * at + 1)};
}

TEST(Clip, TilesTrianglesWithVerticesOnTexelLines) {
  const Random random(7);
  int tested = 0;
  for (std::uint64_t k = 0; k < 20000; ++k) {
    const Corners corners{random_point(random, 3 * k), random_point(random, 3 * k + 1),
                          random_point(random, 3 * k + 2)};
    if (orientation(corners[0], corners[1], corners[2]) == 0) continue;
    expect_tiles(corners);
    if (HasFailure()) FAIL() << "triangle " << k;
    ++tested;
  }
  EXPECT_GT(tested, 15000);
}

TEST(Clip, KeepsTheRelativeAreaOfSlivers) {
  const Random random(3);
  for (std::uint64_t k = 0; k < 2000; ++k) {
    Corners corners{random_point(random, 2 * k), random_point(random, 2 * k + 1), {}};
    // A third corner two units of 2^-36 texel beside the first edge.
    corners[2] = {(corners[0].x + corners[1].x) / 2 + 2, (corners[0].y + corners[1].y) / 2};
    if (area_of(corners) < 1e-12) continue;
    double sum = 0;
    for_each_cell(corners, [&](const Piece& piece) { sum += piece.area(); });
    EXPECT_NEAR(sum / area_of(corners), 1, 1e-3);
  }
}

TEST(Clip, FindsWholeCellsInRuns) {
  const std::int64_t one = TexelPoint::one;
  const Corners corners{{{-1000 * one, -1000 * one}, {3000 * one, -1000 * one}, {0, 3000 * one}}};
  int runs = 0, cells = 0;
  clip_row(
      corners, 5, [&](const Piece&) {},
      [&](int, int first, int last) {
        ++runs;
        cells += last - first + 1;
      });
  EXPECT_EQ(runs, 1);
  EXPECT_GT(cells, 2000);
}

TEST(Clip, GivesBothTrianglesOfAnEdgeTheSameCrossings) {
  const Random random(11);
  for (std::uint64_t k = 0; k < 500; ++k) {
    const TexelPoint a = random_point(random, 4 * k), b = random_point(random, 4 * k + 1),
                     c = random_point(random, 4 * k + 2), d = random_point(random, 4 * k + 3);
    const int left = sign(orientation(a, b, c));
    if (left == 0 || left * sign(orientation(a, b, d)) >= 0) continue;
    std::map<std::tuple<int, int, double, double>, int> crossings;
    const auto collect = [&](const Corners& corners) {
      for_each_cell(corners, [&](const Piece& piece) {
        for (int v = 0; v < piece.count; ++v) {
          const Piece::Vertex &p = piece.vertices[v], &q = piece.vertices[(v + 1) % piece.count];
          if (p.side != 0) continue;  // edge 0 is a, b in both
          crossings[{piece.row, piece.column, p.x, p.y}] ^= 1;
          crossings[{piece.row, piece.column, q.x, q.y}] ^= 1;
        }
      });
    };
    collect({a, b, c});
    collect({b, a, d});
    // Where the edge runs along a texel line its two sides lie in different cells.
    if (a.x == b.x || a.y == b.y) continue;
    for (const auto& [point, odd] : crossings) EXPECT_EQ(odd, 0) << "edge " << k;
  }
}

}  // namespace
}  // namespace mq
