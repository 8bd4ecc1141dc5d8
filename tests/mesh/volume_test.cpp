#include "mq/mesh/volume.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fixtures.h"
#include "mq/sample/shapes.h"

namespace mq {
namespace {

TEST(EnclosedVolume, IsThatOfTheSolid) {
  EXPECT_NEAR(enclosed_volume(cube_cross(3).mesh), 8, 1e-13);
  EXPECT_NEAR(enclosed_volume(fixtures::sphere(6)), 4 * std::numbers::pi / 3, 0.005);
  EXPECT_NEAR(enclosed_volume(fixtures::torus(200, 100, 1, 0.4)),
              2 * std::numbers::pi * std::numbers::pi * 0.16, 0.01);
}

TEST(EnclosedVolume, ScalesAndMovesWithTheSolidAndTurnsItsSign) {
  Mesh mesh = fixtures::tetrahedron();
  const double volume = enclosed_volume(mesh);
  EXPECT_NEAR(volume, 8.0 / 3, 1e-14);
  for (Vector3& p : mesh.positions) p = 10 * p + Vector3(1e6, -1e6, 5);
  EXPECT_NEAR(enclosed_volume(mesh), 1000 * volume, 1e-6);
  for (auto& [a, b, c] : mesh.triangles) std::swap(b, c);
  EXPECT_NEAR(enclosed_volume(mesh), -1000 * volume, 1e-6);
  EXPECT_EQ(enclosed_volume(Mesh{}), 0);
}

}  // namespace
}  // namespace mq
