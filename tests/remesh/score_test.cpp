// What decides where a template is replaced.
#include "mq/remesh/detail/score.h"

#include <gtest/gtest.h>

#include "mq/mesh/surface.h"
#include "mq/remesh/remesh.h"
#include "remesh/remesh_models.h"

namespace mq::test {
namespace {

TEST(Mismatch, CountsHiddenVerticesLess) {
  // The inner of two nested spheres sees nothing but the outer one.
  const Mesh nested = fixtures::beside(
      fixtures::sphere(3),
      mapped(fixtures::sphere(3), [](const Vector3& p) { return Vector3(0.5 * p); }));
  const Surface surface = make_surface(nested);
  std::vector<int> vertices(nested.positions.size());
  for (std::size_t v = 0; v < vertices.size(); ++v) vertices[v] = int(v);
  const std::vector<double> seen = visibility(surface, vertices);
  for (std::size_t v = 0; v < seen.size(); ++v) EXPECT_EQ(seen[v], v < seen.size() / 2 ? 1 : 0);
}

TEST(Mismatch, IsTheDistanceInTolerancesWhereNothingIsBentOrHidden) {
  const Mesh sheet = fixtures::flat_square(10);
  const Mesh above =
      mapped(sheet, [](const Vector3& p) { return Vector3(p + Vector3(0, 0, 0.03)); });
  const Surface surface = make_surface(sheet);
  const ClosestPointFinder other(above);
  const Mismatch found = mismatch(surface, other, {.tolerance = 0.02});
  for (const double score : found.scores) EXPECT_NEAR(score, 1.5, 1e-12);
}

TEST(Distortion, IsToldByStretchAndByArea) {
  const Mesh triangle = fixtures::one_triangle();
  const auto distorted = [&](double x, double y) {
    const Mesh rest =
        mapped(triangle, [&](const Vector3& p) { return Vector3(p.x() * x, p.y() * y, 0); });
    return distorted_triangles(triangle, corner_positions(rest))[0] != 0;
  };
  EXPECT_FALSE(distorted(1, 1));
  EXPECT_FALSE(distorted(1.7, 0.6));
  EXPECT_TRUE(distorted(1.8, 0.5));
  EXPECT_TRUE(distorted(1.8, 1.8));
  EXPECT_TRUE(distorted(0.5, 0.5));
}

}  // namespace
}  // namespace mq::test
