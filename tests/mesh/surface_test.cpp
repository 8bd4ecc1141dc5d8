#include "mq/mesh/surface.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <limits>

#include "fixtures.h"
#include "mq/base/error.h"

namespace mq {
namespace {

using namespace fixtures;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Ids = std::vector<std::int64_t>;

Surface with_distance(const Mesh& mesh, double distance) {
  return make_surface(mesh, {WeldOptions::Kind::distance, distance});
}

std::int64_t count(const Surface& surface, const char* kind) {
  return defect(surface.defects, kind).count;
}
Ids ids(const Surface& surface, const char* kind) { return defect(surface.defects, kind).ids; }

/// What must hold of any surface, however bad its mesh was.
void expect_consistent(const Surface& s) {
  const auto from = [&](HalfEdge h) { return s.mesh.triangles[h / 3][h % 3]; };
  const auto next = [](HalfEdge h) { return h % 3 == 2 ? h - 2 : h + 1; };
  ASSERT_EQ(s.twins.size(), 3 * s.mesh.triangles.size());
  ASSERT_EQ(s.source_from_vertex.size(), s.mesh.positions.size());
  int boundary = 0;
  std::vector<int> fans(s.mesh.positions.size());
  for (HalfEdge h = 0; h < HalfEdge(s.twins.size()); ++h) {
    const HalfEdge twin = s.twins[h];
    ASSERT_TRUE(from(h) >= 0 && from(h) < s.mesh.vertex_count());
    const bool collapsed = from(h) == from(next(h)) || from(h) == from(next(next(h))) ||
                           from(next(h)) == from(next(next(h)));
    if (twin < 0 && !collapsed) {
      ++boundary;
      ++fans[from(h)];
    }
    if (twin < 0) continue;
    ASSERT_EQ(s.twins[twin], h);
    ASSERT_EQ(from(twin), from(next(h)));
    ASSERT_EQ(from(next(twin)), from(h));
  }
  EXPECT_EQ(boundary, s.boundary_edges);
  for (const int f : fans) ASSERT_LE(f, 1);  // at most one fan that is open
  for (const Defect& d : s.defects) {
    EXPECT_EQ(std::ssize(d.ids), std::min<std::int64_t>(d.count, Defect::max_ids));
    EXPECT_FALSE(d.message.empty());
  }
}

TEST(Surface, LeavesAGoodMeshAsItIs) {
  const Mesh mesh = flat_square(4, 0.2);
  const Surface s = make_surface(mesh);
  expect_consistent(s);
  EXPECT_TRUE(s.defects.empty());
  EXPECT_EQ(s.mesh.triangles, mesh.triangles);
  EXPECT_EQ(s.mesh.positions, mesh.positions);
  EXPECT_EQ(s.mesh.corner_uvs, mesh.corner_uvs);
  EXPECT_EQ(s.components, 1);
  EXPECT_EQ(s.boundary_edges, 16);
  EXPECT_EQ(s.euler_characteristic, 1);
  EXPECT_NEAR(s.area, 1, 1e-15);
}

TEST(Surface, CountsHandlesAndComponents) {
  EXPECT_EQ(make_surface(tetrahedron()).euler_characteristic, 2);
  EXPECT_EQ(make_surface(torus(7, 5)).euler_characteristic, 0);
  const Surface both = make_surface(beside(torus(7, 5), sphere(2)));
  EXPECT_EQ(both.components, 2);
  EXPECT_EQ(both.boundary_edges, 0);
  EXPECT_EQ(both.euler_characteristic, 2);
}

TEST(Surface, JoinsVerticesThatExportersSplitAtSeams) {
  const Surface s = make_surface(split_two_chart_quad());
  expect_consistent(s);
  EXPECT_EQ(s.mesh.vertex_count(), 4);
  EXPECT_EQ(s.twins[2], 3);
  EXPECT_THAT(ids(s, "welded_vertices"), ElementsAre(4, 5));
  EXPECT_EQ(s.vertex_from_source, (std::vector<int>{0, 1, 2, 3, 0, 2}));
  const Surface apart = make_surface(split_two_chart_quad(), {WeldOptions::Kind::none});
  EXPECT_EQ(apart.components, 2);
  EXPECT_TRUE(apart.defects.empty());
}

TEST(Surface, TakesZerosOfEitherSignAsEqual) {
  Mesh mesh = split_two_chart_quad();
  mesh.positions[4] = {-0.0, 0.0, -0.0};
  EXPECT_EQ(make_surface(mesh).components, 1);
}

TEST(Surface, PutsATriangleSoupTogether) {
  const Mesh whole = torus(40, 30);
  const Surface s = make_surface(triangle_soup(whole));
  expect_consistent(s);
  EXPECT_EQ(s.mesh.vertex_count(), whole.vertex_count());
  EXPECT_EQ(s.boundary_edges, 0);
  EXPECT_EQ(s.euler_characteristic, 0);
}

TEST(Surface, WeldsByDistanceWhatExactWeldingMisses) {
  Mesh mesh = triangle_soup(sphere(3));
  const Random random(3);
  for (int v = 0; v < mesh.vertex_count(); ++v)
    for (int k = 0; k < 3; ++k)
      mesh.positions[v][k] += random.uniform(std::uint64_t(3 * v + k), -1e-6, 1e-6);
  EXPECT_EQ(make_surface(mesh).components, 256);
  const Surface s = with_distance(mesh, 1e-5);
  expect_consistent(s);
  EXPECT_EQ(s.euler_characteristic, 2);
  EXPECT_EQ(s.components, 1);
  EXPECT_EQ(count(s, "triangles_collapsed_by_weld"), 0);
}

TEST(Surface, WeldsExactlyThePairsThatAreCloser) {
  // A chain of points 1 apart and points 1.001 apart, across cells and in all directions.
  const Random random(5);
  for (std::uint64_t trial = 0; trial < 200; ++trial) {
    const Vector3 offset(random.uniform(6 * trial, -9, 9), random.uniform(6 * trial + 1, -9, 9),
                         random.uniform(6 * trial + 2, -9, 9));
    const Vector3 direction =
        Vector3(random.uniform(6 * trial + 3, -1, 1), random.uniform(6 * trial + 4, -1, 1), 0.3)
            .normalized();
    Mesh mesh;
    mesh.positions = {offset, offset + 10 * Vector3::UnitX(), offset + 10 * Vector3::UnitY(),
                      offset + 0.999 * direction};
    mesh.triangles = {{0, 1, 2}, {3, 2, 1}};
    EXPECT_EQ(with_distance(mesh, 1).mesh.vertex_count(), 3);
    EXPECT_EQ(with_distance(mesh, 0.998).mesh.vertex_count(), 4);
  }
}

TEST(Surface, SaysWhatAWeldDestroys) {
  const Surface s = with_distance(flat_square(4), 0.26);
  EXPECT_EQ(count(s, "triangles_collapsed_by_weld"), 32);
  EXPECT_EQ(count(s, "welded_vertices"), 24);
  EXPECT_EQ(s.area, 0);
}

TEST(Surface, WeldsADistanceThatSwallowsTheMeshQuickly) {
  EXPECT_EQ(with_distance(flat_square(300), 100).mesh.vertex_count(), 1);
}

TEST(Surface, SplitsAVertexIntoItsFans) {
  const Surface s = make_surface(nonmanifold_vertex());
  expect_consistent(s);
  EXPECT_EQ(s.mesh.vertex_count(), 6);
  EXPECT_EQ(s.euler_characteristic, 2);
  EXPECT_EQ(s.source_from_vertex[s.mesh.triangles[0][0]], 0);
  EXPECT_EQ(s.source_from_vertex[s.mesh.triangles[1][0]], 0);
  EXPECT_THAT(ids(s, "nonmanifold_vertices"), ElementsAre(0));
}

TEST(Surface, CutsAnEdgeOfThreeTriangles) {
  const Surface s = make_surface(nonmanifold_edge());
  expect_consistent(s);
  EXPECT_EQ(s.components, 3);
  EXPECT_EQ(s.boundary_edges, 9);
  EXPECT_THAT(ids(s, "nonmanifold_edges"), ElementsAre(0));
  EXPECT_THAT(ids(s, "nonmanifold_vertices"), ElementsAre(0, 1));
}

TEST(Surface, KeepsWholeWhatTheFileHoldsApart) {
  // Two tetrahedra with vertices of their own that share an edge in space.
  Mesh other = tetrahedron();
  for (Vector3& p : other.positions) p = Vector3(2 - p.x(), -p.z(), -p.y());  // half a turn
  const Surface s = make_surface(beside(tetrahedron(), other));
  expect_consistent(s);
  EXPECT_EQ(s.components, 2);
  EXPECT_EQ(s.boundary_edges, 0);
  EXPECT_EQ(s.euler_characteristic, 4);
  EXPECT_EQ(count(s, "touching_edges"), 1);
  EXPECT_EQ(count(s, "nonmanifold_vertices"), 0);
}

TEST(Surface, CutsWhereOrientationIsInconsistent) {
  Mesh mesh = flat_square(1);
  std::swap(mesh.triangles[1][0], mesh.triangles[1][1]);
  const Surface s = make_surface(mesh);
  expect_consistent(s);
  EXPECT_EQ(s.components, 2);
  EXPECT_THAT(ids(s, "inconsistent_edges"), ElementsAre(2));
  const Surface strip = make_surface(moebius_strip(20));
  expect_consistent(strip);
  EXPECT_EQ(count(strip, "inconsistent_edges"), 1);
  EXPECT_EQ(strip.components, 1);
  EXPECT_EQ(strip.euler_characteristic, 1);  // cut open it is a disc
}

TEST(Surface, ListsTrianglesWithoutArea) {
  Mesh mesh = flat_square(1);
  mesh.triangles.push_back({0, 0, 1});         // two equal vertices
  mesh.positions.emplace_back(0.1, 0.1, 0.1);  // collinear with rounded coordinates
  mesh.positions.emplace_back(0.2, 0.2, 0.2);
  mesh.positions.emplace_back(0.7, 0.7, 0.7);
  mesh.triangles.push_back({4, 5, 6});
  mesh.positions.emplace_back(0.4, 0.4 + 1e-12, 0.4);  // thin, but with area
  mesh.triangles.push_back({4, 7, 6});
  mesh.corner_uvs.resize(mesh.triangles.size(), {0, 0, 0});
  const Surface s = make_surface(mesh);
  expect_consistent(s);
  EXPECT_THAT(ids(s, "degenerate_triangles"), ElementsAre(2, 3));
  EXPECT_THAT(s.degenerate, ElementsAre(0, 0, 1, 1, 0));
  EXPECT_GT(s.area, 1);
}

TEST(Surface, HasAreaAtAnySize) {
  for (const double scale : {1e-100, 1e-30, 1e50}) {
    Mesh mesh = flat_square(3, 0.2);
    for (Vector3& p : mesh.positions) p *= scale;
    const Surface s = make_surface(mesh);
    EXPECT_TRUE(s.defects.empty()) << scale;
    EXPECT_NEAR(s.area / scale / scale, 1, 1e-14) << scale;
  }
}

TEST(Surface, ClosesTheGapOfACollapsedTriangle) {
  // Where a sliver was collapsed to an edge (0, 1), its neighbours become each other's.
  Mesh mesh = flat_square(1);
  mesh.triangles = {{0, 1, 2}, {2, 1, 1}, {1, 3, 2}};
  mesh.corner_uvs = mesh.triangles;
  const Surface s = make_surface(mesh);
  expect_consistent(s);
  EXPECT_EQ(s.twins[1], 8);
  EXPECT_EQ(s.components, 1);
  EXPECT_EQ(s.boundary_edges, 4);
  EXPECT_EQ(s.euler_characteristic, 1);
}

TEST(Surface, LetsADuplicateStandAlone) {
  Mesh mesh = torus(6, 5);
  mesh.triangles.push_back({mesh.triangles[7][1], mesh.triangles[7][2], mesh.triangles[7][0]});
  const Surface s = make_surface(mesh);
  expect_consistent(s);
  EXPECT_THAT(ids(s, "duplicate_triangles"), ElementsAre(60));
  EXPECT_EQ(s.components, 2);
  EXPECT_EQ(s.boundary_edges, 3);
  EXPECT_EQ(count(s, "nonmanifold_edges"), 0);
  EXPECT_EQ(count(s, "nonmanifold_vertices"), 0);
}

TEST(Surface, KeepsTheLayersOfATwoSidedSheetWhole) {
  Mesh mesh = flat_square(4);
  const std::vector<Triangle> front = mesh.triangles;
  for (const auto& [a, b, c] : front) mesh.triangles.push_back({a, c, b});
  mesh.corner_uvs = mesh.triangles;
  const Surface s = make_surface(mesh);
  expect_consistent(s);
  EXPECT_EQ(count(s, "two_sided_triangles"), 32);
  EXPECT_EQ(s.boundary_edges, 0);  // front and back meet at the rim
  EXPECT_EQ(s.components, 1);
  EXPECT_EQ(s.euler_characteristic, 2);
}

TEST(Surface, DropsVerticesThatNothingUses) {
  Mesh mesh = one_triangle();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  mesh.positions.insert(mesh.positions.begin() + 1, Vector3(nan, 0, 0));
  mesh.triangles = {{0, 2, 3}};
  const Surface s = make_surface(mesh);
  EXPECT_EQ(s.vertex_from_source, (std::vector<int>{0, -1, 1, 2}));
  EXPECT_THAT(ids(s, "unreferenced_vertices"), ElementsAre(1));
}

TEST(Surface, IsEmptyForAnEmptyMesh) {
  const Surface s = make_surface({});
  EXPECT_EQ(s.components, 0);
  EXPECT_EQ(s.area, 0);
  EXPECT_TRUE(s.defects.empty());
}

TEST(Surface, RefusesWhatIsNotAMesh) {
  const auto error_of = [](const Mesh& mesh, const WeldOptions& weld = {}) {
    return fixtures::error_of([&] { make_surface(mesh, weld); });
  };
  Mesh mesh = flat_square(2);
  mesh.triangles[3][1] = 9;
  EXPECT_THAT(error_of(mesh), HasSubstr("1 triangle (first: 3) with vertices that are not there: there are 9"));
  mesh = flat_square(2);
  mesh.corner_uvs[1][0] = -2;
  EXPECT_THAT(error_of(mesh), HasSubstr("texture coordinates that are not there"));
  mesh = flat_square(2);
  mesh.corner_uvs.pop_back();
  EXPECT_THAT(error_of(mesh), HasSubstr("there are 8 triangles, but 7 of them have"));
  mesh = flat_square(2);
  mesh.positions[4].y() = std::numeric_limits<double>::infinity();
  EXPECT_THAT(error_of(mesh), HasSubstr("1 vertex with positions that are not finite numbers (first, from 0: 4)"));
  mesh.positions[4].y() = 1e300;
  EXPECT_THAT(error_of(mesh), HasSubstr("scale the model down"));
  EXPECT_THAT(error_of(flat_square(2), {WeldOptions::Kind::distance, 0}),
              HasSubstr("must be a positive number"));
}

TEST(Surface, StaysConsistentOnTrianglesAtRandom) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const Random random(seed);
    Mesh mesh;
    for (std::uint64_t v = 0; v < 12; ++v)  // few positions, so that many vertices coincide
      mesh.positions.emplace_back(std::floor(random.uniform(3 * v, 0, 2)),
                                  std::floor(random.uniform(3 * v + 1, 0, 2)),
                                  std::floor(random.uniform(3 * v + 2, 0, 3)));
    for (std::uint64_t t = 0; t < 60; ++t) {
      Triangle triangle;
      for (std::uint64_t k = 0; k < 3; ++k)
        triangle[k] = int(random.uniform(100 + 3 * t + k, 0, 12));
      mesh.triangles.push_back(triangle);
    }
    expect_consistent(make_surface(mesh));
    expect_consistent(make_surface(mesh, {WeldOptions::Kind::none}));
    expect_consistent(with_distance(mesh, 1.1));
  }
}

TEST(Surface, DoesNotDependOnTheNumberOfThreads) {
  const Mesh mesh = triangle_soup(torus(120, 100));
  const Surface one = [&] {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    return make_surface(mesh);
  }();
  for (const std::size_t threads : {2, 7}) {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const Surface s = make_surface(mesh);
    EXPECT_EQ(s.twins, one.twins);
    EXPECT_EQ(s.mesh.triangles, one.mesh.triangles);
    EXPECT_EQ(s.area, one.area);
  }
}

}  // namespace
}  // namespace mq
