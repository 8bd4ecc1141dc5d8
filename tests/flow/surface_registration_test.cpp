#include "mq/flow/surface_registration.h"

#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "fixtures.h"
#include "mq/base/error.h"
#include "mq/sample/noise.h"
#include "mq/sample/shapes.h"

namespace mq {
namespace {

/// Noise over the sphere, none of it where z < `plain_below`.
Signal colours(const Mesh& mesh, const Eigen::AngleAxisd& turned_back, double plain_below) {
  const Noise noise(7);
  Signal values(mesh.vertex_count(), 3);
  for (int v = 0; v < values.rows(); ++v) {
    const Vector3 p = turned_back * mesh.positions[v];
    const double share = smooth_step(plain_below, plain_below + 0.2, p.z());
    for (int c = 0; c < 3; ++c) values(v, c) = share * noise(2 * p + Vector3(31.4, 7.3, 3.7) * c);
  }
  return values;
}

Vector3 place(const Mesh& mesh, const SurfacePoint& p) {
  Vector3 x = Vector3::Zero();
  for (int k = 0; k < 3; ++k) x += p.barycentric[k] * mesh.position(p.triangle, k);
  return x;
}

/// A sphere turned in itself: closest points see nothing of it, colours do. Both have triangles of
/// their own.
TEST(RegisterByColour, SeesASphereTurnInItself) {
  const double angle = 0.2;
  const Surface source = make_surface(fixtures::sphere(5)),
                target = make_surface(cube_sphere(20).mesh);
  const Eigen::AngleAxisd turn(angle, Vector3(0.3, 0.2, 1).normalized());
  MeshFlowOptions options;
  options.largest = {15, Length::Unit::percent};
  options.detail = {0, Length::Unit::percent};
  const ColourRegistration found =
      register_by_colour(source, colours(source.mesh, Eigen::AngleAxisd::Identity(), -3), target,
                         colours(target.mesh, turn.inverse(), -3), options);
  double before = 0, after = 0;
  for (int v = 0; v < source.mesh.vertex_count(); ++v) {
    const Vector3 truth = turn * source.mesh.positions[v];
    before += (place(target.mesh, found.closest[v]) - truth).norm();
    after += (place(target.mesh, found.points[v]) - truth).norm();
    EXPECT_GE(found.confidences[v], 0);
    EXPECT_LE(found.confidences[v], 1);
  }
  EXPECT_LE(after, 0.1 * before);
}

TEST(RegisterByColour, DoesNotTrustPlainColours) {
  const Surface source = make_surface(fixtures::sphere(5)),
                target = make_surface(cube_sphere(20).mesh);
  const Eigen::AngleAxisd turn(0.1, Vector3::UnitZ());
  const ColourRegistration found =
      register_by_colour(source, colours(source.mesh, Eigen::AngleAxisd::Identity(), 0), target,
                         colours(target.mesh, turn.inverse(), 0));
  double plain = 0, painted = 0;
  int plain_count = 0, painted_count = 0;
  for (int v = 0; v < source.mesh.vertex_count(); ++v) {
    const double z = source.mesh.positions[v].z();
    if (z < -0.2) plain += found.confidences[v], ++plain_count;
    if (z > 0.3) painted += found.confidences[v], ++painted_count;
  }
  EXPECT_LE(plain / plain_count, 0.05 * painted / painted_count);
  EXPECT_GT(painted / painted_count, 0.2);
}

TEST(RegisterByColour, StaysWhereColoursAgree) {
  const Surface source = make_surface(fixtures::sphere(4));
  const Signal same = colours(source.mesh, Eigen::AngleAxisd::Identity(), -3);
  const ColourRegistration found = register_by_colour(source, same, source, same);
  for (int v = 0; v < source.mesh.vertex_count(); ++v)
    EXPECT_LE((place(source.mesh, found.points[v]) - source.mesh.positions[v]).norm(), 1e-12);
}

TEST(RegisterByColour, RefusesColoursThatDoNotFit) {
  const Surface source = make_surface(fixtures::sphere(2));
  const Signal few = Signal::Zero(3, 3), three = Signal::Zero(source.mesh.vertex_count(), 3);
  EXPECT_THROW(register_by_colour(source, few, source, three), InvalidInput);
  EXPECT_THROW(register_by_colour(source, three, source, three.leftCols(1)), InvalidInput);
  EXPECT_THROW(register_by_colour(source, three, source, few), InvalidInput);
}

}  // namespace
}  // namespace mq
