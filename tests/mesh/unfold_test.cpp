#include "mq/mesh/unfold.h"

#include <gtest/gtest.h>

#include <random>

#include "mq/mesh/soundness.h"

namespace mq {
namespace {

std::vector<int> folded(const Mesh& mesh) {
  return folded_triangles(make_surface(mesh, {.kind = WeldOptions::Kind::none}));
}

/// A plane of n × n squares, two triangles each.
Mesh plane(int n) {
  Mesh mesh;
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= n; ++x) mesh.positions.push_back({double(x), double(y), 0});
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const int v = y * (n + 1) + x;
      mesh.triangles.push_back({v, v + 1, v + n + 2});
      mesh.triangles.push_back({v, v + n + 2, v + n + 1});
    }
  return mesh;
}

TEST(Unfold, LeavesWhatIsNotFolded) {
  const Mesh mesh = plane(5);
  EXPECT_EQ(unfolded(mesh), mesh.positions);
}

TEST(Unfold, BringsBackAVertexThatWentAcrossAnEdge) {
  Mesh mesh = plane(8);
  const int centre = 4 * 9 + 4;
  mesh.positions[centre] += Vector3(1.3, 0.1, 0);
  ASSERT_FALSE(folded(mesh).empty());
  const Mesh before = mesh;
  mesh.positions = unfolded(mesh);
  EXPECT_TRUE(folded(mesh).empty());
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    EXPECT_EQ(mesh.positions[v].z(), 0);
    if ((before.positions[v] - before.positions[centre]).norm() > 4) {
      EXPECT_EQ(mesh.positions[v], before.positions[v]) << v;
    }
  }
}

TEST(Unfold, TakesOutManyFoldsAndDegenerateTriangles) {
  Mesh mesh = plane(40);
  std::mt19937 random(7);
  for (int i = 0; i < 60; ++i) {
    Vector3& p = mesh.positions[random() % mesh.positions.size()];
    for (int d = 0; d < 2; ++d) p[d] += double(random() % 1000) / 250 - 2;
  }
  mesh.positions[20 * 41 + 20] = mesh.positions[20 * 41 + 21];
  ASSERT_GT(folded(mesh).size(), 60U);
  mesh.positions = unfolded(mesh);
  EXPECT_TRUE(folded(mesh).empty());
}

TEST(Unfold, KeepsWhatIsFixed) {
  Mesh mesh = plane(8);
  const int centre = 4 * 9 + 4;
  mesh.positions[centre] += Vector3(1.3, 0.1, 0);
  std::vector<char> fixed(mesh.positions.size(), 0);
  fixed[centre] = 1;
  const Vector3 there = mesh.positions[centre];
  mesh.positions = unfolded(mesh, fixed);
  EXPECT_EQ(mesh.positions[centre], there);
  EXPECT_TRUE(folded(mesh).empty());
  EXPECT_EQ(unfolded(mesh, std::vector<char>(mesh.positions.size(), 1)), mesh.positions);
}

TEST(Unfold, LeavesWhatItCannotUnfoldAsItWas) {
  // Two triangles back to back, and beside them one that can be helped.
  Mesh mesh = plane(6);
  mesh.positions[3 * 7 + 3] += Vector3(1.2, 0, 0);
  const int first = mesh.vertex_count();
  for (const Vector3& p : {Vector3(9, 0, 0), Vector3(10, 0, 0), Vector3(9, 1, 0)})
    mesh.positions.push_back(p);
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 1});
  const std::vector<Vector3> before = mesh.positions;
  mesh.positions = unfolded(mesh);
  EXPECT_EQ(folded(mesh).size(), 2U);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(mesh.positions[first + k], before[first + k]);
}

TEST(Unfold, LeavesVerticesThatAreNotManifold) {
  // Two fans that meet in a vertex, which lies across an edge of one of them.
  Mesh mesh;
  mesh.positions = {{0, 0, 0},   {1, 0, 0},  {0, 1, 0},   {-1, 0.5, 0},
                    {-3, -1, 0}, {-4, 0, 0}, {-3, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 4, 5}, {0, 5, 6}};
  mesh.positions[0] = {0.8, 0.8, 0};
  ASSERT_FALSE(folded(mesh).empty());
  const Vector3 there = mesh.positions[0];
  mesh.positions = unfolded(mesh);
  EXPECT_EQ(mesh.positions[0], there);
}

}  // namespace
}  // namespace mq
