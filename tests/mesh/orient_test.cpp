#include "mq/mesh/orient.h"

#include <gtest/gtest.h>

#include "fixtures.h"
#include "mq/mesh/soundness.h"
#include "mq/mesh/volume.h"

namespace mq {
namespace {

std::vector<int> every(int step, int count) {
  std::vector<int> all;
  for (int t = 0; t < count; t += step) all.push_back(t);
  return all;
}

Mesh scaled(Mesh mesh, double factor) {
  for (Vector3& p : mesh.positions) p *= factor;
  return mesh;
}

TEST(Oriented, LeavesWhatFacesOutward) {
  for (const Mesh& mesh :
       {fixtures::sphere(3), fixtures::torus(20, 10), fixtures::flat_square(5)}) {
    const Oriented found = oriented(mesh);
    EXPECT_EQ(found.mesh.triangles, mesh.triangles);
    EXPECT_TRUE(found.turned.empty());
    EXPECT_TRUE(found.defects.empty());
  }
}

TEST(Oriented, TurnsTrianglesThatFaceAgainstTheirNeighbours) {
  for (const Mesh& mesh : {fixtures::torus(20, 10), fixtures::triangle_soup(fixtures::sphere(3)),
                           fixtures::flat_square(6)}) {
    const std::vector<int> some = every(7, mesh.triangle_count());
    const Oriented found = oriented(with_flipped(mesh, some));
    EXPECT_EQ(found.turned, some);
    EXPECT_EQ(found.defects[0].kind, "turned_triangles");
    EXPECT_EQ(found.defects[0].count, std::ssize(some));
    // Two corners changed places twice.
    EXPECT_EQ(found.mesh.triangles, mesh.triangles);
    EXPECT_EQ(found.mesh.corner_uvs, mesh.corner_uvs);
    EXPECT_TRUE(is_manifold(make_surface(found.mesh)));
  }
}

TEST(Oriented, KeepsSolidsApartThatTouchInAFace) {
  // Two tetrahedra with vertices of their own, of which three lie at the same places: no edge of
  // that face has two triangles only.
  const Mesh one = fixtures::tetrahedron();
  Mesh other = one;
  const Triangle base = one.triangles[0];
  const int apex = 6 - base[0] - base[1] - base[2];
  const Vector3 middle =
      (one.positions[base[0]] + one.positions[base[1]] + one.positions[base[2]]) / 3;
  other.positions[apex] = 2 * middle - one.positions[apex];
  std::vector<int> all = every(1, other.triangle_count());
  other = with_flipped(other, all);
  const Mesh both = fixtures::beside(one, other);
  const Oriented found = oriented(both);
  EXPECT_EQ(found.mesh.triangles, both.triangles);
  EXPECT_TRUE(found.defects.empty());
  const Oriented mended = oriented(with_flipped(both, {1, 6}));
  EXPECT_EQ(mended.turned, (std::vector<int>{1, 6}));
  EXPECT_EQ(mended.mesh.triangles, both.triangles);
  EXPECT_EQ(make_surface(mended.mesh).boundary_edges, 0);
}

TEST(Oriented, TurnsASolidThatIsInsideOut) {
  const Mesh mesh = fixtures::torus(20, 10);
  const Oriented found = oriented(with_flipped(mesh, every(1, mesh.triangle_count())));
  EXPECT_EQ(found.mesh.triangles, mesh.triangles);
  EXPECT_EQ(found.defects.at(0).kind, "inside_out_triangles");
  EXPECT_EQ(found.defects.at(0).count, mesh.triangle_count());
}

TEST(Oriented, KnowsACavityFromASolidThatIsInsideOut) {
  const Mesh ball = fixtures::sphere(3);
  const Mesh hollow = with_flipped(scaled(ball, 0.5), every(1, ball.triangle_count()));
  const Mesh shell = fixtures::beside(ball, hollow);
  EXPECT_TRUE(oriented(shell).turned.empty());
  const Oriented found = oriented(with_flipped(shell, every(1, shell.triangle_count())));
  EXPECT_EQ(found.mesh.triangles, shell.triangles);
  EXPECT_NEAR(enclosed_volume(found.mesh), enclosed_volume(shell), 1e-12);
}

TEST(Oriented, TurnsOneOfTwoBalls) {
  const Mesh ball = fixtures::sphere(3);
  Mesh away = ball;
  for (Vector3& p : away.positions) p += Vector3(3, 0, 0);
  const Mesh two = fixtures::beside(ball, away);
  const Oriented found =
      oriented(fixtures::beside(ball, with_flipped(away, every(1, away.triangle_count()))));
  EXPECT_EQ(found.mesh.triangles, two.triangles);
}

TEST(Oriented, TurnsWhatIsOpenAsItWasBefore) {
  const Mesh sheet = fixtures::flat_square(6);
  const Mesh turned = with_flipped(sheet, every(1, sheet.triangle_count()));
  EXPECT_TRUE(oriented(turned).turned.empty());
  Mesh before = sheet;
  for (Vector3& p : before.positions) p.z() += 0.01;
  EXPECT_EQ(oriented(turned, &before).mesh.triangles, sheet.triangles);
  EXPECT_TRUE(oriented(sheet, &before).turned.empty());
  // Of what is far away nothing is known.
  for (Vector3& p : before.positions) p.z() += 1;
  EXPECT_TRUE(oriented(turned, &before).turned.empty());
}

TEST(OrientedLike, TurnsWhatWasCapturedUnlessWhatFollowsItIsInsideOut) {
  const Mesh mesh = fixtures::torus(20, 10);
  const Mesh inward = with_flipped(mesh, every(1, mesh.triangle_count()));
  EXPECT_EQ(oriented_like(inward, mesh).mesh.triangles, mesh.triangles);
  EXPECT_EQ(oriented_like(inward, mesh).defects.at(0).kind, "inside_out_triangles");
  EXPECT_EQ(oriented_like(inward, inward).mesh.triangles, inward.triangles);
  EXPECT_TRUE(oriented_like(inward, inward).defects.empty());
}

TEST(Oriented, LeavesAStripThatHasOneSideAndWhatIsNoSurface) {
  const Mesh strip = fixtures::moebius_strip(20);
  EXPECT_TRUE(oriented(strip).turned.empty());
  EXPECT_TRUE(oriented(fixtures::nonmanifold_edge()).turned.empty());
  EXPECT_TRUE(oriented(Mesh{}).turned.empty());
}

}  // namespace
}  // namespace mq
