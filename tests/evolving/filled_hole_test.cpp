#include "mq/evolving/detail/filled_hole.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "fixtures.h"
#include "mq/mesh/surface.h"

namespace mq {
namespace {

/// A flat square whose border lies in the plane as `map` says.
template <class Map>
HolePatch square_patch(const Map& map) {
  const Mesh mesh = fixtures::flat_square(6, 0.3);
  HolePatch patch{mesh.triangles, mesh.positions, {}, {}};
  patch.fixed.assign(mesh.positions.size(), 0);
  const Surface surface = make_surface(mesh, {.kind = WeldOptions::Kind::none});
  for (HalfEdge h = 0; h < std::ssize(surface.twins); ++h)
    if (surface.twins[h] < 0)
      for (const int k : {h % 3, (h + 1) % 3}) patch.fixed[mesh.triangles[h / 3][k]] = 1;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    patch.places.push_back(patch.fixed[v] ? map(mesh.positions[v]) : Vector2(7, -3));
  return patch;
}

TEST(FilledHole, IsAsAnAffineMapOfTheBorderSays) {
  const auto map = [](const Vector3& p) {
    return Vector2(3 + 1.4 * p.x() + 0.3 * p.y(), 0.8 * p.y() - 0.2 * p.x());
  };
  const HolePatch patch = square_patch(map);
  const auto filled = filled_hole(patch);
  ASSERT_TRUE(filled);
  for (std::size_t v = 0; v < filled->size(); ++v)
    EXPECT_LT(((*filled)[v] - map(patch.positions[v])).norm(), 1e-6);
}

TEST(FilledHole, RefusesWhatIsTurnedOverOrStretchedTooFar) {
  EXPECT_FALSE(filled_hole(square_patch([](const Vector3& p) { return Vector2(-p.x(), p.y()); })));
  EXPECT_FALSE(
      filled_hole(square_patch([](const Vector3& p) { return Vector2(3.2 * p.x(), p.y()); })));
  EXPECT_TRUE(
      filled_hole(square_patch([](const Vector3& p) { return Vector2(2.8 * p.x(), p.y()); })));
}

TEST(FilledHole, KnowsWhichTrianglesHaveAnAreaInCommon) {
  const std::vector<Vector2> one = {{0, 0}, {1, 0}, {0, 1}};
  EXPECT_TRUE(overlap(one, one));
  EXPECT_FALSE(overlap(one, {{1, 0}, {1, 1}, {0, 1}}));    // an edge in common
  EXPECT_FALSE(overlap(one, {{1, 0}, {2, 0}, {1.5, 1}}));  // a corner
  EXPECT_TRUE(overlap(one, {{0.9, 0}, {2, 0}, {1.5, 1}}));
  EXPECT_FALSE(overlap(one, {{3, 0}, {4, 0}, {3, 1}}));
}

}  // namespace
}  // namespace mq
