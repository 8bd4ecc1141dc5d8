#include "mq/track/rest_shape.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "fixtures.h"
#include "mq/base/error.h"
#include "mq/remesh/remesh.h"
#include "remesh/remesh_models.h"

namespace mq::test {
namespace {

using Births = std::vector<std::array<Vector3, 3>>;

/// The largest relative difference between edges and those at birth.
double worst_edge(const Mesh& mesh, const std::vector<Vector3>& positions, const Births& rest) {
  double worst = 0;
  for (int t = 0; t < mesh.triangle_count(); ++t)
    for (int k = 0; k < 3; ++k) {
      const int i = mesh.triangles[t][k], j = mesh.triangles[t][(k + 1) % 3];
      const double now = (positions[i] - positions[j]).norm();
      const double then = (rest[t][k] - rest[t][(k + 1) % 3]).norm();
      worst = std::max(worst, std::abs(now / then - 1));
    }
  return worst;
}

TEST(BirthShape, OfASurfaceThatIsAsItWasBornIsTheSurface) {
  const Mesh mesh = fixtures::sphere(3);
  EXPECT_EQ(rest_shape(mesh, corner_positions(mesh)), mesh.positions);
}

TEST(BirthShape, UndoesAStretchWhereverTheShapeIsKnownFrom) {
  const Mesh added = fixtures::flat_square(12, 0.2);
  const Mesh now =
      mapped(added, [](const Vector3& p) { return Vector3(1.4 * p.x(), 0.9 * p.y(), p.z()); });
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(1, Vector3(1, 2, 3).normalized()).toRotationMatrix();
  const Births rest = corner_positions(
      mapped(added, [&](const Vector3& p) { return Vector3(turn * p + Vector3(5, 6, 7)); }));
  EXPECT_GT(worst_edge(now, now.positions, rest), 0.3);
  const std::vector<Vector3> shape = rest_shape(now, rest);
  EXPECT_LT(worst_edge(now, shape, rest), 1e-3);
  for (const Vector3& p : shape) EXPECT_LT(std::abs(p.z()), 1e-9);
}

TEST(BirthShape, PutsTogetherTrianglesOfDifferentBirths) {
  // The left half has been stretched since, the right half is new.
  const Mesh added = fixtures::flat_square(12);
  const Mesh now = mapped(added, [](const Vector3& p) {
    return Vector3(p.x() < 0.5 ? 1.3 * p.x() : p.x() + 0.15, p.y(), 0);
  });
  Births rest = corner_positions(now);
  for (int t = 0; t < added.triangle_count(); ++t) {
    const Vector3 middle = (added.position(t, 0) + added.position(t, 1) + added.position(t, 2)) / 3;
    if (middle.x() < 0.5) rest[t] = corner_positions(added)[t];
  }
  EXPECT_LT(worst_edge(now, rest_shape(now, rest), rest), 1e-3);
}

TEST(BirthShape, KeepsBends) {
  const Mesh flat = fixtures::flat_square(24);
  const Mesh bent = mapped(
      flat, [](const Vector3& p) { return Vector3(std::sin(p.x()), p.y(), std::cos(p.x())); });
  const std::vector<Vector3> shape = rest_shape(bent, corner_positions(flat));
  for (int v = 0; v < bent.vertex_count(); ++v)
    EXPECT_LT((shape[v] - bent.positions[v]).norm(), 2e-3);  // chords are shorter than arcs
}

TEST(BirthShape, CopesWithTrianglesWithoutArea) {
  Mesh mesh = fixtures::flat_square(4);
  Births rest = corner_positions(mesh);
  rest[3] = {Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};
  rest[5] = {Vector3::Zero(), Vector3::UnitX(), 2 * Vector3::UnitX()};
  for (const Vector3& p : rest_shape(mesh, rest)) EXPECT_TRUE(p.allFinite());
}

TEST(BirthShape, WantsABirthForEachTriangle) {
  const Mesh mesh = fixtures::flat_square(4);
  EXPECT_THROW(rest_shape(mesh, Births(3)), InvalidInput);
}

TEST(WorstDistortion, IsTheStretchOfALinearMap) {
  const Mesh rest = fixtures::flat_square(5, 0.2);
  const auto worst = [&](double x, double y) {
    return worst_distortion(
        mapped(rest, [&](const Vector3& p) { return Vector3(x * p.x(), y * p.y(), p.z()); }),
        corner_positions(rest));
  };
  EXPECT_NEAR(worst(1, 1), 1, 1e-12);
  EXPECT_NEAR(worst(2, 0.5), 4, 1e-9);
  EXPECT_NEAR(worst(3, 3), 9, 1e-9);
  EXPECT_NEAR(worst(0.5, 0.5), 4, 1e-9);
}

}  // namespace
}  // namespace mq::test
