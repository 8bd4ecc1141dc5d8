#include "mq/track/recognised_positions.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "mq/sample/implicit.h"
#include "mq/sample/sample.h"
#include "mq/track/path_lengths.h"
#include "mq/track/recognised_points.h"
#include "sample/moving_bodies.h"

namespace mq {
namespace {

/// Ends of the limbs of a body with three of them, of unlike lengths; the first is the longest.
using LimbEnds = std::array<Vector3, 3>;
const LimbEnds limbs_at_rest{Vector3(0, 1.1, 0), Vector3(-0.7, -0.4, 0), Vector3(0.43, -0.25, 0)};
const LimbEnds limbs_swung{Vector3(0.33, 0.11, 1.04), Vector3(-0.7, -0.4, 0), Vector3(0.43, -0.25, 0)};

double distance_to_segment(const Vector3& p, const Vector3& end) {
  const double along = std::clamp(p.dot(end) / end.squaredNorm(), 0.0, 1.0);
  return (p - along * end).norm();
}

/// A mesh of its own, whatever the others are.
Mesh body_with_limbs(const LimbEnds& ends, int triangles) {
  const Solid solid = [&](const Vector3& p) {
    double distance = p.norm() - 0.2;
    for (const Vector3& end : ends)
      distance = smooth_union(distance, distance_to_segment(p, end) - 0.1, 0.08);
    return distance;
  };
  return mesh_of_solid(solid, {.low = Vector3::Constant(-1.4),
                               .high = Vector3::Constant(1.4),
                               .triangles = triangles});
}

int vertex_near(const Mesh& mesh, const Vector3& p) {
  const auto nearer = [&](const Vector3& a, const Vector3& b) {
    return (a - p).squaredNorm() < (b - p).squaredNorm();
  };
  return int(std::ranges::min_element(mesh.positions, nearer) - mesh.positions.begin());
}

TEST(PathLengths, OnABallAreThoseOfGreatCircles) {
  const Mesh mesh = make_sample("sphere", {.triangles = 3000}).mesh;
  const Surface surface = make_surface(mesh);
  const std::vector<double> lengths = PathLengths(surface.mesh)(17);
  const Vector3 from = surface.mesh.positions[17].normalized();
  for (int v = 0; v < surface.mesh.vertex_count(); ++v) {
    const double angle =
        std::acos(std::clamp(from.dot(surface.mesh.positions[v].normalized()), -1.0, 1.0));
    EXPECT_NEAR(lengths[v], angle, 0.04 * angle + 1e-6);
  }
}

TEST(PathLengths, AreInfiniteWhereNoPathLeads) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 0, 0}, {6, 0, 0}, {5, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  const std::vector<std::vector<double>> lengths = PathLengths(mesh)(std::vector<int>{0, 4});
  constexpr double infinite = std::numeric_limits<double>::infinity();
  EXPECT_EQ(lengths[0], (std::vector<double>{0, 1, 1, infinite, infinite, infinite}));
  EXPECT_EQ(lengths[1][1], infinite);
  EXPECT_EQ(lengths[1][3], 1);
  EXPECT_NEAR(lengths[1][5], std::sqrt(2), 1e-15);
}

TEST(Extremities, AreTheEndsOfLimbs) {
  const Mesh mesh = body_with_limbs(limbs_swung, 2500);
  const Extremities found = extremities(mesh);
  ASSERT_EQ(found.vertices.size(), 3U);
  for (const Vector3& end : limbs_swung) {
    const auto distance = [&](int v) { return (mesh.positions[v] - end).norm(); };
    EXPECT_LT(distance(std::ranges::min(found.vertices, {}, distance)), 0.15);
  }
}

TEST(Extremities, AreMatchedByHowFarTheyAreApart) {
  const Mesh a = body_with_limbs(limbs_at_rest, 2500), b = body_with_limbs(limbs_swung, 2000);
  const Extremities first = extremities(a), second = extremities(b);
  const std::vector<std::vector<double>> moves(3, std::vector<double>(3, 0));
  const std::vector<MatchedExtremities> found = matched_extremities(first, second, moves, 4);
  ASSERT_FALSE(found.empty());
  ASSERT_EQ(found[0].pairs.size(), 3U);
  for (const auto& [i, j] : found[0].pairs) {
    const auto limb = [](const Vector3& p, const LimbEnds& ends) {
      const auto nearer = [&](const Vector3& end) { return (end - p).norm(); };
      return std::ranges::min_element(ends, {}, nearer) - ends.begin();
    };
    EXPECT_EQ(limb(a.positions[first.vertices[i]], limbs_at_rest),
              limb(b.positions[second.vertices[j]], limbs_swung));
  }
  for (std::size_t i = 1; i < found.size(); ++i) EXPECT_LE(found[i].score, found[i - 1].score);
}

TEST(Extremities, OfBodiesOfOtherSizesAreNotMatched) {
  Mesh mesh = body_with_limbs(limbs_at_rest, 2000);
  const Extremities first = extremities(mesh);
  for (Vector3& p : mesh.positions) p *= 2;
  const std::vector<std::vector<double>> moves(3, std::vector<double>(3, 0));
  EXPECT_TRUE(matched_extremities(first, extremities(mesh), moves, 4).empty());
}

TEST(Tracking, FindsALimbAgainThatHasSwungByItsLength) {
  const Mesh rest = cleaned(body_with_limbs(limbs_at_rest, 2000)).mesh;
  const Mesh swung = body_with_limbs(limbs_swung, 1800);
  const auto run = [&](int threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism,
                                      std::size_t(threads));
    SurfaceTracker tracker(rest);
    return tracker.follow(rest.positions, {}, TrackTarget(swung));
  };
  const TrackedFrame found = run(1);
  EXPECT_TRUE(found.recognised);  // by which it was lost without
  EXPECT_LT(found.distance.p95, 2e-3);
  EXPECT_LT(found.distortion.mean, 1.4);
  for (std::size_t limb = 0; limb < 3; ++limb)
    EXPECT_LT(
        (found.positions[vertex_near(rest, 1.1 * limbs_at_rest[limb])] - limbs_swung[limb]).norm(),
        0.2);
  EXPECT_EQ(found.positions, run(2).positions);
  EXPECT_EQ(found.positions, run(7).positions);
}

TEST(Tracking, LooksForNothingThatOnlyTheFrameHas) {
  LimbEnds stump = limbs_at_rest;
  stump[0] = Vector3(0, 0.2, 0);
  const Mesh rest = cleaned(body_with_limbs(stump, 2000)).mesh;
  SurfaceTracker tracker(rest);
  const TrackedFrame found = tracker.follow(rest.positions, {}, TrackTarget(body_with_limbs(limbs_at_rest, 2000)));
  EXPECT_GT(found.distance.p95, lost_distance);
  EXPECT_FALSE(found.recognised);
  EXPECT_LT(found.distortion.p95, 1.5);
}

TEST(Tracking, RecognisesNothingWhereClosestPointsAreEnough) {
  const std::vector<MovingFrame> frames = moving_sequence("bending", 0, 1, {.triangles = 2000});
  SurfaceTracker tracker(frames[0].mesh);
  const TrackedFrame found =
      tracker.follow(frames[0].mesh.positions, {}, TrackTarget(frames[1].mesh));
  EXPECT_FALSE(found.recognised);
  EXPECT_LT(found.distance.p95, lost_distance);
}

}  // namespace
}  // namespace mq
