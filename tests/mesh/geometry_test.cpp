#include "mq/mesh/geometry.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "fixtures.h"
#include "mq/base/error.h"

namespace mq {
namespace {

using namespace fixtures;
using std::numbers::pi;

TEST(Geometry, MeasuresARightTriangle) {
  const Mesh mesh = one_triangle();
  EXPECT_DOUBLE_EQ(triangle_area(mesh, 0), 0.5);
  EXPECT_TRUE(triangle_normal(mesh, 0).isApprox(Vector3(0, 0, 1)));
  EXPECT_TRUE(corner_angles(mesh, 0).isApprox(Vector3(pi / 2, pi / 4, pi / 4)));
  EXPECT_NEAR(mean_edge_length(make_surface(mesh)), (2 + std::sqrt(2.0)) / 3, 1e-15);
}

TEST(Geometry, CountsEachEdgeOnce) {
  EXPECT_NEAR(mean_edge_length(make_surface(flat_square(1))), (4 + std::sqrt(2.0)) / 5, 1e-15);
}

TEST(Geometry, AnglesSumToPiInAnyTriangle) {
  const Random random(2);
  for (std::uint64_t i = 0; i < 1000; ++i) {
    Mesh mesh = one_triangle();
    const double flat = std::pow(10, -random.uniform(10 * i, 0, 14));
    for (std::uint64_t k = 0; k < 3; ++k)
      mesh.positions[k] = {random.uniform(10 * i + 1 + k), flat * random.uniform(10 * i + 4 + k),
                           0};
    EXPECT_NEAR(corner_angles(mesh, 0).sum(), pi, 1e-14);
  }
}

TEST(Geometry, HasNoNormalWhereThereIsNoArea) {
  Mesh mesh = one_triangle();
  mesh.positions[2] = mesh.positions[1];
  EXPECT_EQ(triangle_area(mesh, 0), 0);
  EXPECT_EQ(triangle_normal(mesh, 0), Vector3::Zero());
  EXPECT_EQ(vertex_normals(mesh)[0], Vector3::Zero());
  EXPECT_TRUE(corner_angles(mesh, 0).allFinite());
}

TEST(VertexNormals, DoNotDependOnHowAFaceIsTriangulated) {
  // The corner of a cube: one of its three faces is cut into two triangles at the corner.
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.9, 0.4, 0}};
  mesh.triangles = {{0, 1, 4}, {0, 4, 2}, {0, 2, 3}, {0, 3, 1}};
  EXPECT_TRUE(vertex_normals(mesh)[0].isApprox(Vector3(1, 1, 1).normalized(), 1e-15));
}

TEST(VertexNormals, AreRadialOnASphere) {
  const Mesh mesh = sphere(5);
  const std::vector<Vector3> normals = vertex_normals(mesh);
  for (int v = 0; v < mesh.vertex_count(); ++v)
    EXPECT_NEAR(normals[v].dot(mesh.positions[v]), 1, 2e-3);
}

TEST(BoundingBox, LooksOnlyAtVerticesInUse) {
  Mesh mesh = flat_square(3);
  mesh.positions.emplace_back(1e9, 0, 0);
  const Box box = bounding_box(mesh);
  EXPECT_EQ(box.low, Vector3(0, 0, 0));
  EXPECT_EQ(box.high, Vector3(1, 1, 0));
  EXPECT_DOUBLE_EQ(box.diagonal(), std::sqrt(2.0));
}

/// A torus with inner vertices moved along it, so that nothing is symmetric.
Mesh jittered_torus(int n, double R, double r) {
  Mesh mesh = torus(2 * n, n, R, r);
  const Random random(1);
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const double a = (v % (2 * n) + random.uniform(2 * std::uint64_t(v), -0.25, 0.25)) * pi / n;
    const double b =
        (v / (2 * n) + random.uniform(2 * std::uint64_t(v) + 1, -0.25, 0.25)) * 2 * pi / n;
    const double rho = R + r * std::cos(b);
    mesh.positions[v] = {rho * std::cos(a), rho * std::sin(a), r * std::sin(b)};
  }
  return mesh;
}

struct TorusError {
  double curvature = 0;  // largest, of both
  double direction = 0;  // sine of the angle
  double triangle = 0;   // largest curvature error of triangles
};

TorusError torus_error(int n) {
  const double R = 1, r = 0.4;
  const Surface surface = make_surface(jittered_torus(n, R, r));
  const auto exact = [&](const Vector3& p) {
    const double rho = std::hypot(p.x(), p.y());
    return (rho - R) / r / rho;  // cos(b) / (R + r cos(b))
  };
  const auto curvatures = vertex_curvatures(surface);
  TorusError error;
  for (int v = 0; v < surface.mesh.vertex_count(); ++v) {
    const Vector3& p = surface.mesh.positions[v];
    const auto& k = curvatures[v];
    error.curvature =
        std::max({error.curvature, std::abs(k.max - 1 / r), std::abs(k.min - exact(p))});
    const Vector3 around = Vector3(-p.y(), p.x(), 0).normalized();
    error.direction = std::max(error.direction, around.cross(k.min_direction).norm());
    EXPECT_NEAR(k.max_direction.dot(k.min_direction), 0, 1e-12);
    EXPECT_NEAR(k.max_direction.norm(), 1, 1e-12);
  }
  const auto triangles = triangle_curvatures(surface, curvatures);
  for (int t = 0; t < surface.triangle_count(); ++t) {
    const Mesh& mesh = surface.mesh;
    const Vector3 p = (mesh.position(t, 0) + mesh.position(t, 1) + mesh.position(t, 2)) / 3;
    error.triangle = std::max({error.triangle, std::abs(triangles[t].max - 1 / r),
                               std::abs(triangles[t].min - exact(p))});
  }
  return error;
}

TEST(Curvature, ConvergesWithOrderTwoOnATorus) {
  const TorusError coarse = torus_error(40), fine = torus_error(80), finest = torus_error(160);
  EXPECT_GT(std::log2(coarse.curvature / fine.curvature), 1.7);
  EXPECT_GT(std::log2(fine.curvature / finest.curvature), 1.7);
  EXPECT_GT(std::log2(fine.direction / finest.direction), 1.7);
  EXPECT_GT(std::log2(fine.triangle / finest.triangle), 1.7);
  EXPECT_LT(finest.curvature, 0.01);
}

TEST(Curvature, ConvergesToOneOverTheRadiusOfASphere) {
  const auto error = [](int levels) {
    Mesh mesh = sphere(levels);
    for (Vector3& p : mesh.positions) p *= 3;
    double largest = 0;
    for (const auto& k : vertex_curvatures(make_surface(mesh)))
      largest = std::max({largest, std::abs(3 * k.max - 1), std::abs(3 * k.min - 1)});
    return largest;
  };
  EXPECT_LT(error(5), 0.02);
  EXPECT_GT(std::log2(error(5) / error(6)), 1.7);
}

TEST(Curvature, HasTheSignOfTheOrientation) {
  Mesh mesh = sphere(4);
  for (Triangle& t : mesh.triangles) std::swap(t[0], t[1]);
  const auto k = vertex_curvatures(make_surface(mesh));
  EXPECT_NEAR(k[0].mean(), -1, 0.01);
  EXPECT_NEAR(k[0].gauss(), 1, 0.02);
}

TEST(Curvature, ScalesWithOneOverLength) {
  Mesh mesh = torus(30, 20);
  const auto k = vertex_curvatures(make_surface(mesh));
  for (Vector3& p : mesh.positions) p *= 1e-20;
  const auto scaled = vertex_curvatures(make_surface(mesh));
  for (std::size_t v = 0; v < k.size(); ++v) EXPECT_NEAR(scaled[v].max * 1e-20, k[v].max, 1e-8);
}

TEST(Curvature, VanishesOnPlanesUpToTheBoundary) {
  for (const auto& k : vertex_curvatures(make_surface(flat_square(8, 0.2)))) {
    EXPECT_NEAR(k.max, 0, 1e-9);
    EXPECT_NEAR(k.min, 0, 1e-9);
  }
}

TEST(Curvature, IsFiniteWhereThereIsLittleToFit) {
  Mesh lonely = one_triangle();
  lonely.positions.push_back({0, 0, 0});
  lonely.triangles.push_back({3, 3, 0});
  lonely.corner_uvs = lonely.triangles;
  lonely.uvs.resize(4, Vector2::Zero());
  for (const Mesh& mesh : {one_triangle(), tetrahedron(), nonmanifold_edge(), lonely}) {
    const Surface surface = make_surface(mesh);
    const auto vertices = vertex_curvatures(surface);
    for (const auto& k : vertices) {
      EXPECT_TRUE(std::isfinite(k.max) && std::isfinite(k.min));
      EXPECT_TRUE(k.max_direction.allFinite() && k.min_direction.allFinite());
    }
    for (const auto& k : triangle_curvatures(surface, vertices)) EXPECT_TRUE(std::isfinite(k.max));
  }
  EXPECT_THROW(vertex_curvatures(make_surface(one_triangle()), {.rings = 0}), InvalidInput);
}

}  // namespace
}  // namespace mq
