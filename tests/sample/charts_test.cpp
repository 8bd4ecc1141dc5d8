#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <numbers>
#include <set>

#include "fixtures.h"
#include "mq/base/error.h"
#include "mq/mesh/geometry.h"
#include "mq/sample/detail/flatten.h"
#include "mq/sample/implicit.h"
#include "mq/sample/noise.h"
#include "mq/sample/detail/pack.h"
#include "mq/sample/detail/segment.h"

namespace mq {
namespace {

using std::numbers::pi;

TEST(Noise, VanishesOnTheLatticeAndIsSmooth) {
  const Noise noise(1);
  EXPECT_NEAR(noise({3, -2, 7}), 0, 1e-15);
  const Random random(1);
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const Vector3 p(random.uniform(3 * i, -300, 300), random.uniform(3 * i + 1, -300, 300),
                    std::floor(random.uniform(3 * i + 2, -300, 300)));  // where two cells meet
    const Vector3 step(0, 0, 1e-5);
    EXPECT_LT(std::abs(noise(p)), 1.1);
    EXPECT_NEAR(noise(p + step) - noise(p), noise(p) - noise(p - step), 1e-8);
  }
}

TEST(Noise, DiffersBetweenSeedsOnly) {
  EXPECT_EQ(Noise(1)({0.3, 0.4, 0.5}), Noise(1)({0.3, 0.4, 0.5}));
  EXPECT_NE(Noise(1)({0.3, 0.4, 0.5}), Noise(2)({0.3, 0.4, 0.5}));
}

TEST(SmoothUnion, IsTheUnionAwayFromWhereTheSolidsMeet) {
  EXPECT_EQ(smooth_union(0.1, 0.9, 0.5), 0.1);
  EXPECT_DOUBLE_EQ(smooth_union(0.2, 0.2, 0.4), 0.1);  // rounded by a quarter of k
}

TEST(MeshOfSolid, LiesOnTheSurfaceWithEvenTriangles) {
  const auto sphere = [](const Vector3& p) { return p.norm() - 0.8; };
  const Mesh mesh = mesh_of_solid(sphere, {.triangles = 5000});
  const Surface surface = make_surface(mesh);
  EXPECT_TRUE(surface.defects.empty());
  EXPECT_NEAR(mesh.triangle_count(), 5000, 300);
  for (const Vector3& p : mesh.positions) EXPECT_NEAR(p.norm(), 0.8, 1e-4);
  EXPECT_GT(triangle_normal(mesh, 0).dot(mesh.position(0, 0)), 0);  // outward
  EXPECT_NEAR(surface.area, 4 * pi * 0.64, 0.02);                   // edges of 0.06 are chords
  for (int t = 0; t < mesh.triangle_count(); ++t)
    EXPECT_GT(corner_angles(mesh, t).minCoeff(), 10 * pi / 180);
  EXPECT_THROW(mesh_of_solid(sphere, {.triangles = 500, .euler_characteristic = 0}), InvalidInput);
}

TEST(Segment, MakesAsManyDiscsAsAsked) {
  const Surface surface = make_surface(fixtures::torus(60, 40));
  for (const int charts : {8, 30, 500}) {
    const std::vector<int> chart = segment(surface, {.charts = charts, .unevenness = 0.5});
    EXPECT_EQ(std::ssize(std::set(chart.begin(), chart.end())), charts);
    EXPECT_EQ(flatten(surface, seams_between(surface, chart)).count, charts);  // or it throws
  }
}

TEST(Segment, UsesMoreChartsWhereASurfaceNeedsThem) {
  const Surface surface = make_surface(fixtures::torus(30, 20));
  const std::vector<int> chart = segment(surface, {.charts = 1});
  EXPECT_GT(flatten(surface, seams_between(surface, chart)).count, 1);
}

TEST(SeamsAlongTree, CutASphereToOneDisc) {
  const Surface surface = make_surface(fixtures::sphere(4));
  for (const int tips : {1, 2, 7}) {
    const std::vector<char> seams = seams_along_tree(surface, 0, tips);
    for (HalfEdge h = 0; h < HalfEdge(seams.size()); ++h)
      EXPECT_EQ(seams[h], seams[surface.twins[h]]);
    EXPECT_EQ(flatten(surface, seams).count, 1);
  }
}

/// J of the map from a triangle, isometric in the plane, to its chart.
Eigen::Matrix2d jacobian(const Mesh& mesh, const FlatCharts& flat, int t) {
  const Vector3 a = mesh.position(t, 1) - mesh.position(t, 0);
  const Vector3 b = mesh.position(t, 2) - mesh.position(t, 0);
  Eigen::Matrix2d rest, image;
  rest << a.norm(), a.dot(b) / a.norm(), 0, a.cross(b).norm() / a.norm();
  const auto uv = [&](int k) { return flat.uvs[flat.corner_uvs[t][k]]; };
  image << Vector2(uv(1) - uv(0)), Vector2(uv(2) - uv(0));
  return image * rest.inverse();
}

TEST(Flatten, IsAnIsometryWhereThereIsOne) {
  Mesh mesh = fixtures::flat_square(12, 0.2);
  for (Vector3& p : mesh.positions)  // rolled to a part of a cone around the z-axis
    p = Vector3(std::cos(p.x()) * (1 + p.y()), std::sin(p.x()) * (1 + p.y()), 2 * p.y());
  mesh.uvs.clear();
  mesh.corner_uvs.clear();
  const Surface surface = make_surface(mesh);
  const FlatCharts flat = flatten(surface, std::vector<char>(surface.twins.size()), {200, 1e-9});
  double worst = 0;
  for (int t = 0; t < surface.triangle_count(); ++t) {
    const Eigen::Matrix2d J = jacobian(mesh, flat, t);
    EXPECT_GT(J.determinant(), 0);
    worst = std::max(worst, (J.transpose() * J - Eigen::Matrix2d::Identity()).norm());
  }
  EXPECT_LT(worst, 0.03);  // the triangles are chords: nearly, not exactly developable
}

TEST(Flatten, NeverTurnsATriangleOver) {
  const Mesh mesh = fixtures::sphere(4);
  const Surface surface = make_surface(mesh);
  const FlatCharts flat = flatten(surface, seams_along_tree(surface, 0, 1));
  for (int t = 0; t < surface.triangle_count(); ++t)
    EXPECT_GT(jacobian(mesh, flat, t).determinant(), 0);
}

TEST(Flatten, RefusesWhatIsNoDisc) {
  const Surface torus = make_surface(fixtures::torus(8, 6));
  EXPECT_THROW(flatten(torus, std::vector<char>(torus.twins.size())), InvalidInput);
  Mesh strip = fixtures::torus(8, 6);
  strip.triangles.resize(32);  // two rows of cells: an annulus
  const Surface annulus = make_surface(strip);
  EXPECT_THROW(flatten(annulus, std::vector<char>(annulus.twins.size())), InvalidInput);
  Mesh thin = fixtures::one_triangle();
  thin.positions[2] = thin.positions[1];
  EXPECT_THROW(flatten(make_surface(thin), std::vector<char>(3)), InvalidInput);
}

TEST(Pack, KeepsChartsApartByTheGutter) {
  const Surface surface = make_surface(fixtures::sphere(4));
  const FlatCharts flat =
      flatten(surface, seams_between(surface, segment(surface, {.charts = 20})));
  Mesh mesh = surface.mesh;
  mesh.uvs = flat.uvs;
  mesh.corner_uvs = flat.corner_uvs;
  const int size = 256;
  const double gutter = 5;
  pack(mesh, flat.charts, {.texture_size = size, .gutter = gutter});
  std::vector<int> owner(mesh.uvs.size());
  for (int t = 0; t < mesh.triangle_count(); ++t)
    for (const int uv : mesh.corner_uvs[t]) owner[uv] = flat.charts[t];
  double nearest = size;
  for (std::size_t i = 0; i < mesh.uvs.size(); ++i) {
    EXPECT_GE(mesh.uvs[i].minCoeff() * size, gutter / 2 - 1e-9);
    EXPECT_LE(mesh.uvs[i].maxCoeff() * size, size - gutter / 2 + 1e-9);
    for (std::size_t j = 0; j < i; ++j)
      if (owner[i] != owner[j])
        nearest = std::min(nearest, (mesh.uvs[i] - mesh.uvs[j]).cwiseAbs().maxCoeff() * size);
  }
  EXPECT_GE(nearest, gutter - 1e-9);
  EXPECT_LT(nearest, gutter + 2);
}

TEST(Pack, GivesAllChartsTheSameScale) {
  Mesh mesh = fixtures::two_chart_quad();
  for (int k = 3; k < 6; ++k) mesh.uvs[k] *= 2;
  pack(mesh, {0, 1}, {.texture_size = 100});
  const auto area = [&](int t) {
    const Vector2 a = mesh.uv(t, 1) - mesh.uv(t, 0), b = mesh.uv(t, 2) - mesh.uv(t, 0);
    return std::abs(a.x() * b.y() - a.y() * b.x());
  };
  EXPECT_NEAR(area(1) / area(0), 4, 1e-9);
}

}  // namespace
}  // namespace mq
