#include "mq/mesh/refine.h"

#include <gtest/gtest.h>

#include "fixtures.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

using namespace fixtures;

LineLength in_space(const Surface& surface) {
  return [&surface](int t, const Vector2& from, const Vector2& to) {
    const Mesh& m = surface.mesh;
    const Vector2 d = to - from;
    return (d[0] * (m.position(t, 1) - m.position(t, 0)) +
            d[1] * (m.position(t, 2) - m.position(t, 0)))
        .norm();
  };
}

std::vector<char> all(const Surface& surface) {
  return std::vector<char>(surface.degenerate.size(), 1);
}

TEST(Refine, KeepsTheSurfaceAndHalvesLongEdges) {
  for (const Mesh& mesh : {torus(7, 5), flat_square(3, 0.2), sphere(2), moebius_strip(9)}) {
    const Surface surface = make_surface(mesh);
    const RefinedSurface fine = refine(surface, all(surface), in_space(surface), 0.06);
    const Surface& s = fine.surface;
    EXPECT_GT(s.triangle_count(), 4 * surface.triangle_count());
    double area = 0;
    for (int t = 0; t < s.triangle_count(); ++t) {
      area += triangle_area(s.mesh, t);
      for (int k = 0; k < 3; ++k) {
        const Vector3& p = s.mesh.position(t, k);
        EXPECT_LE((p - s.mesh.position(t, (k + 1) % 3)).norm(), 0.06);
        // Where it says it lies in its source.
        const Vector3 b = fine.in_source(t, Vector3::Unit(k));
        Vector3 q = Vector3::Zero();
        for (int i = 0; i < 3; ++i) q += b[i] * surface.mesh.position(fine.source[t], i);
        EXPECT_LT((p - q).norm(), 1e-14);
      }
    }
    EXPECT_NEAR(area, surface.area, 1e-12 * area);
    // The same surface as the points and triangles alone would give.
    const Surface again = make_surface(s.mesh, {WeldOptions::Kind::none});
    EXPECT_EQ(again.twins, s.twins);
    EXPECT_EQ(again.components, surface.components);
    EXPECT_EQ(again.euler_characteristic, surface.euler_characteristic);
  }
}

TEST(Refine, LeavesShortEdgesAndTakesOnlyWhatIsKept) {
  const Surface surface = make_surface(flat_square(2));
  const RefinedSurface same = refine(surface, all(surface), in_space(surface), 10);
  EXPECT_EQ(same.surface.mesh.triangles, surface.mesh.triangles);
  EXPECT_EQ(same.surface.twins, surface.twins);
  std::vector<char> half = all(surface);
  std::fill(half.begin() + 4, half.end(), 0);
  const RefinedSurface part = refine(surface, half, in_space(surface), 0.3);
  EXPECT_NEAR(part.surface.area, 0.5, 1e-15);
  for (const int t : part.source) EXPECT_LT(t, 4);
  EXPECT_THROW(refine(surface, half, in_space(surface), 0), InvalidInput);
  EXPECT_THROW(refine(surface, {}, in_space(surface), 1), InvalidInput);
}

TEST(RefinedMesh, KeepsTextureCoordinatesWhereTheyWere) {
  Mesh mesh = flat_square(2);
  mesh.uvs.clear();
  mesh.corner_uvs.clear();
  const auto uv_at = [](const Vector3& p) {
    return Vector2(0.1 + 0.5 * p.x() - 0.2 * p.y(), p.y());
  };
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    mesh.textures.push_back(t % 2);
    Triangle corners{-1, -1, -1};
    if (t != 3)
      for (int k = 0; k < 3; ++k) {
        corners[k] = int(mesh.uvs.size());
        mesh.uvs.push_back(uv_at(mesh.position(t, k)));
      }
    mesh.corner_uvs.push_back(corners);
  }
  mesh.positions.emplace_back(5, 5, 5);  // which no triangle uses
  const RefinedMesh fine = refined(mesh, 0.2);
  ASSERT_GT(fine.mesh.triangle_count(), 3 * mesh.triangle_count());
  ASSERT_EQ(std::ssize(fine.places), fine.mesh.vertex_count());
  for (std::size_t v = 0; v < fine.places.size(); ++v) {
    Vector3 there = Vector3::Zero();
    for (int k = 0; k < 3; ++k)
      there += fine.places[v].barycentric[k] * mesh.position(fine.places[v].triangle, k);
    EXPECT_LT((fine.mesh.positions[v] - there).norm(), 1e-14);
  }
  int without = 0;
  for (int t = 0; t < fine.mesh.triangle_count(); ++t) {
    EXPECT_EQ(fine.mesh.texture(t), fine.source[t] % 2);
    if (!fine.mesh.textured(t)) {
      EXPECT_EQ(fine.source[t], 3);
      ++without;
      continue;
    }
    for (int k = 0; k < 3; ++k)
      EXPECT_LT((fine.mesh.uv(t, k) - uv_at(fine.mesh.position(t, k))).norm(), 1e-14);
  }
  EXPECT_GT(without, 1);
}

TEST(RefinedMesh, LeavesOutTrianglesThatUseAVertexTwice) {
  Mesh mesh = flat_square(1);
  mesh.triangles.push_back({0, 0, 1});
  mesh.corner_uvs.clear();
  const RefinedMesh fine = refined(mesh, 10);
  EXPECT_EQ(fine.mesh.triangle_count(), mesh.triangle_count() - 1);
}

}  // namespace
}  // namespace mq
