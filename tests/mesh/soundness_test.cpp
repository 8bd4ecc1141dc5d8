#include "mq/mesh/soundness.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fixtures.h"

namespace mq {
namespace {

using std::numbers::pi;

TEST(Soundness, IsManifoldUnlessItHadToBeCut) {
  EXPECT_TRUE(is_manifold(make_surface(fixtures::one_triangle())));
  Mesh fin = fixtures::one_triangle();
  fin.uvs.clear();
  fin.corner_uvs.clear();
  for (int k = 0; k < 2; ++k) {
    fin.positions.push_back({0.5, 0, k ? 1.0 : -1.0});
    fin.triangles.push_back({0, 1, 3 + k});
  }
  EXPECT_FALSE(is_manifold(make_surface(fin)));
}

TEST(Soundness, KnowsTrianglesThatAreFoldedOver) {
  // A hexagon around a vertex, which goes to the middle of a side, and across it.
  const auto folded_with_centre_at = [](double reach) {
    Mesh mesh;
    mesh.positions = {Vector3(reach * std::cos(pi / 6), reach * std::sin(pi / 6), 0)};
    for (int k = 0; k < 6; ++k) {
      mesh.positions.push_back({std::cos(k * pi / 3), std::sin(k * pi / 3), 0});
      mesh.triangles.push_back({0, k + 1, (k + 1) % 6 + 1});
    }
    return folded_triangles(make_surface(mesh));
  };
  const double side = std::cos(pi / 6);
  EXPECT_EQ(folded_with_centre_at(0), std::vector<int>());
  EXPECT_EQ(folded_with_centre_at(0.9 * side), std::vector<int>());
  EXPECT_EQ(folded_with_centre_at(side), std::vector<int>{0});
  EXPECT_EQ(folded_with_centre_at(1.1 * side), std::vector<int>{0});
}

}  // namespace
}  // namespace mq
