#include "mq/evolving/lifespan_atlas.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

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

// ---- With a look-ahead ----

LifespanAtlasOptions known(int look_ahead, int trials = 2) {
  LifespanAtlasOptions options = quick();
  options.unwrap.trials = trials;
  options.look_ahead = look_ahead;
  return options;
}

void expect_equal_coordinates(const EvolvingMesh& one, const EvolvingMesh& other, int segments) {
  for (int s = 0; s < segments; ++s) {
    EXPECT_EQ(one.segments[s].uvs, other.segments[s].uvs) << "segment " << s;
    EXPECT_EQ(one.segments[s].corner_uvs, other.segments[s].corner_uvs) << "segment " << s;
  }
}

TEST(LookAhead, IsTheWholeSequencesAtlasWhereItShowsAll) {
  EvolvingMesh whole = patched_sheet(14, 7, 3), ahead = whole;
  const LifespanAtlas one = lay_out(whole, quick());
  const LifespanAtlas other = lay_out(ahead, known(int(ahead.frames.size()) - 1));
  expect_equal_coordinates(whole, ahead, 7);
  EXPECT_EQ(other.plans, 1);
  EXPECT_TRUE(other.cleared.empty());
  // Charts lived as those of the whole sequence are found to.
  const NeighbourGraph graph = neighbour_graph(whole);
  const LifespanCharts found = find_lifespan_charts(graph);
  EXPECT_EQ(other.charting.energy, found.energy);
  std::map<int, std::map<int, std::pair<int, int>>> life;  // per triangle, per first frame
  for (const LifespanChart& chart : found.charts)
    for (const int c : chart.chains)
      life[graph.chains[c].triangle][one.periods[chart.first].first] = {
          one.periods[chart.first].first, one.periods[chart.last].last};
  for (const LifespanAtlas* atlas : {&one, &other})
    for (const AtlasPrism& prism : atlas->charts)
      for (const int id : prism.triangles)
        EXPECT_EQ(life[id][prism.first], std::pair(prism.first, prism.last));
}

TEST(LookAhead, DependsOnNothingThatIsFartherAhead) {
  // The same for 15 frames, then another sequence: what can be known by then must be the same.
  const int same = 5;
  const EvolvingMesh all = patched_sheet(10, 7, 5);
  EvolvingMesh one = all, other = all;
  other.frames.resize(3 * same);
  other.segments.resize(same);
  for (EvolvingFrame frame : all.frames)
    if (frame.segment >= same) {  // the first connectivity again, with new ids, and much larger
      if (frame.segment == int(other.segments.size())) {
        other.segments.push_back(all.segments[0]);
        for (int& id : other.segments.back().triangle_ids) id += 100000 * frame.segment;
      }
      for (Vector3& p : frame.positions) p *= 3;
      other.frames.push_back(frame);
    }
  for (const int look_ahead : {0, 2, 7}) {
    lay_out(one, known(look_ahead));
    lay_out(other, known(look_ahead));
    // Segment s is given its coordinates when frame 3 s + look_ahead is known.
    expect_equal_coordinates(one, other, (3 * same - 1 - look_ahead) / 3 + 1);
  }
}

TEST(LookAhead, KeepsTextureCoordinatesOfChartsThatGoOn) {
  for (const int look_ahead : {0, 4, 9}) {
    EvolvingMesh evolving = patched_sheet(12, 6, 8);
    const LifespanAtlas atlas = lay_out(evolving, known(look_ahead));
    std::map<std::pair<int, int>, int> chart_of;  // of triangle and frame
    for (std::size_t c = 0; c < atlas.charts.size(); ++c)
      for (const int id : atlas.charts[c].triangles)
        for (int f = atlas.charts[c].first; f <= atlas.charts[c].last; ++f)
          EXPECT_TRUE(chart_of.try_emplace({id, f}, int(c)).second);
    int kept = 0, moved = 0, reported = 0;
    for (std::size_t s = 1; s < evolving.segments.size(); ++s) {
      const EvolvingSegment &before = evolving.segments[s - 1], &now = evolving.segments[s];
      std::map<int, int> index;
      for (int t = 0; t < before.triangle_count(); ++t) index[before.triangle_ids[t]] = t;
      for (int t = 0; t < now.triangle_count(); ++t) {
        const int id = now.triangle_ids[t], f = 3 * int(s);
        ASSERT_TRUE(chart_of.contains({id, f}));
        if (!index.contains(id)) continue;
        const bool stays = chart_of[{id, f}] == chart_of[{id, f - 1}];
        EXPECT_EQ(corners(now, t) == corners(before, index[id]), stays);
        ++(stays ? kept : moved);
      }
      reported += atlas.frames[3 * s].renewed - atlas.frames[3 * s].added;
    }
    EXPECT_GT(kept, moved);
    EXPECT_EQ(reported, moved);
    EXPECT_EQ(atlas.moved, moved);
    EXPECT_EQ(atlas.flipped, 0);
    for (const LifespanAtlasFrame& frame : atlas.frames) EXPECT_LE(frame.stretch, atlas.stretch);
    EXPECT_GT(atlas.charting.energy, 0.5 * atlas.energy_of_whole);
    EXPECT_EQ(atlas.plans, int(atlas.periods.size()) + int(atlas.cleared.size()));
  }
}

void expect_no_texel_twice(const EvolvingMesh& evolving, int frame) {
  const Surface surface = make_surface(evolving.mesh(frame));
  const Coverage coverage =
      texel_coverage(surface, make_atlas(surface, {{size, size}}, {}), {}).front();
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) EXPECT_LE(coverage.count(x, y), 1) << frame;
}

TEST(LookAhead, NeverGivesATexelToTwoChartsOfAFrame) {
  for (const int look_ahead : {0, 5}) {
    EvolvingMesh evolving = patched_sheet(14, 8, 2);
    const LifespanAtlas atlas = lay_out(evolving, known(look_ahead));
    for (int f = 0; f < int(evolving.frames.size()); f += 3) {
      EXPECT_EQ(atlas.frames[f].flipped, 0);
      expect_no_texel_twice(evolving, f);
    }
  }
}

/// How many pieces of the texture the triangles at a vertex of a segment are in.
std::map<int, int> pieces_at_vertices(const EvolvingSegment& segment) {
  std::map<int, std::set<int>> uvs;
  for (int t = 0; t < segment.triangle_count(); ++t)
    for (int k = 0; k < 3; ++k) uvs[segment.triangles[t][k]].insert(segment.corner_uvs[t][k]);
  std::map<int, int> result;
  for (const auto& [v, all] : uvs) result[v] = int(all.size());
  return result;
}

/// A sheet of n × n squares, of which in the second period those around a vertex are others.
EvolvingMesh sheet_with_new_squares(int n, int vertex, int radius) {
  EvolvingMesh evolving = patched_sheet(n, 1, 1);
  std::vector<int> ids(n * n);
  for (int i = 0; i < n * n; ++i) {
    const int x = i % n - vertex % (n + 1), y = i / n - vertex / (n + 1);
    const bool is_new = x >= -radius && x < radius && y >= -radius && y < radius;
    ids[i] = is_new ? n * n + i : i;
  }
  evolving.segments.push_back(grid(n, ids));
  for (int f = 0; f < 3; ++f) evolving.frames.push_back({3 + f, 1, evolving.frames[f].positions});
  return evolving;
}

TEST(LookAhead, PartsWhatIsNewBetweenTheChartsAroundIt) {
  const int n = 14;
  EvolvingMesh first = patched_sheet(n, 1, 1);
  lay_out(first, known(0));
  int tried = 0;
  for (const auto& [vertex, pieces] : pieces_at_vertices(first.segments[0])) {
    const int x = vertex % (n + 1), y = vertex / (n + 1);
    if (pieces < 2 || x < 3 || y < 3 || x > n - 3 || y > n - 3 || (x + y) % 2 == 1) continue;
    ++tried;
    EvolvingMesh evolving = sheet_with_new_squares(n, vertex, 2);
    const LifespanAtlas atlas = lay_out(evolving, known(0));
    EXPECT_LE(atlas.frames[3].charts, atlas.frames[0].charts) << "around vertex " << vertex;
    EXPECT_EQ(atlas.frames[3].added, 32);
    EXPECT_EQ(atlas.flipped, 0);
    std::map<int, int> index;
    for (int t = 0; t < 2 * n * n; ++t) index[evolving.segments[0].triangle_ids[t]] = t;
    int moved = 0;
    for (int t = 0; t < 2 * n * n; ++t)
      if (const auto before = index.find(evolving.segments[1].triangle_ids[t]); before != index.end())
        moved += corners(evolving.segments[1], t) != corners(evolving.segments[0], before->second);
    EXPECT_EQ(moved, atlas.moved);
    EXPECT_LE(moved, n * n / 2);  // what is around, at most
    expect_no_texel_twice(evolving, 3);
  }
  EXPECT_GT(tried, 3);
}

TEST(LookAhead, DoesNotGatherCharts) {
  // In every period another 4 × 4 squares of a waving sheet are new.
  const int n = 20, periods = 14;
  for (const int seed : {3, 4, 5}) {
    const Random random{std::uint64_t(seed)};
    EvolvingMesh evolving = patched_sheet(n, periods, 1);
    std::vector<int> ids(n * n);
    for (int i = 0; i < n * n; ++i) ids[i] = i;
    for (int p = 0; p < periods; ++p) {
      const int x = int((n - 4) * random.uniform(2 * p)), y = int((n - 4) * random.uniform(2 * p + 1));
      for (int i = 0; p > 0 && i < 16; ++i) ids[(y + i / 4) * n + x + i % 4] = n * n + 16 * p + i;
      evolving.segments[p] = grid(n, ids);
    }
    LifespanAtlasOptions options = known(0);
    options.unwrap.width = options.unwrap.height = 4 * size;
    const LifespanAtlas atlas = lay_out(evolving, options);
    for (const LifespanAtlasFrame& frame : atlas.frames) EXPECT_LE(frame.charts, atlas.frames[0].charts + 5) << seed;
    EXPECT_TRUE(atlas.cleared.empty()) << seed;
    EXPECT_EQ(atlas.flipped, 0);
    EXPECT_LT(atlas.moved, 2 * n * n);  // once in all
  }
}

TEST(LookAhead, PartsNoChartForWhatWillEnd) {
  // Three discs are replaced in every period, one of which the look-ahead shows, or three.
  for (const int seed : {8, 2, 5}) {
    EvolvingMesh one = patched_sheet(14, 8, seed);
    const LifespanAtlas nothing = lay_out(one, known(0));
    for (const int look_ahead : {3, 9}) {
      EvolvingMesh other = patched_sheet(14, 8, seed);
      const LifespanAtlas something = lay_out(other, known(look_ahead));
      EXPECT_LE(something.frames[0].charts, nothing.frames[0].charts + 1) << seed;
    }
    EvolvingMesh whole = patched_sheet(14, 8, seed);
    EXPECT_GT(lay_out(whole, quick()).frames[0].charts, nothing.frames[0].charts + 1) << seed;
  }
}

TEST(LookAhead, MakesTheTextureAnewWhereItIsFull) {
  // A sheet that grows to four times its area, by triangles that are new.
  EvolvingMesh evolving;
  for (int s = 0; s < 6; ++s) {
    EvolvingSegment segment;
    EvolvingFrame frame{s, s, {}};
    const int across = 4 + 2 * s;
    for (int v = 0; v < 5 * (across + 1); ++v) {
      segment.vertex_ids.push_back(v);
      frame.positions.emplace_back(v / 5, v % 5, 0);
    }
    for (int x = 0; x < across; ++x)
      for (int y = 0; y < 4; ++y) {
        const int v = 5 * x + y;
        segment.triangles.push_back({v, v + 5, v + 6});
        segment.triangles.push_back({v, v + 6, v + 1});
        segment.triangle_ids.push_back(2 * v);
        segment.triangle_ids.push_back(2 * v + 1);
      }
    evolving.segments.push_back(segment);
    evolving.frames.push_back(frame);
  }
  const LifespanAtlas atlas = lay_out(evolving, known(0));
  EXPECT_GE(atlas.cleared.size(), 1U);
  EXPECT_LE(atlas.cleared.size(), 5U);
  for (const int f : atlas.cleared)
    EXPECT_EQ(atlas.frames[f].renewed, evolving.segments[f].triangle_count());
  for (const LifespanAtlasFrame& frame : atlas.frames) EXPECT_GT(frame.occupancy, 0.3);
}

TEST(LookAhead, IsTheSameInEveryUnitOfLength) {
  EvolvingMesh one = patched_sheet(10, 5, 5), other = patched_sheet(10, 5, 5, 100);
  lay_out(one, known(4));
  lay_out(other, known(4));
  expect_equal_coordinates(one, other, 5);
}

}  // namespace
}  // namespace mq
