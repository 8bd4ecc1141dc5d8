#include "mq/mesh/coarsen.h"

#include <cmath>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "fixtures.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

/// Of vertices on a regular mesh.
double spacing_of(const Surface& surface) {
  return std::sqrt(2 / std::sqrt(3.0) * surface.area / surface.mesh.vertex_count());
}

std::vector<Surface> surfaces() {
  return {make_surface(fixtures::sphere(5)), make_surface(fixtures::torus(80, 40)),
          make_surface(fixtures::moebius_strip(60)), make_surface(fixtures::nonmanifold_edge()),
          make_surface(fixtures::beside(fixtures::sphere(4), fixtures::torus(30, 16)))};
}

TEST(Coarsen, LeavesAboutAQuarterAtTwiceTheSpacing) {
  for (const Mesh& mesh :
       {fixtures::sphere(5), fixtures::torus(80, 40), fixtures::flat_square(50, 0.2)}) {
    Mesh bare = mesh;
    bare.uvs.clear(), bare.corner_uvs.clear();
    const Surface fine = make_surface(bare);
    const CoarsenedSurface coarse = coarsen(fine, 2 * spacing_of(fine));
    const double share = double(coarse.surface.mesh.vertex_count()) / fine.mesh.vertex_count();
    EXPECT_GT(share, 0.18);
    EXPECT_LT(share, 0.33);
  }
}

TEST(Coarsen, KeepsTheTopology) {
  for (const Surface& fine : surfaces()) {
    const CoarsenedSurface coarse = coarsen(fine, 1e3);
    EXPECT_EQ(coarse.surface.euler_characteristic, fine.euler_characteristic);
    EXPECT_EQ(coarse.surface.components, fine.components);
    EXPECT_EQ(coarse.surface.boundary_edges > 0, fine.boundary_edges > 0);
    EXPECT_TRUE(coarse.surface.defects.empty());
  }
}

TEST(Coarsen, KeepsVerticesWhereTheyAre) {
  for (const Surface& fine : surfaces()) {
    const CoarsenedSurface coarse = coarsen(fine, 2.5 * spacing_of(fine));
    for (int c = 0; c < coarse.surface.mesh.vertex_count(); ++c) {
      EXPECT_EQ(coarse.surface.mesh.positions[c], fine.mesh.positions[coarse.source[c]]);
      const ClosestPoint& place = coarse.places[coarse.source[c]];
      const Triangle& corners = coarse.surface.mesh.triangles[place.triangle];
      for (int k = 0; k < 3; ++k) EXPECT_EQ(place.barycentric[k], corners[k] == c ? 1 : 0);
    }
  }
}

TEST(Coarsen, FindsPlacesCloseBy) {
  const Surface fine = make_surface(fixtures::sphere(5));
  const double spacing = spacing_of(fine);
  const CoarsenedSurface coarse = coarsen(fine, 2 * spacing);
  for (int v = 0; v < fine.mesh.vertex_count(); ++v) {
    const ClosestPoint& place = coarse.places[v];
    ASSERT_GE(place.triangle, 0);
    EXPECT_NEAR(place.barycentric.sum(), 1, 1e-12);
    Vector3 p = Vector3::Zero();
    for (int k = 0; k < 3; ++k)
      p += place.barycentric[k] * coarse.surface.mesh.position(place.triangle, k);
    EXPECT_LE((p - fine.mesh.positions[v]).norm(), 2 * spacing * spacing);  // the bend of a chord
  }
}

TEST(Coarsen, LeavesASurfaceAsItIsWhereItIsCoarseEnough) {
  const Surface fine = make_surface(fixtures::torus(40, 20));
  const CoarsenedSurface same = coarsen(fine, 0.1 * spacing_of(fine));
  EXPECT_EQ(same.surface.mesh.triangles, fine.mesh.triangles);
  EXPECT_EQ(same.surface.mesh.positions, fine.mesh.positions);
}

/// As where triangles are cut evenly in a texture that is stretched over them.
TEST(Coarsen, MakesBetterTrianglesOfSlivers) {
  Mesh mesh = fixtures::flat_square(40);
  for (Vector3& p : mesh.positions) p.x() *= 30;
  const Surface surface = make_surface(mesh);
  const double spacing = std::sqrt(2 / std::sqrt(3.0) * surface.area / mesh.vertex_count());
  const CoarsenedSurface coarse = coarsen(surface, 2 * spacing);
  EXPECT_LT(coarse.surface.mesh.vertex_count(), mesh.vertex_count() / 2);
  EXPECT_NEAR(coarse.surface.area, surface.area, 1e-9 * surface.area);
}

TEST(Coarsen, KeepsASquareASquare) {
  Mesh mesh = fixtures::flat_square(24);
  mesh.uvs.clear(), mesh.corner_uvs.clear();
  const Surface fine = make_surface(mesh);
  const CoarsenedSurface coarse = coarsen(fine, 3 * spacing_of(fine));
  EXPECT_NEAR(coarse.surface.area, 1, 1e-12);
  for (int v = 0; v < mesh.vertex_count(); ++v)
    EXPECT_LE(coarse.places[v].squared_distance, 1e-24) << v;
}

TEST(Coarsen, GivesTheSameForAnyNumberOfThreads) {
  const Surface fine = make_surface(fixtures::torus(80, 40));
  const auto run = [&](int threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return coarsen(fine, 2 * spacing_of(fine));
  };
  const CoarsenedSurface one = run(1), seven = run(7);
  EXPECT_EQ(one.surface.mesh.triangles, seven.surface.mesh.triangles);
  EXPECT_EQ(one.source, seven.source);
  for (std::size_t v = 0; v < one.places.size(); ++v)
    EXPECT_EQ(one.places[v].barycentric, seven.places[v].barycentric);
}

/// One triangle, a tetrahedron, nothing: there is nothing to take away.
TEST(Coarsen, LeavesTheSmallestSurfaces) {
  for (const Mesh& mesh : {fixtures::tetrahedron(), fixtures::nonmanifold_vertex()})
    EXPECT_EQ(coarsen(make_surface(mesh), 1e6).surface.triangle_count(), mesh.triangle_count());
  EXPECT_EQ(coarsen(make_surface(Mesh{}), 1).surface.triangle_count(), 0);
}

TEST(Coarsen, RefusesASpacingThatIsNone) {
  const Surface surface = make_surface(fixtures::sphere(1));
  for (const double spacing : {0.0, -1.0, std::nan("")})
    EXPECT_THROW(coarsen(surface, spacing), InvalidInput);
}

}  // namespace
}  // namespace mq
