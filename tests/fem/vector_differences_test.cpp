#include "mq/fem/vector_differences.h"

#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include "fem/flat_torus.h"
#include "fixtures.h"
#include "linear/matrices.h"
#include "mq/base/error.h"
#include "mq/fem/intrinsic_delaunay.h"
#include "mq/fem/vector_basis.h"
#include "mq/fem/vertex_frames.h"

namespace mq {
namespace {

using test::random_signal;

constexpr DualCentre both[] = {DualCentre::circumcentre, DualCentre::barycentre};

TEST(VectorDifferences, AreSymmetricAndSemidefiniteOnAnyMesh) {
  Mesh sheared = fixtures::flat_square(6, 0.2);
  for (Vector3& p : sheared.positions) p.x() += 5 * p.y();
  sheared.uvs.clear(), sheared.corner_uvs.clear();
  for (const Mesh& mesh : {sheared, fixtures::sphere(2), fixtures::moebius_strip(12)})
    for (const DualCentre centre : both) {
      const Surface surface = make_surface(mesh);
      const Eigen::MatrixXd S = vector_differences(surface, flat_triangles(surface), centre);
      EXPECT_LE((S - S.transpose()).cwiseAbs().maxCoeff(), 1e-12 * S.cwiseAbs().maxCoeff());
      const Vector lambda = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(S).eigenvalues();
      EXPECT_GE(lambda[0], -1e-12 * lambda[lambda.size() - 1]);
    }
}

TEST(VectorDifferences, VanishOnConstantFieldsOfThePlane) {
  const Surface surface = make_surface(fixtures::flat_square(9, 0.2));
  const std::vector<Vector3> constant(surface.triangle_count(), Vector3(0.6, -0.8, 0));
  const Vector X = field_in_frames(surface, constant);
  for (const DualCentre centre : both) {
    const SparseMatrix S = vector_differences(surface, flat_triangles(surface), centre);
    EXPECT_LE((S * X).cwiseAbs().maxCoeff(), 1e-12);
    const Eigen::MatrixXd dense = S;
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(dense).eigenvalues()[2], 1e-3);
  }
}

/// A strip of equilateral triangles, X = (x, 0) at the centres: neighbours have a side of length
/// l√3 between them, and 2·A_ij/l² = |e|/|l| = √3.
TEST(VectorDifferences, WeighEquilateralTrianglesByTheRootOfThree) {
  Mesh mesh;
  const double height = std::sqrt(3.0) / 2;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0.5, height, 0}, {1.5, height, 0}};
  mesh.triangles = {{0, 1, 2}, {1, 3, 2}};
  const Surface surface = make_surface(mesh);
  const Vector X = field_in_frames(surface, {Vector3(2, 0, 0), Vector3(5, 0, 0)});
  for (const DualCentre centre : both)
    EXPECT_NEAR(X.dot(vector_differences(surface, flat_triangles(surface), centre) * X),
                std::sqrt(3.0) * 9, 1e-12);
}

TEST(VectorDifferences, DoNotDependOnWhereATriangleBegins) {
  const Mesh mesh = fixtures::sphere(2);
  Mesh turned_mesh = mesh;
  for (int t = 0; t < mesh.triangle_count(); ++t)
    std::rotate(turned_mesh.triangles[t].begin(), turned_mesh.triangles[t].begin() + t % 3,
                turned_mesh.triangles[t].end());
  std::vector<Vector3> field;
  for (int t = 0; t < mesh.triangle_count(); ++t)
    field.push_back(Vector3(1, 2, 3).cross(mesh.position(t, 0)));
  for (const DualCentre centre : both) {
    const auto energy = [&](const Mesh& m) {
      const Surface surface = make_surface(m);
      const Vector X = field_in_frames(surface, field);
      return X.dot(vector_differences(surface, flat_triangles(surface), centre) * X);
    };
    EXPECT_NEAR(energy(turned_mesh), energy(mesh), 1e-10 * energy(mesh));
  }
}

TEST(VectorDifferences, DoNotSeeWhereTheSurfaceLies) {
  Mesh moved = fixtures::torus(12, 8);
  const Surface here = make_surface(moved);
  const Eigen::AngleAxisd turn(0.7, Vector3(1, 2, 3).normalized());
  for (Vector3& p : moved.positions) p = 3 * (turn * p) + Vector3(1, 2, 3);
  const Surface there = make_surface(moved);
  const SparseMatrix difference = vector_differences(here, flat_triangles(here)) -
                                  vector_differences(there, flat_triangles(there));
  EXPECT_LE(difference.coeffs().abs().maxCoeff(), 1e-11);
}

/// Two triangles over an edge of length 2, each of this height over its middle.
Surface kite(double height) {
  Mesh mesh;
  mesh.positions = {{-1, 0, 0}, {1, 0, 0}, {0, height, 0}, {0, -height, 0}};
  mesh.triangles = {{0, 1, 2}, {1, 0, 3}};
  return make_surface(mesh);
}

/// 2·A/|l|² = 2/(cot α + cot β), each angle 2·atan(1/h) with cot = (h − 1/h)/2: of h = ½ it is −4/3, and of h = 1
/// infinite.
TEST(VectorDifferences, AsPrintedAreNegativeWhereAnEdgeIsNotDelaunay) {
  const Surface obtuse = kite(0.5), acute = kite(2), circle = kite(1);
  const auto energy = [](const Surface& surface, DualCentre centre) {
    const Vector X = field_in_frames(surface, {Vector3(2, 0, 0), Vector3(5, 0, 0)});
    return X.dot(vector_differences(surface, flat_triangles(surface), centre) * X);
  };
  EXPECT_NEAR(energy(obtuse, DualCentre::circumcentre_as_printed), -4.0 / 3 * 9, 1e-12);
  EXPECT_NEAR(energy(obtuse, DualCentre::circumcentre), 200 * 9, 1e-9);
  EXPECT_NEAR(energy(acute, DualCentre::circumcentre_as_printed), 4.0 / 3 * 9, 1e-12);
  EXPECT_NEAR(energy(acute, DualCentre::circumcentre), 4.0 / 3 * 9, 1e-12);
  const DualWeights weights = dual_weights(obtuse, flat_triangles(obtuse));
  EXPECT_EQ(weights.edges, 1);
  EXPECT_EQ(weights.negative, 1);
  EXPECT_EQ(weights.on_a_circle, 0);
  EXPECT_EQ(dual_weights(acute, flat_triangles(acute)).negative, 0);
  EXPECT_EQ(dual_weights(circle, flat_triangles(circle)).on_a_circle, 1);
  const std::string error =
      fixtures::error_of([&] { energy(circle, DualCentre::circumcentre_as_printed); });
  EXPECT_NE(error.find("1 of 1 edges lie between two triangles on one circle"), std::string::npos) << error;
}

TEST(VectorDifferences, RefuseSizesThatDoNotFit) {
  const Surface surface = make_surface(fixtures::sphere(1));
  EXPECT_THROW(vector_differences(surface, {}), InvalidInput);
}

TEST(IntrinsicDelaunay, LeavesNoNegativeWeight) {
  Mesh sheared = fixtures::flat_square(8, 0.2);
  for (Vector3& p : sheared.positions) p.x() += 5 * p.y();
  sheared.uvs.clear(), sheared.corner_uvs.clear();
  for (const Mesh& mesh : {sheared, fixtures::torus(40, 5), fixtures::sphere(3)}) {
    const Surface surface = make_surface(mesh);
    const IntrinsicTriangulation d = intrinsic_delaunay(surface);
    double area = 0;
    for (HalfEdge h = 0; h < 3 * surface.triangle_count(); ++h) {
      const HalfEdge twin = d.surface.twins[h];
      if (h % 3 == 0) area += d.shapes[h / 3].area();
      if (twin < 0) continue;
      EXPECT_EQ(d.surface.twins[twin], h);
      EXPECT_EQ(d.surface.mesh.triangles[h / 3][h % 3],
                d.surface.mesh.triangles[twin / 3][(twin + 1) % 3]);
      EXPECT_NEAR(d.shapes[h / 3].edge(h % 3).norm(), d.shapes[twin / 3].edge(twin % 3).norm(),
                  1e-12);
      EXPECT_GE(d.shapes[h / 3].half_cotangent((h % 3 + 2) % 3) +
                    d.shapes[twin / 3].half_cotangent((twin % 3 + 2) % 3),
                -1e-9);
    }
    EXPECT_NEAR(area, surface.area, 1e-12 * surface.area);
  }
}

/// Flipping changes functions' energies, and never raises one (Rippa 1990).
TEST(IntrinsicDelaunay, DoesNotRaiseTheEnergyOfAnySignal) {
  Mesh ellipsoid = fixtures::sphere(4);
  for (Vector3& p : ellipsoid.positions) p.x() *= 5;
  const Surface surface = make_surface(ellipsoid);
  const IntrinsicTriangulation d = intrinsic_delaunay(surface);
  ASSERT_GT(d.flips, 100);
  const Vector phi = random_signal(surface.mesh.vertex_count(), 1);
  const double before = phi.dot(VertexSpace(surface).stiffness() * phi);
  EXPECT_LE(phi.dot(VertexSpace(d.surface, d.shapes).stiffness() * phi), before);
}

TEST(IntrinsicDelaunay, KeepsDelaunayTriangulationsAsTheyAre) {
  const Surface surface = make_surface(fixtures::torus(16, 10));
  const IntrinsicTriangulation d = intrinsic_delaunay(surface);
  EXPECT_EQ(d.flips, 0);
  EXPECT_EQ(d.surface.mesh.triangles, surface.mesh.triangles);
}

/// In a plane triangulated badly, a linear signal keeps its gradient.
TEST(IntrinsicDelaunay, KeepsTheMetric) {
  Mesh sheared = fixtures::flat_square(8, 0.2);
  for (Vector3& p : sheared.positions) p.x() += 5 * p.y();
  sheared.uvs.clear(), sheared.corner_uvs.clear();
  const IntrinsicTriangulation d = intrinsic_delaunay(make_surface(sheared));
  ASSERT_GT(d.flips, 20);
  Vector phi(d.surface.mesh.vertex_count());
  for (int v = 0; v < phi.size(); ++v)
    phi[v] = d.surface.mesh.positions[v].dot(Vector3(0.3, 0.4, 0));
  const Signal gradient = VertexSpace(d.surface, d.shapes).gradient(phi);
  for (int t = 0; t < d.surface.triangle_count(); ++t)
    EXPECT_NEAR(gradient.block(2 * t, 0, 2, 1).norm(), 0.5, 1e-12);
}

/// A unit vector that has this direction in the plane, at every vertex in its frame.
Vector constant_at_vertices(const Surface& surface, const VertexFrames& frames, double direction) {
  Vector z(2 * surface.mesh.vertex_count());
  for (HalfEdge h = 0; h < 3 * surface.triangle_count(); ++h) {
    const int v = surface.mesh.triangles[h / 3][h % 3],
              w = surface.mesh.triangles[h / 3][(h + 1) % 3];
    const Vector3 edge = surface.mesh.positions[w] - surface.mesh.positions[v];
    const double angle = direction - std::atan2(edge.y(), edge.x()) + frames.at_source[h];
    z.segment<2>(2 * v) = Vector2(std::cos(angle), std::sin(angle));
  }
  return z;
}

void expect_constant(const Surface& surface, const Vector& X, double direction) {
  for (const Vector3& value : field_in_space(surface, X))
    EXPECT_LE((value - Vector3(std::cos(direction), std::sin(direction), 0)).norm(), 1e-12);
}

TEST(VertexBasis, ProlongatesConstantFieldsOfThePlaneExactly) {
  const Surface surface = make_surface(fixtures::flat_square(9, 0.2));
  const auto shapes = flat_triangles(surface);
  const VertexFrames frames = vertex_frames(surface, shapes);
  const Vector z = constant_at_vertices(surface, frames, 0.4);
  expect_constant(surface, vertex_prolongation(surface, shapes, frames) * z, 0.4);
}

TEST(VertexBasis, HasTheCirculationOfConstantFieldsOfThePlaneExactly) {
  const Surface surface = make_surface(fixtures::flat_square(9, 0.2));
  const auto shapes = flat_triangles(surface);
  const VertexFrames frames = vertex_frames(surface, shapes);
  const Edges edges = make_edges(surface, shapes);
  const Vector omega =
      circulation_along_edges(surface, shapes, frames, edges) * constant_at_vertices(surface, frames, 0.4);
  for (int e = 0; e < edges.count(); ++e) {
    const auto [i, j] = edges.vertices[std::size_t(e)];
    const Vector3 along = surface.mesh.positions[std::size_t(j)] - surface.mesh.positions[std::size_t(i)];
    EXPECT_NEAR(omega[e], along.dot(Vector3(std::cos(0.4), std::sin(0.4), 0)), 1e-13);
  }
  expect_constant(surface, whitney_prolongation(edges, shapes) * omega, 0.4);
}

/// On the sphere the field of a rotation comes out to the second order.
TEST(VertexBasis, ProlongatesRotationsOfTheSphereToSecondOrder) {
  std::vector<double> errors;
  for (const int level : {3, 4, 5}) {
    const Surface surface = make_surface(fixtures::sphere(level));
    const auto shapes = flat_triangles(surface);
    const VertexFrames frames = vertex_frames(surface, shapes);
    const Mesh& mesh = surface.mesh;
    const Vector3 axis(0.2, 0.3, 1);
    Vector z(2 * mesh.vertex_count());
    for (HalfEdge h = 0; h < 3 * surface.triangle_count(); ++h) {
      if (frames.at_source[h] != 0) continue;
      const int v = mesh.triangles[h / 3][h % 3], w = mesh.triangles[h / 3][(h + 1) % 3];
      const Vector3 n = mesh.positions[v], X = axis.cross(n);
      const Vector3 first = (mesh.positions[w] - n.dot(mesh.positions[w]) * n).normalized();
      z.segment<2>(2 * v) = Vector2(X.dot(first), X.dot(n.cross(first)));
    }
    const Vector field = vertex_prolongation(surface, shapes, frames) * z;
    std::vector<Vector3> exact;  // what of it lies in the triangle
    for (int t = 0; t < surface.triangle_count(); ++t)
      exact.push_back(axis.cross(
          (mesh.position(t, 0) + mesh.position(t, 1) + mesh.position(t, 2)).normalized()));
    const Vector difference = field - field_in_frames(surface, exact);
    errors.push_back(std::sqrt(difference.dot(triangle_mass(shapes) * difference) / surface.area));
  }
  EXPECT_LE(errors[2], 2e-3);
  EXPECT_GE(std::log2(errors[1] / errors[2]), 1.9);
}

}  // namespace
}  // namespace mq
