#include "mq/sequence/birth_shape.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "fixtures.h"
#include "mq/base/error.h"
#include "mq/sequence/remesh.h"
#include "sequence/remesh_models.h"

namespace mq::test {
namespace {

using Births = std::vector<std::array<Vector3, 3>>;

/// The largest relative difference between edges and those at birth.
double worst_edge(const Mesh& mesh, const std::vector<Vector3>& positions, const Births& birth) {
  double worst = 0;
  for (int t = 0; t < mesh.triangle_count(); ++t)
    for (int k = 0; k < 3; ++k) {
      const int i = mesh.triangles[t][k], j = mesh.triangles[t][(k + 1) % 3];
      const double now = (positions[i] - positions[j]).norm();
      const double then = (birth[t][k] - birth[t][(k + 1) % 3]).norm();
      worst = std::max(worst, std::abs(now / then - 1));
    }
  return worst;
}

TEST(BirthShape, OfASurfaceThatIsAsItWasBornIsTheSurface) {
  const Mesh mesh = fixtures::sphere(3);
  EXPECT_EQ(birth_shape(mesh, corner_positions(mesh)), mesh.positions);
}

TEST(BirthShape, UndoesAStretchWhereverTheShapeIsKnownFrom) {
  const Mesh born = fixtures::flat_square(12, 0.2);
  const Mesh now =
      mapped(born, [](const Vector3& p) { return Vector3(1.4 * p.x(), 0.9 * p.y(), p.z()); });
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(1, Vector3(1, 2, 3).normalized()).toRotationMatrix();
  const Births birth = corner_positions(
      mapped(born, [&](const Vector3& p) { return Vector3(turn * p + Vector3(5, 6, 7)); }));
  EXPECT_GT(worst_edge(now, now.positions, birth), 0.3);
  const std::vector<Vector3> shape = birth_shape(now, birth);
  EXPECT_LT(worst_edge(now, shape, birth), 1e-3);
  for (const Vector3& p : shape) EXPECT_LT(std::abs(p.z()), 1e-9);
}

TEST(BirthShape, PutsTogetherTrianglesOfDifferentBirths) {
  // The left half has been stretched since, the right half is new.
  const Mesh born = fixtures::flat_square(12);
  const Mesh now = mapped(born, [](const Vector3& p) {
    return Vector3(p.x() < 0.5 ? 1.3 * p.x() : p.x() + 0.15, p.y(), 0);
  });
  Births birth = corner_positions(now);
  for (int t = 0; t < born.triangle_count(); ++t) {
    const Vector3 middle = (born.position(t, 0) + born.position(t, 1) + born.position(t, 2)) / 3;
    if (middle.x() < 0.5) birth[t] = corner_positions(born)[t];
  }
  EXPECT_LT(worst_edge(now, birth_shape(now, birth), birth), 1e-3);
}

TEST(BirthShape, KeepsBends) {
  const Mesh flat = fixtures::flat_square(24);
  const Mesh bent = mapped(flat, [](const Vector3& p) {
    return Vector3(std::sin(p.x()), p.y(), std::cos(p.x()));
  });
  const std::vector<Vector3> shape = birth_shape(bent, corner_positions(flat));
  for (int v = 0; v < bent.vertex_count(); ++v)
    EXPECT_LT((shape[v] - bent.positions[v]).norm(), 2e-3);  // chords are shorter than arcs
}

TEST(BirthShape, CopesWithTrianglesWithoutArea) {
  Mesh mesh = fixtures::flat_square(4);
  Births birth = corner_positions(mesh);
  birth[3] = {Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};
  birth[5] = {Vector3::Zero(), Vector3::UnitX(), 2 * Vector3::UnitX()};
  for (const Vector3& p : birth_shape(mesh, birth)) EXPECT_TRUE(p.allFinite());
}

TEST(BirthShape, WantsABirthForEachTriangle) {
  const Mesh mesh = fixtures::flat_square(4);
  EXPECT_THROW(birth_shape(mesh, Births(3)), InvalidInput);
}

}  // namespace
}  // namespace mq::test
