#include "mq/track/tracking.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <cmath>
#include <ranges>

#include "mq/base/error.h"
#include "mq/mesh/soundness.h"
#include "mq/sample/sample.h"
#include "mq/track/track_truth.h"
#include "sample/moving_bodies.h"

namespace mq {
namespace {

Mesh ball_mesh() { return make_sample("sphere", {.triangles = 3000}).mesh; }

/// A body followed over a few frames of its motion.
struct Followed {
  DriftSummary drift;
  SurfaceDistance distance;
  double edge = 0;
};
Followed followed(const std::string& name, int first, int last, const TrackOptions& options,
                  const MovingOptions& moving) {
  const std::vector<MovingFrame> frames = moving_sequence(name, first, last, moving);
  const MovingFrame& rest = frames.front();
  SurfaceTracker tracker(rest.mesh, colours_of(rest), options);
  Followed result;
  result.edge = mean_edge_length(make_surface(rest.mesh));
  std::vector<Vector3> now = rest.mesh.positions, before;
  for (const MovingFrame& frame : frames | std::views::drop(1)) {
    const TrackTarget target(frame.mesh, colours_of(frame));
    const TrackedFrame tracked = tracker.follow(now, before, target);
    before = std::exchange(now, tracked.positions);
    result.distance = tracked.distance;
    result.drift = summary(drift(now, rest.material, {frame.mesh, material_of(frame)}, 0.05));
  }
  EXPECT_EQ(result.drift.known, rest.mesh.vertex_count());
  return result;
}

TEST(CleanMesh, LeavesOutStrayPartsAndTrianglesWithoutThreeVertices) {
  Mesh mesh = ball_mesh();
  const int triangles = mesh.triangle_count(), vertices = mesh.vertex_count();
  mesh.triangles.push_back({5, 5, 9});
  for (const Vector3& p : {Vector3(3, 0, 0), Vector3(3.01, 0, 0), Vector3(3, 0.01, 0)})
    mesh.positions.push_back(p);
  mesh.triangles.push_back({vertices, vertices + 1, vertices + 2});
  mesh.positions.emplace_back(9, 9, 9);
  if (mesh.has_uvs()) mesh.corner_uvs.resize(mesh.triangles.size(), {0, 0, 0});
  const CleanMesh clean = cleaned(mesh);
  EXPECT_EQ(clean.mesh.triangle_count(), triangles);
  EXPECT_EQ(clean.source_from_triangle.size(), std::size_t(triangles));
  for (int v = 0; v < clean.mesh.vertex_count(); ++v)
    EXPECT_EQ(clean.mesh.positions[v], mesh.positions[clean.source_from_vertex[v]]);
  EXPECT_EQ(cleaned(clean.mesh).mesh.triangles, clean.mesh.triangles);
  EXPECT_EQ(cleaned(clean.mesh).mesh.positions, clean.mesh.positions);
}

TEST(CleanMesh, OfNothingIsRefused) {
  Mesh mesh;
  EXPECT_THROW(cleaned(mesh), InvalidInput);
  mesh.positions = {{0, 0, 0}, {1, 0, 0}};
  mesh.triangles = {{0, 1, 1}};
  EXPECT_THROW(cleaned(mesh), InvalidInput);
}

TEST(Distortion, IsOneUnderRigidMotionAndTheStretchElse) {
  const Mesh mesh = ball_mesh();
  const Eigen::Matrix3d R = Eigen::AngleAxisd(1, Vector3(1, 1, 0).normalized()).toRotationMatrix();
  std::vector<Vector3> moved, larger, smaller;
  for (const Vector3& p : mesh.positions) {
    moved.push_back(R * p + Vector3(1, 2, 3));
    larger.push_back(1.5 * p);
    smaller.push_back(0.5 * p);
  }
  EXPECT_NEAR(distortion(mesh.triangles, mesh.positions, moved).p95, 1, 1e-12);
  EXPECT_NEAR(distortion(mesh.triangles, mesh.positions, moved).mean, 1, 1e-12);
  EXPECT_NEAR(distortion(mesh.triangles, mesh.positions, larger).mean, 1.5, 1e-12);
  EXPECT_NEAR(distortion(mesh.triangles, mesh.positions, smaller).p95, 2, 1e-12);
}

TEST(SurfaceDistance, OfConcentricSpheresIsTheDifferenceOfRadii) {
  const Mesh mesh = ball_mesh();
  Mesh larger = mesh;
  for (Vector3& p : larger.positions) p *= 1.1;
  const TrackTarget target(mesh);
  const SurfaceDistance found = surface_distance(larger, target);
  EXPECT_NEAR(found.mean * target.diagonal(), 0.1, 0.003);
  EXPECT_NEAR(found.max * target.diagonal(), 0.1, 0.003);
  const SurfaceDistance same = surface_distance(mesh, target);
  EXPECT_LT(same.max, 1e-12);
}

TEST(SurfaceDistance, OfBothWaysIsSmallWhereOneSurfaceHasMore) {
  const Mesh mesh = ball_mesh();
  Mesh two = mesh;
  for (const Vector3& p : mesh.positions) two.positions.push_back(p + Vector3(5, 0, 0));
  for (const Triangle& t : mesh.triangles)
    two.triangles.push_back({t[0] + mesh.vertex_count(), t[1] + mesh.vertex_count(), t[2] + mesh.vertex_count()});
  two.corner_uvs.clear();
  const Mesh* meshes[] = {&mesh, &two};
  for (const int which : {0, 1}) {
    const Mesh* one = meshes[which];
    const TrackTarget target(*meshes[1 - which]);
    const ClosestPointFinder on_one(*one);
    const auto there = target.closest()(one->positions), back = on_one(target.surface().mesh.positions);
    EXPECT_GT(surface_distance(there, back, target).p95, 0.3);
    EXPECT_LT(mutual_distance(there, back, target).p95, 1e-9);
  }
}

TEST(UnfoldedOnto, LiesOnTheTargetWithoutFolds) {
  Mesh mesh = ball_mesh();
  const TrackTarget target(mesh);
  const auto folded = [&] {
    return folded_triangles(make_surface(mesh, {.kind = WeldOptions::Kind::none})).size();
  };
  const double edge = mean_edge_length(target.surface());
  for (int v = 100; v < mesh.vertex_count(); v += 200) {
    const Vector3 aside = mesh.positions[v].unitOrthogonal();
    mesh.positions[v] = (mesh.positions[v] + 1.3 * edge * aside).normalized();
  }
  ASSERT_GT(folded(), 5U);
  mesh.positions = unfolded_onto(target, mesh);
  EXPECT_EQ(folded(), 0U);
  EXPECT_LT(surface_distance(mesh, target).max * target.diagonal(), 0.1 * edge);
}

TEST(Drift, IsZeroForTheTruthAndTheMoveElse) {
  const MovingOptions moving{.triangles = 2500};
  const MovingFrame a = make_moving_frame("bending", 0, moving);
  const MovingFrame b = make_moving_frame("bending", 10, moving);
  std::vector<Vector3> truth;
  for (const Vector3& m : a.material) truth.push_back(moved_material("bending", m, 10, moving));
  const MaterialFrame frame{b.mesh, material_of(b)};
  const DriftSummary exact = summary(drift(truth, a.material, frame, 0.05));
  EXPECT_EQ(exact.known, a.mesh.vertex_count());
  EXPECT_LT(exact.mean, 2e-3);  // facets of both meshes, edges of 0.06
  for (Vector3& p : truth) p.z() += 0.1;
  EXPECT_NEAR(summary(drift(truth, a.material, frame, 0.05)).mean, 0.1, 2e-3);
  const std::vector<Vector3> elsewhere(a.material.size(), Vector3(5, 5, 5));
  EXPECT_EQ(summary(drift(truth, elsewhere, frame, 0.05)).known, 0);
}

TEST(Tracking, StaysOnATargetThatIsTheTemplate) {
  const Mesh mesh = cleaned(ball_mesh()).mesh;
  SurfaceTracker tracker(mesh);
  const TrackedFrame tracked = tracker.follow(mesh.positions, {}, TrackTarget(mesh));
  EXPECT_LT(tracked.distance.max, 1e-6);
  for (int v = 0; v < mesh.vertex_count(); ++v)
    EXPECT_LT((tracked.positions[v] - mesh.positions[v]).norm(), 1e-5);
}

TEST(Tracking, FollowsARigidMotionOfAShapeThatShowsIt) {
  const MovingOptions moving{.triangles = 3000};
  const MovingFrame rest = make_moving_frame("bending", 0, moving);
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(0.1, Vector3(1, 1, 1).normalized()).toRotationMatrix();
  Mesh mesh = rest.mesh;
  for (Vector3& p : mesh.positions) p = R * p + Vector3(0.05, 0, 0.02);
  SurfaceTracker tracker(rest.mesh);
  const TrackedFrame tracked = tracker.follow(rest.mesh.positions, {}, TrackTarget(mesh));
  double sum = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    sum += (tracked.positions[v] - mesh.positions[v]).norm() / mesh.vertex_count();
  EXPECT_LT(sum, 0.1 * mean_edge_length(make_surface(mesh)));
  EXPECT_LT(tracked.distance.p95, 5e-4);
}

TEST(Tracking, ContinuesAMotionThatIsTooFastForClosestPoints) {
  const Mesh rest = make_moving_frame("bending", 0, {.triangles = 2500}).mesh;
  const auto at = [&](double t) {
    Mesh mesh = rest;
    const Eigen::Matrix3d R = Eigen::AngleAxisd(0.6 * t, Vector3::UnitZ()).toRotationMatrix();
    for (Vector3& p : mesh.positions) p = R * p + Vector3(0.3 * t, 0, 0);
    return mesh;
  };
  SurfaceTracker tracker(rest);
  const TrackedFrame tracked = tracker.follow(at(1).positions, at(0).positions, TrackTarget(at(2)));
  EXPECT_TRUE(tracked.predicted);
  EXPECT_LT(tracked.distance.p95, 5e-4);
  double sum = 0;
  for (int v = 0; v < rest.vertex_count(); ++v)
    sum += (tracked.positions[v] - at(2).positions[v]).norm() / rest.vertex_count();
  EXPECT_LT(sum, 0.1 * mean_edge_length(make_surface(rest)));
}

TEST(Tracking, LiesOnASurfaceThatBendsAndIsMeshedAnew) {
  const Followed found = followed("bending", 0, 3, {}, {.triangles = 4000});
  EXPECT_LT(found.distance.p95, 2e-3);
}

TEST(Tracking, FollowsColoursWhereShapeDoesNotTell) {
  const MovingOptions moving{.triangles = 4000};
  TrackOptions coloured;
  coloured.colour_cycles = 2;
  const Followed by_shape = followed("spinning", 0, 3, {}, moving);
  const Followed by_colour = followed("spinning", 0, 3, coloured, moving);
  EXPECT_LT(by_colour.drift.mean, 0.25 * by_colour.edge);
  EXPECT_GT(by_shape.drift.mean, 4 * by_colour.drift.mean);
  EXPECT_LT(by_colour.distance.p95, 2e-3);
}

TEST(Tracking, IsTheSameForAnyNumberOfThreads) {
  const MovingOptions moving{.triangles = 1500};
  const MovingFrame a = make_moving_frame("bending", 0, moving);
  const MovingFrame b = make_moving_frame("bending", 2, moving);
  TrackOptions options;
  options.colour_cycles = 1;
  const auto run = [&](int threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism,
                                      std::size_t(threads));
    SurfaceTracker tracker(a.mesh, colours_of(a), options);
    return tracker.follow(a.mesh.positions, {}, TrackTarget(b.mesh, colours_of(b))).positions;
  };
  const auto one = run(1);
  EXPECT_EQ(one, run(2));
  EXPECT_EQ(one, run(7));
}

/// It leads a frame too far.
TEST(Tracking, OfAMotionThatIsKnownIsCorrectedByColours) {
  const MovingOptions moving{.triangles = 1500};
  const MovingFrame a = make_moving_frame("spinning", 0, moving), b = make_moving_frame("spinning", 1, moving);
  std::vector<Vector3> known;
  for (const Vector3& m : a.material) known.push_back(moved_material("spinning", m, 2, moving));
  const auto slid = [&](int cycles, int threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, std::size_t(threads));
    SurfaceTracker tracker(a.mesh, colours_of(a), {.node_spacing = 0.1, .colour_cycles = cycles});
    return tracker.follow_known(a.mesh.positions, known, TrackTarget(b.mesh, colours_of(b)));
  };
  const auto mean_drift = [&](const TrackedFrame& frame) {
    return summary(drift(frame.positions, a.material, {b.mesh, material_of(b)}, 0.05)).mean;
  };
  const TrackedFrame by_colour = slid(1, 1), by_shape = slid(0, 1);
  EXPECT_TRUE(by_colour.known);
  EXPECT_LT(mean_drift(by_colour), 0.75 * mean_drift(by_shape));
  EXPECT_LT(by_colour.distance.p95, 1.1 * by_shape.distance.p95);
  EXPECT_EQ(slid(1, 3).positions, by_colour.positions);
}

TEST(Tracking, RefusesSizesThatDoNotFit) {
  const Mesh mesh = cleaned(ball_mesh()).mesh;
  SurfaceTracker tracker(mesh);
  const TrackTarget target(mesh);
  const std::vector<Vector3> fewer(mesh.positions.begin(), mesh.positions.end() - 1);
  EXPECT_THROW(tracker.follow(fewer, {}, target), InvalidInput);
  EXPECT_THROW(tracker.follow(mesh.positions, fewer, target), InvalidInput);
  EXPECT_THROW(SurfaceTracker(mesh, Signal::Zero(3, 3)), InvalidInput);
  EXPECT_THROW(TrackTarget(mesh, Signal::Zero(3, 3)), InvalidInput);
}

}  // namespace
}  // namespace mq
