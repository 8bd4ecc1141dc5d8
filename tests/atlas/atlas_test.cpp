#include "mq/atlas/atlas.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "atlas/atlas_fixtures.h"
#include "mq/base/error.h"
#include "mq/base/random.h"

namespace mq {
namespace {

const Defect* find(const Atlas& atlas, const std::string& kind) {
  const auto at = std::find_if(atlas.defects.begin(), atlas.defects.end(),
                               [&](const Defect& d) { return d.kind == kind; });
  return at == atlas.defects.end() ? nullptr : &*at;
}

std::vector<std::int64_t> ids(const Atlas& atlas, const std::string& kind) {
  const Defect* defect = find(atlas, kind);
  return defect ? defect->ids : std::vector<std::int64_t>();
}

Atlas atlas_of(const Mesh& mesh, int size = 32) {
  return make_atlas(make_surface(mesh), {{size, size}});
}

TEST(Atlas, FindsChartsAndSeams) {
  const Atlas one = atlas_of(fixtures::flat_square(6, 0.2));
  EXPECT_EQ(one.charts.size(), 1);
  EXPECT_EQ(one.seam_count, 0);
  EXPECT_TRUE(one.defects.empty());

  fixtures::CutOptions options;
  options.parts = 3;
  const Atlas nine = atlas_of(fixtures::cut_square(options));
  EXPECT_EQ(nine.charts.size(), 9);
  EXPECT_EQ(nine.seam_count, 2 * 2 * 12);  // four cuts of 12 edges
}

TEST(Atlas, FindsSeamsWhereExportersSplitVertices) {
  EXPECT_EQ(atlas_of(fixtures::two_chart_quad()).seam_count, 1);
  EXPECT_EQ(atlas_of(fixtures::split_two_chart_quad()).seam_count, 1);
}

TEST(Atlas, CountsTheBorderOfTwoTexturesAsASeam) {
  Mesh mesh = fixtures::flat_square(2);
  mesh.textures.assign(8, 0);
  for (int t = 4; t < 8; ++t) mesh.textures[t] = 1;
  const Atlas atlas = make_atlas(make_surface(mesh), {{16, 16}, {32, 32}});
  EXPECT_EQ(atlas.charts.size(), 2);
  EXPECT_EQ(atlas.seam_count, 2);
}

TEST(Atlas, HasTheAreaOfTheSurface) {
  const Atlas atlas = atlas_of(fixtures::flat_square(5, 0.2), 64);
  EXPECT_NEAR(atlas.surface_area, 1, 1e-14);
  EXPECT_NEAR(atlas.texel_area, 64 * 64, 1e-9);
  EXPECT_NEAR(atlas.texel_spacing(), 1.0 / 64, 1e-14);
}

TEST(Atlas, DescribesTheMetricOfATriangle) {
  // A triangle stretched 3 : 1: texel spacing 3 along u and 1 along v.
  Mesh mesh = fixtures::one_triangle();
  mesh.positions[1] *= 3;
  const Surface surface = make_surface(mesh);
  const Atlas atlas = make_atlas(surface, {{16, 16}});
  const TexelMetric metric = texel_metric(surface, atlas, 0);
  EXPECT_NEAR(metric.density, 3.0 / 16 / 16, 1e-14);
  EXPECT_NEAR(metric.stretch, 3, 1e-9);
  EXPECT_NEAR(metric.a, 1.0 / 3, 1e-10);
  EXPECT_NEAR(metric.b, 0, 1e-10);
  EXPECT_NEAR(metric.c, 3, 1e-10);
}

TEST(Atlas, KeepsTheDeterminantOfEveryMetricOne) {
  const Random random(2);
  for (std::uint64_t k = 0; k < 500; ++k) {
    Mesh mesh = fixtures::one_triangle();
    for (int v = 0; v < 3; ++v) {
      mesh.positions[v] = {random.uniform(15 * k + 5 * v, -1, 1),
                           random.uniform(15 * k + 5 * v + 1, -1, 1),
                           random.uniform(15 * k + 5 * v + 2, -1, 1)};
      mesh.uvs[v] = {random.uniform(15 * k + 5 * v + 3, 0, 1),
                     random.uniform(15 * k + 5 * v + 4, 0, 1)};
    }
    if (k % 5 == 0) mesh.uvs[2] = (mesh.uvs[0] + mesh.uvs[1]) / 2 + Vector2(1e-7, 0);
    const Surface surface = make_surface(mesh);
    const Atlas atlas = make_atlas(surface, {{64, 64}});
    if (atlas.chart[0] < 0) continue;
    const TexelMetric m = texel_metric(surface, atlas, 0);
    EXPECT_NEAR((m.a * m.c - m.b * m.b) / (1 + m.a * m.c), 1 / (1 + m.a * m.c), 1e-6) << k;
    EXPECT_GT(m.a, 0);
    EXPECT_LE(m.a + m.c, 1.01 * (max_stretch + 1));
  }
}

TEST(Atlas, ListsTrianglesWithoutTextureCoordinates) {
  Mesh mesh = fixtures::flat_square(3);
  mesh.corner_uvs[4][1] = -1;
  mesh.corner_uvs[7] = {-1, -1, -1};
  const Atlas atlas = atlas_of(mesh);
  EXPECT_EQ(ids(atlas, "triangles_without_uv"), (std::vector<std::int64_t>{4, 7}));
  EXPECT_EQ(atlas.chart[4], -1);
  EXPECT_FALSE(refused(atlas.defects));
}

TEST(Atlas, RefusesCoordinatesThatAreNotFinite) {
  for (double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Mesh mesh = fixtures::flat_square(3);
    mesh.uvs[0].x() = bad;  // of triangles 0 and 1
    const Atlas atlas = atlas_of(mesh);
    EXPECT_EQ(ids(atlas, "uv_not_finite"), (std::vector<std::int64_t>{0, 1}));
    EXPECT_TRUE(refused(atlas.defects));
  }
}

TEST(Atlas, RefusesCoordinatesAbsurdlyFarAway) {
  for (double far : {1e4, -1e30}) {
    Mesh mesh = fixtures::flat_square(3);
    mesh.uvs[0].y() = far;
    const Atlas atlas = atlas_of(mesh);
    EXPECT_EQ(ids(atlas, "uv_far_away"), (std::vector<std::int64_t>{0, 1}));
    EXPECT_TRUE(refused(atlas.defects));
  }
}

TEST(Atlas, TakesWholeTilesOff) {
  Mesh mesh = fixtures::flat_square(3);
  for (Vector2& uv : mesh.uvs) uv += Vector2(-3, 7);
  const Atlas atlas = atlas_of(mesh), home = atlas_of(fixtures::flat_square(3));
  EXPECT_NE(find(atlas, "charts_in_other_tiles"), nullptr);
  for (int t = 0; t < 18; ++t)
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(atlas.corners[t][k].column(), home.corners[t][k].column(), 1e-9);
      EXPECT_NEAR(atlas.corners[t][k].row(), home.corners[t][k].row(), 1e-9);
    }
}

TEST(Atlas, RepeatsATextureThatChartsLeaveUnlessTheFileClampsIt) {
  Mesh mesh = fixtures::flat_square(3);
  for (Vector2& uv : mesh.uvs) uv += Vector2(0.25, 0);
  const Surface surface = make_surface(mesh);
  EXPECT_EQ(make_atlas(surface, {{8, 8}}).textures[0].wrap, Wrap::repeat);
  EXPECT_EQ(make_atlas(surface, {{8, 8, Wrap::clamp}}).textures[0].wrap, Wrap::clamp);
  EXPECT_NE(find(make_atlas(surface, {{8, 8}}), "charts_outside"), nullptr);
  EXPECT_EQ(atlas_of(fixtures::flat_square(3)).textures[0].wrap, Wrap::clamp);
}

TEST(Atlas, LeavesOutTrianglesWithoutAreaInTheTexture) {
  Mesh mesh = fixtures::flat_square(3);
  mesh.corner_uvs[5] = {mesh.corner_uvs[5][0], mesh.corner_uvs[5][0], mesh.corner_uvs[5][1]};
  const Atlas atlas = atlas_of(mesh);
  EXPECT_EQ(ids(atlas, "uv_without_area"), (std::vector<std::int64_t>{5}));
  EXPECT_EQ(atlas.chart[5], -1);
}

TEST(Atlas, RefusesFlippedTrianglesOrKeepsThemWhenTold) {
  Mesh mesh = fixtures::flat_square(4);
  mesh.uvs[12] += Vector2(0.3, 0);
  const Surface surface = make_surface(mesh);
  const Atlas atlas = make_atlas(surface, {{32, 32}});
  const Defect* flipped = find(atlas, "flipped_triangles");
  ASSERT_NE(flipped, nullptr);
  EXPECT_EQ(flipped->severity, Defect::Severity::refused);
  EXPECT_GT(flipped->count, 0);
  const Atlas kept = make_atlas(surface, {{32, 32}}, {AtlasOptions::Flipped::keep});
  EXPECT_FALSE(refused(kept.defects));
  EXPECT_NE(find(kept, "flipped_triangles"), nullptr);
}

TEST(Atlas, KeepsAFlippedSliverThatNobodySees) {
  Mesh mesh = fixtures::flat_square(40);
  mesh.uvs[41 * 20 + 20] += Vector2(0.026, 0);  // one inner vertex, a hair over its neighbour
  const Surface surface = make_surface(mesh);
  const Atlas atlas = make_atlas(surface, {{64, 64}});
  const Defect* flipped = find(atlas, "flipped_triangles");
  ASSERT_NE(flipped, nullptr);
  EXPECT_EQ(flipped->severity, Defect::Severity::warning);
  EXPECT_TRUE(refused(make_atlas(surface, {{64, 64}}, {AtlasOptions::Flipped::refuse}).defects));
}

TEST(Atlas, AcceptsMirroredCharts) {
  Mesh mesh = fixtures::flat_square(4);
  for (Vector2& uv : mesh.uvs) uv.x() = 1 - uv.x();
  const Atlas atlas = atlas_of(mesh);
  EXPECT_TRUE(atlas.charts[0].mirrored);
  EXPECT_NE(find(atlas, "mirrored_charts"), nullptr);
  EXPECT_FALSE(refused(atlas.defects));
}

TEST(Atlas, ListsStretchedTriangles) {
  Mesh mesh = fixtures::one_triangle();
  mesh.positions[1] *= 1e6;
  EXPECT_EQ(ids(atlas_of(mesh), "stretched_triangles"), (std::vector<std::int64_t>{0}));
}

TEST(Atlas, RefusesTexturesThatAreMissingOrWithoutSize) {
  const Surface surface = make_surface(fixtures::flat_square(2));
  EXPECT_THROW(make_atlas(surface, {}), InvalidInput);
  EXPECT_THROW(make_atlas(surface, {{0, 4}}), InvalidInput);
  EXPECT_THROW(make_atlas(surface, {{40000, 4}}), InvalidInput);
}

TEST(TexelPoint, PutsTexelCentresOnIntegers) {
  const TexelPoint p = texel_point({2.5 / 8, 1 - 3.5 / 16}, 8, 16);
  EXPECT_EQ(p.x, 2 * TexelPoint::one);
  EXPECT_EQ(p.y, 3 * TexelPoint::one);
}

}  // namespace
}  // namespace mq
