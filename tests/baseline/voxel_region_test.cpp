#include "mq/baseline/voxel_region.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <vector>

#include "fixtures.h"
#include "mq/base/error.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

Mesh moved(Mesh mesh, const Vector3& by, double scale = 1) {
  for (Vector3& p : mesh.positions) p = scale * p + by;
  return mesh;
}

const std::vector<int> nothing, first = {0};

TEST(VoxelRegion, IsTheVoxelOfTheSeedWhereBothAreTheSame) {
  const Mesh ball = fixtures::sphere(4);
  const VoxelRegion none = voxel_region(ball, ball, nothing, nothing, 0.25);
  EXPECT_EQ(none.voxels, 0);
  EXPECT_EQ(none.template_area, 0);
  const VoxelRegion region = voxel_region(ball, ball, first, first, 0.25);
  EXPECT_EQ(region.seeded, 1);
  EXPECT_EQ(region.voxels, 1);
  EXPECT_GT(region.template_area, 0);
  EXPECT_LT(region.template_area, 4 * 0.25 * 0.25);
  EXPECT_EQ(region.template_area, region.target_area);
}

TEST(VoxelRegion, GrowsOverAllOfAPartThatIsGone) {
  const Mesh ball = fixtures::sphere(4), other = moved(fixtures::torus(40, 20), {4, 0, 0});
  const Mesh both = fixtures::beside(ball, other);
  const std::vector<int> of_other = {int(ball.positions.size())};
  for (const double voxel : {0.07, 0.2, 0.9}) {
    const VoxelRegion gone = voxel_region(both, ball, of_other, nothing, voxel);
    EXPECT_EQ(gone.seeded, 1);
    EXPECT_NEAR(gone.template_area, total_area(other), 1e-9) << voxel;
    EXPECT_EQ(gone.target_area, 0);
    const VoxelRegion come = voxel_region(ball, both, nothing, of_other, voxel);
    EXPECT_NEAR(come.target_area, gone.template_area, 1e-9);
    EXPECT_EQ(come.template_area, 0);
  }
}

TEST(VoxelRegion, StaysAroundABumpThatOneOfTheTwoHas) {
  // All of the bump, and where the ball has none of it; the rest of the ball is the same in both.
  const Mesh ball = fixtures::sphere(5);
  Mesh bumpy = ball;
  std::vector<int> seeds;
  double changed = 0;
  for (int v = 0; v < int(bumpy.positions.size()); ++v) {
    Vector3& p = bumpy.positions[v];
    const double height = 0.5 * std::max(0.0, p.z() - 0.8);
    p *= 1 + height;
    if (height > 0.05) seeds.push_back(v);
  }
  for (int t = 0; t < ball.triangle_count(); ++t) {
    bool is_changed = false;
    for (const int v : ball.triangles[t]) is_changed = is_changed || ball.positions[v].z() > 0.8;
    if (is_changed) changed += triangle_area(ball, t);
  }
  const VoxelRegion region = voxel_region(ball, bumpy, seeds, seeds, 0.1);
  EXPECT_GE(region.voxels, region.seeded);
  EXPECT_GT(region.template_area, 0.5 * changed);
  EXPECT_LT(region.template_area, 1.5 * changed);
  EXPECT_GT(region.target_area, region.template_area);  // a bump has more area
  EXPECT_LT(region.target_area, 2 * region.template_area);
}

TEST(VoxelRegion, IsTheSameBothWays) {
  const Mesh one = fixtures::sphere(4), other = moved(fixtures::sphere(4, fixtures::icosahedron()), {0.05, 0.02, 0.01});
  const VoxelRegion there = voxel_region(one, other, first, nothing, 0.2),
                    back = voxel_region(other, one, nothing, first, 0.2);
  EXPECT_EQ(there.voxels, back.voxels);
  EXPECT_EQ(there.template_area, back.target_area);
  EXPECT_EQ(there.target_area, back.template_area);
  EXPECT_GT(there.voxels, 1);
}

TEST(VoxelRegion, RefusesVoxelsWithoutASide) {
  const Mesh ball = fixtures::sphere(2);
  EXPECT_THROW(voxel_region(ball, ball, first, first, 0), InvalidInput);
  EXPECT_THROW(voxel_region(ball, ball, first, first, std::nan("")), InvalidInput);
  EXPECT_THROW(voxel_region(ball, ball, first, first, 1e-7), InvalidInput);
}

}  // namespace
}  // namespace mq
