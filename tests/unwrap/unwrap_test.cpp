#include "mq/unwrap/unwrap.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "fixtures.h"
#include "mq/atlas/atlas.h"
#include "mq/atlas/coverage.h"
#include "mq/base/error.h"
#include "mq/sample/sample.h"
#include "mq/unwrap/detail/chart_surface.h"
#include "mq/unwrap/detail/parametrize.h"

namespace mq {
namespace {

constexpr UnwrapOptions quick{.width = 512, .height = 512, .trials = 3};

Surface sample_surface(const std::string& name, int triangles) {
  return make_surface(make_sample(name, {.texture_size = 64, .triangles = triangles}).mesh);
}

/// The mesh with the atlas, read again by the program's own reader of atlases.
struct Reread {
  Surface surface;
  Atlas atlas;
  std::int64_t overlapping = 0;  // texels
};

Reread reread(Surface surface, const Unwrapped& unwrapped, const UnwrapOptions& options) {
  surface.mesh.uvs = unwrapped.uvs;
  surface.mesh.corner_uvs = unwrapped.corner_uvs;
  surface.mesh.textures.clear();
  Reread result{surface, make_atlas(surface, {{options.width, options.height}}, {}), 0};
  for (const Coverage& coverage : texel_coverage(result.surface, result.atlas))
    for (const int count : coverage.count.values()) result.overlapping += count > 1;
  return result;
}

void expect_injective(const Surface& surface, const Unwrapped& unwrapped,
                      const UnwrapOptions& options) {
  EXPECT_EQ(unwrapped.figures.stretch.flipped, 0);
  EXPECT_EQ(unwrapped.figures.overlapping, 0);
  ASSERT_EQ(unwrapped.corner_uvs.size(), surface.mesh.triangles.size());
  for (const Vector2& uv : unwrapped.uvs) {
    EXPECT_GE(uv.minCoeff(), 0);
    EXPECT_LE(uv.maxCoeff(), 1);
  }
  const Reread again = reread(surface, unwrapped, options);
  EXPECT_EQ(again.overlapping, 0);
  EXPECT_FALSE(refused(again.atlas.defects));
  EXPECT_LE(int(again.atlas.charts.size()), unwrapped.figures.charts);  // some may have no area
  for (const Chart& chart : again.atlas.charts) EXPECT_FALSE(chart.mirrored);
}

TEST(Unwrap, MakesAFewInjectiveChartsOfAnyTopology) {
  for (const char* name : {"sphere", "torus", "genus4", "cylinder", "bust"}) {
    SCOPED_TRACE(name);
    const Surface surface = sample_surface(name, 3000);
    const Unwrapped unwrapped = unwrap(surface, quick);
    expect_injective(surface, unwrapped, quick);
    EXPECT_LE(unwrapped.figures.charts, 40);
    EXPECT_LT(unwrapped.figures.stretch.l2_stretch, quick.stretch);
  }
}

TEST(Unwrap, IsIsometricWhereTheSurfaceIsDevelopable) {
  const Unwrapped cylinder = unwrap(sample_surface("cylinder", 800), quick);
  EXPECT_NEAR(cylinder.figures.stretch.l2_stretch, 1, 1e-6);
  for (const TriangleStretch& t : cylinder.figures.stretch.triangles) EXPECT_NEAR(t.ratio, 1, 1e-3);
  // Corners of a cube are no part of a plane: with next to no stretch allowed they are cut.
  UnwrapOptions strict = quick;
  strict.stretch = 1.0001;
  const Unwrapped cube = unwrap(sample_surface("cube", 800), strict);
  EXPECT_LT(cube.figures.stretch.l2_stretch, 1.0001);
  for (const TriangleStretch& t : cube.figures.stretch.triangles) EXPECT_NEAR(t.ratio, 1, 0.05);
}

TEST(Unwrap, IsTheSameForEveryUnitOfLength) {
  const Surface surface = sample_surface("bust", 1500);
  const Unwrapped unwrapped = unwrap(surface, quick);
  for (const double scale : {100.0, 1e-3}) {
    Mesh mesh = surface.mesh;
    for (Vector3& p : mesh.positions) p *= scale;
    const Unwrapped other = unwrap(make_surface(mesh), quick);
    EXPECT_EQ(other.chart, unwrapped.chart);
    EXPECT_EQ(other.corner_uvs, unwrapped.corner_uvs);
    EXPECT_EQ(other.uvs, unwrapped.uvs);
  }
}

TEST(Unwrap, IsTheSameForAnyNumberOfThreads) {
  const Surface surface = sample_surface("genus4", 2500);
  const auto with_threads = [&](int threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism,
                                      std::size_t(threads));
    return unwrap(surface, quick);
  };
  const Unwrapped one = with_threads(1);
  for (const int threads : {2, 7}) {
    const Unwrapped more = with_threads(threads);
    EXPECT_EQ(more.corner_uvs, one.corner_uvs);
    EXPECT_EQ(more.uvs, one.uvs);
  }
}

TEST(Unwrap, KeepsTheBoundOnStretch) {
  const Surface surface = sample_surface("sphere", 2000);
  int before = 0;
  for (const double stretch : {1.3, 1.05, 1.005}) {
    const Unwrapped unwrapped =
        unwrap(surface, {.width = 256, .height = 256, .stretch = stretch, .trials = 2});
    EXPECT_LE(unwrapped.figures.stretch.l2_stretch, stretch);
    EXPECT_GE(unwrapped.figures.charts, before);
    before = unwrapped.figures.charts;
  }
}

TEST(Unwrap, CopesWithWhatScansBring) {
  // A square with a triangle written twice, one with two equal vertices, one that is a line, a
  // third face at an edge, a vertex nobody uses, and another square far away.
  Mesh mesh = fixtures::flat_square(4);
  mesh.uvs.clear();
  mesh.corner_uvs.clear();
  const int count = mesh.vertex_count();
  mesh.triangles.push_back(mesh.triangles[3]);
  mesh.triangles.push_back({0, 0, 1});
  mesh.triangles.push_back({0, 1, 2});
  mesh.positions.push_back({0.1, 0.2, 1});
  mesh.triangles.push_back({0, 1, count});
  mesh.positions.push_back({5, 5, 5});
  const int base = mesh.vertex_count();
  for (const Vector3& p : {Vector3(9, 0, 0), Vector3(10, 0, 0), Vector3(9, 1, 0)})
    mesh.positions.push_back(p);
  mesh.triangles.push_back({base, base + 1, base + 2});
  const Surface surface = make_surface(mesh);
  const Unwrapped unwrapped = unwrap(surface, quick);
  expect_injective(surface, unwrapped, quick);
  EXPECT_NEAR(unwrapped.figures.stretch.l2_stretch, 1, 1e-6);
  for (const Triangle& corners : unwrapped.corner_uvs)
    for (const int uv : corners) {
      EXPECT_GE(uv, 0);
      EXPECT_LT(uv, int(unwrapped.uvs.size()));
    }
}

TEST(Unwrap, RefusesASurfaceWithoutArea) {
  Mesh mesh = fixtures::one_triangle();
  mesh.positions[2] = {0.5, 0, 0};
  EXPECT_THROW(unwrap(make_surface(mesh)), InvalidInput);
  // Nor one whose area underflows.
  Mesh tiny = fixtures::one_triangle();
  for (Vector3& p : tiny.positions) p *= 1e-160;
  EXPECT_THROW(unwrap(make_surface(tiny, {.kind = WeldOptions::Kind::none})), InvalidInput);
}

/// A strip of squares, `length` of them of side 1, in the plane.
Surface strip(int length) {
  Mesh mesh;
  for (int i = 0; i <= length; ++i) {
    mesh.positions.push_back({double(i), 0, 0});
    mesh.positions.push_back({double(i), 1, 0});
  }
  for (int i = 0; i < length; ++i) {
    mesh.triangles.push_back({2 * i, 2 * i + 2, 2 * i + 3});
    mesh.triangles.push_back({2 * i, 2 * i + 3, 2 * i + 1});
  }
  return make_surface(mesh);
}

TEST(Unwrap, CutsWhatIsLongerThanTheTexture) {
  const Surface surface = strip(3000);
  const Unwrapped atlas = unwrap(surface, quick);
  expect_injective(surface, atlas, quick);
  // In one piece the strip would fill a three-thousandth.
  EXPECT_GT(atlas.figures.stretch.occupancy, 0.3);
  UnwrapOptions whole = quick;
  whole.largest = 1;
  EXPECT_EQ(unwrap(strip(20), whole).figures.charts, 1);
  EXPECT_GT(unwrap(strip(20), quick).figures.charts, 4);
}

// ---- Parts ----

Sheet whole(const Surface& surface) {
  std::vector<int> triangles;
  for (int t = 0; t < surface.triangle_count(); ++t) triangles.push_back(t);
  std::vector<char> merged;
  for (const HalfEdge twin : surface.twins) merged.push_back(twin >= 0);
  return make_sheet(surface, triangles, merged);
}

TEST(Parametrize, FindsTheIsometryOfABentSheet) {
  Mesh mesh = fixtures::flat_square(12, 0.2);
  for (Vector3& p : mesh.positions) p = {std::sin(p.x()), p.y(), std::cos(p.x())};
  const Sheet sheet = whole(make_surface(mesh));
  const Points x = parametrize(sheet, {.iterations = 30, .tolerance = 1e-12});
  ASSERT_FALSE(x.empty());
  // Each strip of cells is bent in x only between columns of jittered vertices: nearly developable.
  EXPECT_LT(isometric_energy(sheet, x), 2e-5);
  EXPECT_NEAR(l2_stretch(sheet, x), 1, 1e-5);
}

/// The weights of [rabinovich2017scalable] are those with which a step from a stretch σ is 1 − σ in its direction: from a
/// map that is linear the first step ends at an isometry.
TEST(Parametrize, OneStepMakesALinearMapIsometric) {
  const Mesh mesh = fixtures::flat_square(5, 0.2);
  const Sheet sheet = whole(make_surface(mesh));
  const auto turn = [](double angle) {
    return (Eigen::Matrix2d() << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle)).finished();
  };
  const Eigen::Matrix2d J = turn(0.7) * Eigen::Vector2d(3, 0.4).asDiagonal() * turn(-0.3);
  Points x(std::size_t(sheet.vertex_count));
  for (std::size_t t = 0; t < sheet.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k)
      x[std::size_t(sheet.triangles[t][std::size_t(k)])] =
          J * mesh.positions[std::size_t(mesh.triangles[std::size_t(sheet.sources[t])][std::size_t(k)])].head<2>();
  ASSERT_GT(isometric_energy(sheet, x), 4);
  EXPECT_LT(isometric_energy(sheet, lower_energy(sheet, x, {.iterations = 1})), 1e-10);
}

TEST(Parametrize, EnergyIsTheOneOfTheSingularValues) {
  const Sheet sheet = whole(make_surface(fixtures::flat_square(3)));
  const Surface surface = make_surface(fixtures::flat_square(3));
  Points x(std::size_t(sheet.vertex_count));
  for (std::size_t t = 0; t < sheet.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Vector3& p = surface.mesh.position(sheet.sources[t], k);
      x[std::size_t(sheet.triangles[t][k])] = {2 * p.x(), 0.5 * p.y()};
    }
  const double s = 2, r = 0.5;
  EXPECT_NEAR(isometric_energy(sheet, x), 0.5 * (s * s + r * r + 1 / (s * s) + 1 / (r * r)) - 2,
              1e-12);
  EXPECT_NEAR(l2_stretch(sheet, x), std::sqrt(0.5 * (1 / (s * s) + 1 / (r * r)) * s * r), 1e-12);
  std::swap(x[0].x(), x[1].x());
  std::swap(x[0].y(), x[1].y());
  EXPECT_EQ(isometric_energy(sheet, x), std::numeric_limits<double>::infinity());
}

TEST(Parametrize, TuttesEmbeddingHasNoFold) {
  Mesh mesh = fixtures::flat_square(10, 0.24);
  for (Vector3& p : mesh.positions)
    p.z() = 3 * std::exp(-8 * ((p.x() - 0.5) * (p.x() - 0.5) + p.y() * p.y()));
  const Sheet sheet = whole(make_surface(mesh));
  ASSERT_TRUE(sheet.is_disc());
  const Points x = tutte_embedding(sheet);
  EXPECT_TRUE(std::isfinite(isometric_energy(sheet, x)));
  EXPECT_FALSE(boundary_crosses(sheet, x));
  const double before = isometric_energy(sheet, x);
  const Points y = lower_energy(sheet, x);
  EXPECT_LT(isometric_energy(sheet, y), before);
}

TEST(Parametrize, SeesThatALoopInsideAnotherIsCoveredTwice) {
  // Two triangles that are one sheet in name only: both counter-clockwise, one inside the other.
  Mesh mesh = fixtures::beside(fixtures::one_triangle(), fixtures::one_triangle());
  mesh.corner_uvs.clear();
  const Sheet sheet = whole(make_surface(mesh, {WeldOptions::Kind::none}));
  ASSERT_EQ(sheet.loops.size(), 2U);
  const Points x{{0, 0}, {10, 0}, {0, 10}, {1, 1}, {2, 1}, {1, 2}};
  EXPECT_FALSE(boundary_crosses(sheet, x));
  EXPECT_FALSE(is_injective(sheet, x));
}

TEST(Charts, AreDiscsThatCoverEverythingOnce) {
  const Surface surface = sample_surface("genus4", 3000);
  const ChartHistory history = find_charts(surface);
  std::vector<int> step_of;
  const ChartMerging merging = replay(surface, history, {}, step_of);
  std::vector<int> covered(std::size_t(surface.triangle_count()));
  for (int c = 0; c < merging.chart_count(); ++c) {
    if (!merging.is_whole(c) || merging.triangles(c).empty()) continue;
    const Sheet sheet = make_sheet(surface, merging.triangles(c), merging.merged());
    // With h holes V − E + T = 1 − h: planar, whatever the handles of the surface.
    const auto loops = std::ssize(sheet.loops);
    EXPECT_GE(loops, 1);
    std::int64_t boundary = 0;
    for (const auto& loop : sheet.loops) boundary += std::ssize(loop);
    const auto triangles = std::ssize(sheet.triangles);
    EXPECT_EQ(2 * sheet.vertex_count - (3 * triangles + boundary) + 2 * triangles, 2 * (2 - loops));
    for (const int t : merging.triangles(c)) ++covered[std::size_t(t)];
  }
  EXPECT_EQ(std::ranges::count(covered, 1), surface.triangle_count());
}

TEST(Charts, OfTrianglesWithoutAreaAreMadeToo) {
  // Six vertices on a line, as two opposite strips: a closed surface that encloses nothing.
  Mesh mesh;
  for (int i = 0; i < 6; ++i) mesh.positions.push_back({0.1 * i, 0, 0});
  for (int i = 0; i + 2 < 6; ++i) {
    mesh.triangles.push_back({i, i + 1 + i % 2, i + 2 - i % 2});
    mesh.triangles.push_back({i, i + 2 - i % 2, i + 1 + i % 2});
  }
  const Surface surface = make_surface(mesh);
  EXPECT_EQ(surface.area, 0);
  const ChartHistory history = find_charts(surface, {});
  std::vector<int> size(history.patches.count);
  for (const int patch : history.patches.patch)
    if (patch >= 0) ++size[patch];
  EXPECT_EQ(std::ranges::count(size, 0), 0);
}

TEST(Charts, GluingsThatAreRefusedAreLeftOut) {
  const Surface surface = sample_surface("sphere", 1500);
  const ChartHistory history = find_charts(surface);
  std::vector<int> step_of;
  const ChartMerging all = replay(surface, history, {}, step_of);
  const ChartMerging none =
      replay(surface, history, std::vector<char>(history.steps.size(), 1), step_of);
  EXPECT_EQ(none.chart_count(), history.patches.count);
  EXPECT_GT(all.chart_count(), none.chart_count());
}

}  // namespace
}  // namespace mq
