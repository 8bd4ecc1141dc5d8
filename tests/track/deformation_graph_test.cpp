#include "mq/track/deformation_graph.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "mq/base/error.h"
#include "mq/sample/sample.h"

namespace mq {
namespace {

Surface ball() { return make_surface(make_sample("sphere", {.triangles = 3000}).mesh); }

NodeMotion some_motion() {
  return {Eigen::AngleAxisd(0.3, Vector3(1, 2, -1).normalized()).toRotationMatrix(),
          Vector3(0.2, -0.1, 0.05)};
}

/// x ↦ R x + t.
std::vector<Vector3> moved(const std::vector<Vector3>& points, const NodeMotion& motion) {
  std::vector<Vector3> result;
  for (const Vector3& p : points) result.push_back(motion.rotation * p + motion.translation);
  return result;
}

/// Springs of unit weight that pull every vertex to its place.
std::vector<PointConstraint> constrained_to(const std::vector<Vector3>& now,
                                            const std::vector<Vector3>& to) {
  std::vector<PointConstraint> constraints(now.size());
  for (std::size_t v = 0; v < now.size(); ++v)
    constraints[v].add(Eigen::Matrix3d::Identity() / double(now.size()), to[v] - now[v]);
  return constraints;
}

double largest_distance(const std::vector<Vector3>& a, const std::vector<Vector3>& b) {
  double most = 0;
  for (std::size_t v = 0; v < a.size(); ++v) most = std::max(most, (a[v] - b[v]).norm());
  return most;
}

TEST(DeformationGraph, SharesEveryVertexAmongNearNodes) {
  const Surface surface = ball();
  const DeformationGraph graph(surface, 0.3);
  EXPECT_GT(graph.node_count(), 60);  // 4π / 0.3² ≈ 140 squares
  EXPECT_LT(graph.node_count(), 300);
  for (int v = 0; v < surface.mesh.vertex_count(); ++v) {
    double sum = 0, nearest = 1e9;
    for (int k = 0; k < DeformationGraph::most_influences; ++k) {
      const double weight = graph.influence(v).weights[k];
      EXPECT_GE(weight, 0);
      sum += weight;
      if (weight > 0)
        nearest =
            std::min(nearest, (surface.mesh.positions[v] -
                               surface.mesh.positions[graph.vertex_of(graph.influence(v).nodes[k])])
                                  .norm());
    }
    EXPECT_NEAR(sum, 1, 1e-14);
    EXPECT_LT(nearest, 0.3);
  }
}

TEST(DeformationGraph, ReproducesRigidMotionsExactly) {
  const Surface surface = ball();
  const DeformationGraph graph(surface, 0.3);
  const std::vector<Vector3> to = moved(surface.mesh.positions, some_motion());
  const auto motions = graph.fitted(surface.mesh.positions, to);
  for (const NodeMotion& m : motions)
    EXPECT_LT((m.rotation - some_motion().rotation).norm(), 1e-12);
  EXPECT_LT(largest_distance(graph.deformed(surface.mesh.positions, motions), to), 1e-12);
}

TEST(DeformationGraph, FindsARigidMotionInAFewSteps) {
  const Surface surface = ball();
  DeformationGraph graph(surface, 0.3);
  const std::vector<Vector3>& from = surface.mesh.positions;
  const std::vector<Vector3> to = moved(from, some_motion());
  std::vector<NodeMotion> motions(std::size_t(graph.node_count()));
  const std::vector<NodeMotion> unturned = motions;
  std::vector<double> errors;
  for (int i = 0; i < 8; ++i) {
    const auto now = graph.deformed(from, motions);
    errors.push_back(largest_distance(now, to));
    graph.gauss_newton_step(from, constrained_to(now, to), from, unturned, {10, 0}, motions);
  }
  EXPECT_GT(errors[0], 0.1);
  EXPECT_LT(errors.back(), 1e-9);
}

TEST(DeformationGraph, StaysWhereNothingPulls) {
  const Surface surface = ball();
  DeformationGraph graph(surface, 0.3);
  const std::vector<Vector3>& from = surface.mesh.positions;
  std::vector<NodeMotion> motions(std::size_t(graph.node_count()));
  const std::vector<NodeMotion> unturned = motions;
  graph.gauss_newton_step(from, std::vector<PointConstraint>(from.size()), from, unturned, {1, 0},
                          motions);
  EXPECT_LT(largest_distance(graph.deformed(from, motions), from), 1e-14);
}

TEST(DeformationGraph, CarriesAlongWhatNothingPulls) {
  // Only the upper half is pulled upward; stiff edges take the lower half with it.
  const Surface surface = ball();
  DeformationGraph graph(surface, 0.3);
  const std::vector<Vector3>& from = surface.mesh.positions;
  std::vector<NodeMotion> motions(std::size_t(graph.node_count()));
  const std::vector<NodeMotion> unturned = motions;
  for (int i = 0; i < 5; ++i) {
    const auto now = graph.deformed(from, motions);
    std::vector<PointConstraint> constraints(from.size());
    for (std::size_t v = 0; v < from.size(); ++v)
      if (from[v].y() > 0)
        constraints[v].add(Eigen::Matrix3d::Identity(), from[v] + Vector3(0, 0.5, 0) - now[v]);
    graph.gauss_newton_step(from, constraints, from, unturned, {1, 0}, motions);
  }
  const auto now = graph.deformed(from, motions);
  for (std::size_t v = 0; v < from.size(); ++v)
    EXPECT_LT((now[v] - from[v] - Vector3(0, 0.5, 0)).norm(), 1e-3);
}

TEST(DeformationGraph, ComesBackToTheShapeAtBirthWhereElastic) {
  // Blown up by a tenth since birth; nothing but the centre is held.
  const Surface surface = ball();
  DeformationGraph graph(surface, 0.3);
  const std::vector<Vector3>& rest = surface.mesh.positions;
  std::vector<Vector3> from = rest;
  for (Vector3& p : from) p *= 1.1;
  const auto mean_radius = [](const std::vector<Vector3>& points) {
    double sum = 0;
    for (const Vector3& p : points) sum += p.norm();
    return sum / double(points.size());
  };
  for (const double elasticity : {0.0, 0.5, 1.0}) {
    std::vector<NodeMotion> motions(std::size_t(graph.node_count()));
    const auto turned = graph.fitted(rest, from);
    std::vector<PointConstraint> constraints(from.size());
    constraints[0].add(1e-3 * Eigen::Matrix3d::Identity(), Vector3::Zero());
    for (int i = 0; i < 10; ++i)
      graph.gauss_newton_step(from, constraints, rest, turned, {1, elasticity}, motions);
    std::vector<Vector3> now = graph.deformed(from, motions);
    // Nodes move together; each still carries its own neighbourhood as it was.
    Vector3 centre = Vector3::Zero();
    std::vector<Vector3> nodes;
    for (int i = 0; i < graph.node_count(); ++i) nodes.push_back(now[graph.vertex_of(i)]);
    for (const Vector3& p : nodes) centre += p / double(nodes.size());
    for (Vector3& p : nodes) p -= centre;
    EXPECT_NEAR(mean_radius(nodes), 1.1 - 0.1 * elasticity, 0.01) << elasticity;
  }
}

TEST(DeformationGraph, IsTheSameForAnyNumberOfThreads) {
  const Surface surface = ball();
  const std::vector<Vector3>& from = surface.mesh.positions;
  std::vector<Vector3> to = from;
  for (Vector3& p : to) p.x() += 0.2 * std::sin(2 * p.y());
  const auto run = [&](int threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism,
                                      std::size_t(threads));
    DeformationGraph graph(surface, 0.3);
    std::vector<NodeMotion> motions(std::size_t(graph.node_count()));
    const std::vector<NodeMotion> unturned = motions;
    for (int i = 0; i < 3; ++i)
      graph.gauss_newton_step(from, constrained_to(graph.deformed(from, motions), to), from,
                              unturned, {0.1, 0.2}, motions);
    return graph.deformed(from, motions);
  };
  const auto one = run(1);
  EXPECT_EQ(one, run(2));
  EXPECT_EQ(one, run(7));
}

TEST(DeformationGraph, RefusesASpacingThatIsNone) {
  EXPECT_THROW(DeformationGraph(ball(), 0), InvalidInput);
  EXPECT_THROW(DeformationGraph(ball(), std::nan("")), InvalidInput);
}

}  // namespace
}  // namespace mq
