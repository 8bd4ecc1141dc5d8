// What holds for tracking whatever its settings: units, parts that are missing, the last of its levels.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <queue>

#include "fixtures.h"
#include "mq/mesh/geometry.h"
#include "mq/sample/sample.h"
#include "mq/track/deformation_graph.h"
#include "mq/track/rest_shape.h"
#include "mq/track/track_truth.h"
#include "mq/track/tracking.h"
#include "sample/moving_bodies.h"

namespace mq {
namespace {

Mesh scaled(Mesh mesh, double factor) {
  for (Vector3& p : mesh.positions) p *= factor;
  return mesh;
}

TrackedFrame follow_bend(double unit, const TrackOptions& options) {
  const MovingOptions moving{.triangles = 2000};
  const Mesh rest = scaled(make_moving_frame("bending", 0, moving).mesh, unit);
  const TrackTarget target(scaled(make_moving_frame("bending", 8, moving).mesh, unit));
  return SurfaceTracker(rest, {}, options).follow(rest.positions, {}, target);
}

TEST(TrackingLaws, NoUnitIsPreferred) {
  const TrackOptions options{.node_spacing = 0.1};
  const TrackedFrame one = follow_bend(1, options);
  for (const double unit : {1.0 / 1024, 1024.0}) {
    const TrackedFrame other = follow_bend(unit, options);
    double worst = 0;
    for (std::size_t v = 0; v < one.positions.size(); ++v)
      worst = std::max(worst, (other.positions[v] / unit - one.positions[v]).norm());
    EXPECT_LT(worst, 1e-6) << unit;
  }
}

TEST(TrackingLaws, TheLastLevelHasTheLastStiffness) {
  // Graphs that begin as good as rigid and are not snapped lie on the surface in the end, and are no more
  // distorted than one that has its last stiffness from the beginning.
  TrackOptions options{.node_spacing = 0.1, .iterations = 12, .snaps = {}};
  options.levels = 1;
  const double direct = follow_bend(1, options).distortion.p95;
  options.first_stiffness = 1e8 * options.last_stiffness;
  for (const int levels : {2, 3}) {
    options.levels = levels;
    const TrackedFrame found = follow_bend(1, options);
    EXPECT_LT(found.distance.p95, 0.005) << levels;
    EXPECT_LT(found.distortion.p95 - 1, 1.5 * (direct - 1)) << levels;
  }
}

TEST(TrackingLaws, WhatHasNoCounterpartGoesAlong) {
  const Mesh ball = make_sample("sphere", {.triangles = 3000}).mesh;
  const Vector3 move(0.03, 0.02, 0);
  Mesh open = ball;
  std::erase_if(open.triangles, [&](const Triangle& t) {
    return std::ranges::any_of(t, [&](int v) { return ball.positions[v].z() > 0.6; });
  });
  open.corner_uvs.clear();
  for (Vector3& p : open.positions) p += move;
  const TrackedFrame found = SurfaceTracker(ball, {}, {.node_spacing = 0.1}).follow(ball.positions, {}, TrackTarget(open));
  EXPECT_LT(found.matched, 0.95);
  double worst = 0, top = 0;
  for (int v = 0; v < ball.vertex_count(); ++v) {
    ASSERT_TRUE(found.positions[v].allFinite()) << v;
    const double off = std::abs((found.positions[v] - move).norm() - 1);
    double& kind = ball.positions[v].z() > 0.6 ? top : worst;
    kind = std::max(kind, off);
  }
  EXPECT_LT(worst, 0.01);
  EXPECT_LT(top, 0.05);
}

TEST(TrackingLaws, AHandleOfTheFrameLeavesNoDent) {
  // A thorn that the template has not: its sides, which nothing of the template is near, do not pull.
  const Mesh ball = make_sample("sphere", {.triangles = 3000}).mesh;
  Mesh thorny = ball;
  const Vector3 top = Vector3(1, 2, 2).normalized();
  for (Vector3& p : thorny.positions) {
    const double angle = std::acos(std::clamp(p.normalized().dot(top), -1.0, 1.0));
    if (angle < 0.2) p *= 1 + 1.2 * (1 - angle / 0.2);
  }
  const TrackedFrame found =
      SurfaceTracker(ball, {}, {.node_spacing = 0.1}).follow(ball.positions, {}, TrackTarget(thorny));
  double worst = 0;
  for (const Vector3& p : found.positions) worst = std::max(worst, std::abs(p.norm() - 1));
  EXPECT_LT(worst, 0.2);  // of a thorn as long as 1.2
}

TEST(TrackingLaws, SecondsAreOfItsParts) {
  const MovingOptions moving{.triangles = 1500};
  const MovingFrame rest = make_moving_frame("spinning", 0, moving), next = make_moving_frame("spinning", 1, moving);
  const TrackedFrame found = SurfaceTracker(rest.mesh, colours_of(rest), {.node_spacing = 0.15, .colour_cycles = 1})
                                 .follow(rest.mesh.positions, {}, TrackTarget(next.mesh, colours_of(next)));
  const auto& seconds = found.seconds;
  for (const double part : {seconds.correspond, seconds.solve, seconds.colour, seconds.snap, seconds.measure})
    EXPECT_GT(part, 0);
  EXPECT_LE(seconds.correspond + seconds.solve + seconds.colour + seconds.snap + seconds.measure, 1.001 * seconds.total);
}

TEST(DriftSummary, IsOfThoseThatAreKnown) {
  std::vector<double> drifts;
  for (int i = 0; i < 100; ++i) drifts.insert(drifts.end(), {-1.0, double((37 * i) % 100)});
  const DriftSummary found = summary(drifts);
  EXPECT_EQ(found.known, 100);
  EXPECT_NEAR(found.mean, 49.5, 1e-12);
  EXPECT_EQ(found.p95, 95);
  EXPECT_EQ(found.max, 99);
  EXPECT_EQ(summary({-1, -1}).known, 0);
}

TEST(RestShape, KnowsNoUnits) {
  const Mesh now = fixtures::sphere(2);
  std::vector<std::array<Vector3, 3>> rest;
  for (int t = 0; t < now.triangle_count(); ++t) {
    rest.emplace_back();
    for (int k = 0; k < 3; ++k) {
      const Vector3 p = now.position(t, k);
      rest.back()[k] = {1.3 * p.x(), 0.8 * p.y(), p.z() + 0.1 * p.x()};
    }
  }
  const std::vector<Vector3> one = rest_shape(now, rest);
  const double worst = worst_distortion(now, rest);
  EXPECT_GT(worst, 1.2);
  for (const double unit : {1.0 / (1 << 20), 1024.0}) {
    auto rest_there = rest;
    for (auto& corners : rest_there)
      for (Vector3& p : corners) p *= unit;
    const std::vector<Vector3> other = rest_shape(scaled(now, unit), rest_there);
    for (std::size_t v = 0; v < one.size(); ++v) ASSERT_LT((other[v] / unit - one[v]).norm(), 1e-9) << unit;
    EXPECT_NEAR(worst_distortion(scaled(now, unit), rest_there), worst, 1e-9 * worst) << unit;
  }
}

/// Distances along the edges of a mesh from a vertex.
std::vector<double> along_edges(const Mesh& mesh, int from) {
  std::vector<double> distance(mesh.positions.size(), std::numeric_limits<double>::infinity());
  distance[from] = 0;
  for (bool changes = true; changes;) {
    changes = false;
    for (const Triangle& t : mesh.triangles)
      for (int k = 0; k < 3; ++k) {
        const int i = t[k], j = t[(k + 1) % 3];
        const double length = (mesh.positions[i] - mesh.positions[j]).norm();
        for (const auto& [a, b] : {std::pair(i, j), std::pair(j, i)})
          if (distance[a] + length < distance[b]) distance[b] = distance[a] + length, changes = true;
      }
  }
  return distance;
}

TEST(DeformationGraph, WeighsTheFourNearestNodesByTheFifth) {
  const Surface surface = make_surface(fixtures::sphere(3));
  constexpr double spacing = 0.5;
  const DeformationGraph graph(surface, spacing);
  std::vector<std::vector<double>> from_nodes;
  for (int i = 0; i < graph.node_count(); ++i) from_nodes.push_back(along_edges(surface.mesh, graph.vertex_of(i)));
  for (int v = 0; v < surface.mesh.vertex_count(); ++v) {
    std::vector<std::pair<double, int>> nearest;
    for (int i = 0; i < graph.node_count(); ++i) nearest.emplace_back(from_nodes[i][v], i);
    std::ranges::sort(nearest);
    if (nearest[4].first - nearest[3].first < 1e-9) continue;  // which is the fourth is open
    const double fifth = std::min(nearest[4].first, 2 * spacing);
    std::vector<double> wanted(std::size_t(graph.node_count()), 0), found = wanted;
    double sum = 0;
    for (int n = 0; n < 4; ++n) {
      wanted[nearest[n].second] = std::pow(std::max(0.0, 1 - nearest[n].first / fifth), 2);
      sum += wanted[nearest[n].second];
    }
    const DeformationGraph::Influence& influence = graph.influence(v);
    for (std::size_t k = 0; k < influence.nodes.size(); ++k) found[influence.nodes[k]] += influence.weights[k];
    for (int i = 0; i < graph.node_count(); ++i) ASSERT_NEAR(found[i], wanted[i] / sum, 1e-9) << v << ", " << i;
  }
}

}  // namespace
}  // namespace mq
