// What remeshing is told to leave as it is.
#include <gtest/gtest.h>

#include "fixtures.h"
#include "mq/base/error.h"
#include "remesh/remesh_models.h"

namespace mq::test {
namespace {

TEST(Remesh, LeavesWhatItIsToldToLeave) {
  const Surface one = make_surface(fixtures::sphere(3));
  Mesh moved = one.mesh;
  for (Vector3& p : moved.positions)
    if (p.z() > 0.9) p.z() += 0.5;
  const Surface other = make_surface(moved);
  EXPECT_GT(remesh(one, other).removed, 0);
  const std::vector<char> all(one.mesh.positions.size(), 1);
  const Remeshed left = remesh(one, other, {.left_of_template = all, .left_of_target = all});
  EXPECT_EQ(left.mesh.positions, one.mesh.positions);
  EXPECT_EQ(left.mesh.triangles, one.mesh.triangles);
  EXPECT_THROW(remesh(one, other, {.left_of_target = std::vector<char>(3, 1)}), InvalidInput);
}

}  // namespace
}  // namespace mq::test
