#include "mq/sequence/lifespan_atlas.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "evolving_models.h"
#include "mq/atlas/atlas.h"
#include "mq/atlas/coverage.h"

namespace mq {
namespace {

constexpr int size = 128;

LifespanAtlasOptions quick(ChartingOptions charting = {}) {
  return {.unwrap = {.width = size, .height = size, .trials = 2}, .charting = charting};
}

/// The texture coordinates of a triangle in one segment, by the ids of its vertices.
std::map<int, Vector2> corners(const EvolvingSegment& segment, int triangle) {
  std::map<int, Vector2> result;
  for (int k = 0; k < 3; ++k)
    result[segment.vertex_ids[segment.triangles[triangle][k]]] =
        segment.uvs[segment.corner_uvs[triangle][k]];
  return result;
}

TEST(LifespanAtlas, HoldsTextureCoordinatesOverAChartsLife) {
  EvolvingMesh evolving = patched_sheet(14, 6, 4);
  // Corners may be named from another one on in another segment.
  for (Triangle& t : evolving.segments[2].triangles) t = {t[1], t[2], t[0]};
  const LifespanAtlas atlas = lay_out(evolving, quick({.beta = 5}));
  std::map<int, std::map<int, int>> chart_of;  // per segment, per triangle
  for (std::size_t c = 0; c < atlas.charts.size(); ++c)
    for (const int id : atlas.charts[c].triangles)
      for (int f = atlas.charts[c].first; f <= atlas.charts[c].last; ++f) {
        const auto [place, is_new] = chart_of[evolving.frames[f].segment].try_emplace(id, int(c));
        EXPECT_EQ(place->second, int(c));  // one chart at a time
      }
  int kept = 0, renewed = 0;
  for (std::size_t s = 0; s < evolving.segments.size(); ++s) {
    const EvolvingSegment& segment = evolving.segments[s];
    EXPECT_EQ(int(chart_of[int(s)].size()), segment.triangle_count());
    if (s == 0) continue;
    const EvolvingSegment& before = evolving.segments[s - 1];
    std::map<int, int> index;
    for (int t = 0; t < before.triangle_count(); ++t) index[before.triangle_ids[t]] = t;
    for (int t = 0; t < segment.triangle_count(); ++t) {
      const int id = segment.triangle_ids[t];
      if (index.contains(id) && chart_of[int(s)][id] == chart_of[int(s) - 1][id]) {
        EXPECT_EQ(corners(segment, t), corners(before, index[id]));
        ++kept;
      } else
        ++renewed;
    }
  }
  EXPECT_GT(kept, 500);
  int reported = 0;
  for (const LifespanAtlasFrame& frame : atlas.frames) reported += frame.renewed;
  EXPECT_EQ(reported, renewed);
}

TEST(LifespanAtlas, NeverGivesATexelToTwoChartsOfAFrame) {
  EvolvingMesh evolving = patched_sheet(14, 6, 9);
  const LifespanAtlas atlas = lay_out(evolving, quick());
  for (int f = 0; f < int(evolving.frames.size()); f += 3) {
    EXPECT_EQ(atlas.frames[f].flipped, 0);
    EXPECT_GT(atlas.frames[f].occupancy, 0.2);
    const Surface surface = make_surface(evolving.mesh(f));
    const Coverage coverage =
        texel_coverage(surface, make_atlas(surface, {{size, size}}, {}), {}).front();
    int covered = 0, twice = 0;
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) {
        covered += coverage.count(x, y) > 0;
        twice += coverage.count(x, y) > 1;
      }
    EXPECT_EQ(twice, 0);
    EXPECT_NEAR(double(covered) / (size * size), atlas.frames[f].occupancy, 0.03);
  }
}

TEST(LifespanAtlas, HasFewerChartsThanLivesAlone) {
  EvolvingMesh evolving = patched_sheet(16, 8, 12), other = evolving;
  const LifespanAtlas found = lay_out(evolving, quick());
  const LifespanAtlas lives = lay_out(other, quick({.edits = ChartingOptions::Edits::none}));
  EXPECT_LT(found.charts_per_frame, lives.charts_per_frame);
  EXPECT_GE(lives.lifespan, found.lifespan);
}

TEST(LifespanAtlas, IsTheSameInEveryUnitOfLength) {
  EvolvingMesh one = patched_sheet(10, 4, 5), other = patched_sheet(10, 4, 5, 100);
  lay_out(one, quick());
  lay_out(other, quick());
  for (std::size_t s = 0; s < one.segments.size(); ++s) {
    EXPECT_EQ(one.segments[s].uvs, other.segments[s].uvs);
    EXPECT_EQ(one.segments[s].corner_uvs, other.segments[s].corner_uvs);
  }
}

TEST(LifespanAtlas, AveragesTheMetricOverTime) {
  // A flat strip that is twice as long in its second frame: the mean of squared lengths is 5/2.
  EvolvingMesh evolving;
  evolving.segments.push_back(grid(8, [] {
    std::vector<int> ids(64);
    for (int i = 0; i < 64; ++i) ids[i] = i;
    return ids;
  }()));
  for (int f = 0; f < 2; ++f) {
    EvolvingFrame frame{f, 0, {}};
    for (int y = 0; y <= 8; ++y)
      for (int x = 0; x <= 8; ++x) frame.positions.emplace_back((1 + f) * x, y, 0);
    evolving.frames.push_back(frame);
  }
  lay_out(evolving, quick());
  const EvolvingSegment& segment = evolving.segments[0];
  const auto side = [&](int k) {
    const Triangle& t = segment.corner_uvs[0];
    return (segment.uvs[t[(k + 1) % 3]] - segment.uvs[t[k]]).norm();
  };
  EXPECT_NEAR(side(0) / side(1), std::sqrt(2.5), 1e-6);
}

TEST(LifespanAtlas, PlacesCollapsedTriangles) {
  EvolvingMesh evolving = patched_sheet(6, 2, 3);
  for (EvolvingSegment& segment : evolving.segments) {
    segment.triangles.push_back({3, 3, 9});
    segment.triangle_ids.push_back(5000);
  }
  lay_out(evolving, quick());
  for (const EvolvingSegment& segment : evolving.segments)
    for (const Triangle& corners : segment.corner_uvs)
      for (const int uv : corners) EXPECT_GE(uv, 0);
  EXPECT_NO_THROW(check(evolving));
}

}  // namespace
}  // namespace mq
