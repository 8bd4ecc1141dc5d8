#include "mq/fem/vector_basis.h"

#include <cmath>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "fem/flat_torus.h"
#include "fem/handlebody.h"
#include "fixtures.h"
#include "linear/matrices.h"
#include "mq/linear/eigen.h"

namespace mq {
namespace {

using test::flat_torus;
using test::FlatTorus;
using test::random_signal;

/// ∫ ⟨X, ds⟩ along the edges of a plane mesh, X constant.
Vector integrals(const Surface& surface, const Edges& edges, const Vector3& X) {
  Vector omega(edges.count());
  for (int e = 0; e < edges.count(); ++e)
    omega[e] = X.dot(surface.mesh.positions[edges.vertices[e][1]] -
                     surface.mesh.positions[edges.vertices[e][0]]);
  return omega;
}

TEST(TriangleBasis, HasTheAreaAsItsMass) {
  const Surface surface = make_surface(fixtures::flat_square(5, 0.2));
  const std::vector<Vector3> constant(surface.triangle_count(), Vector3(0.6, 0.8, 0));
  const Vector X = field_in_frames(surface, constant);
  EXPECT_NEAR(X.dot(triangle_mass(flat_triangles(surface)) * X), 1, 1e-13);
}

TEST(WhitneyBasis, ReproducesConstantFields) {
  const Surface surface = make_surface(fixtures::flat_square(9, 0.2));
  const auto shapes = flat_triangles(surface);
  const Edges edges = make_edges(surface, shapes);
  const Vector3 X(0.3, -1.1, 0);
  const Vector omega = integrals(surface, edges, X);
  const Vector field = whitney_prolongation(edges, shapes) * omega;
  for (const Vector3& value : field_in_space(surface, field)) EXPECT_LE((value - X).norm(), 1e-13);
  EXPECT_NEAR(omega.dot(whitney_mass(edges, shapes) * omega), X.squaredNorm(), 1e-13);
}

TEST(WhitneyBasis, MatchesThePrintedProlongation) {
  const Surface surface = make_surface(fixtures::one_triangle());
  const auto shapes = flat_triangles(surface);
  const Edges edges = make_edges(surface, shapes);
  const Vector3 ij_jk_ki(0.7, -0.4, 1.9);  // one triangle: edges are half-edges
  const Vector2 printed(2 * ij_jk_ki[0] - ij_jk_ki[1] - ij_jk_ki[2],
                        ij_jk_ki[0] + ij_jk_ki[1] - 2 * ij_jk_ki[2]);
  const Vector found = whitney_prolongation(edges, shapes) * ij_jk_ki;
  EXPECT_LE((found - printed / 3).norm(), 1e-15);  // (2.15) with g = 1
}

TEST(WhitneyBasis, OfADerivativeIsTheGradient) {
  const Surface surface = make_surface(fixtures::sphere(2));
  const VertexSpace space(surface);
  const Edges edges = make_edges(surface, space.shapes());
  const Vector phi = random_signal(space.size(), 1);
  const Vector omega = d0(edges, space.size()) * phi;
  EXPECT_LE((whitney_prolongation(edges, space.shapes()) * omega - space.gradient(phi))
                .cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_NEAR(omega.dot(whitney_mass(edges, space.shapes()) * omega),
              phi.dot(space.stiffness() * phi), 1e-11);
}

TEST(WhitneyBasis, IntegratesToItsCoefficientAlongEachEdge) {
  const Surface surface = make_surface(fixtures::sphere(1));
  const auto shapes = flat_triangles(surface);
  const Edges edges = make_edges(surface, shapes);
  const Vector omega = random_signal(edges.count(), 1);
  for (HalfEdge h = 0; h < 3 * surface.triangle_count(); ++h) {
    Vector3 middle = Vector3::Constant(0.5);
    middle[(h % 3 + 2) % 3] = 0;
    const Vector2 value = whitney_value(edges, shapes[h / 3], h / 3, middle, omega);
    EXPECT_NEAR(value.dot(shapes[h / 3].edge(h % 3)),
                edges.sign[h] * omega[edges.from_half_edge[h]], 1e-13);
  }
}

TEST(WhitneyMass, IsTheRuleOfEdgeMiddles) {
  const Surface surface = make_surface(fixtures::torus(8, 6));
  const auto shapes = flat_triangles(surface);
  const Edges edges = make_edges(surface, shapes);
  const Vector omega = random_signal(edges.count(), 1), eta = random_signal(edges.count(), 1, 2);
  double integral = 0;
  for (int t = 0; t < surface.triangle_count(); ++t)
    for (int k = 0; k < 3; ++k) {
      Vector3 middle = Vector3::Constant(0.5);
      middle[k] = 0;
      integral += shapes[t].area() / 3 *
                  whitney_value(edges, shapes[t], t, middle, omega)
                      .dot(whitney_value(edges, shapes[t], t, middle, eta));
    }
  EXPECT_NEAR(omega.dot(whitney_mass(edges, shapes) * eta), integral, 1e-12);
}

/// The thesis' mass samples the barycentre alone; on a regular triangulation it is singular.
TEST(WhitneyMass, IsDefiniteWhereTheOnePointRuleIsSingular) {
  const FlatTorus torus = flat_torus(16);
  const Edges edges = make_edges(torus.surface, torus.shapes);
  const auto smallest = [](const SparseMatrix& M) {
    const SparseMatrix I = diagonal_matrix(Vector::Ones(M.rows()));
    return smallest_eigenpairs(M, I, {.count = 1}).values[0];
  };
  EXPECT_GE(smallest(whitney_mass(edges, torus.shapes)), 0.3);
  const SparseMatrix P = whitney_prolongation(edges, torus.shapes);
  const SparseMatrix weighted = triangle_mass(torus.shapes) * P;
  EXPECT_LE(std::abs(smallest(P.transpose() * weighted)), 1e-14);
}

/// The rotation about the middle of each triangle, which the one-point rule does not see.
TEST(WhitneyMass, OfOnePointLosesTheRotationInTriangles) {
  const FlatTorus torus = flat_torus(12, 0.2);
  const Edges edges = make_edges(torus.surface, torus.shapes);
  const SparseMatrix exact = whitney_mass(edges, torus.shapes),
                     one = whitney_mass(edges, torus.shapes, WhitneyMass::one_point);
  const Vector omega = random_signal(edges.count(), 1);
  const Vector curl = d1(edges) * omega;
  double lost = 0;
  for (std::size_t t = 0; t < torus.shapes.size(); ++t) {
    double sides = 0;
    for (int k = 0; k < 3; ++k) sides += torus.shapes[t].edge(k).squaredNorm();
    lost += sides / (144 * torus.shapes[t].area()) * curl[Eigen::Index(t)] * curl[Eigen::Index(t)];
  }
  EXPECT_GT(lost, 0.1);
  EXPECT_NEAR(omega.dot(exact * omega) - omega.dot(one * omega), lost, 1e-12 * lost);
  // A gradient has no curl: it is constant in triangles, and both agree.
  const int vertices = torus.surface.mesh.vertex_count();
  const Vector gradient = d0(edges, vertices) * random_signal(vertices, 1, 2);
  EXPECT_NEAR(gradient.dot(one * gradient), gradient.dot(exact * gradient), 1e-11 * gradient.dot(exact * gradient));
}

TEST(WhitneyMass, OfOnePointIsSingularWhereTrianglesCanBeColouredBlackAndWhite) {
  const auto null_space = [](const Mesh& mesh) {
    const Surface surface = make_surface(mesh);
    const auto shapes = flat_triangles(surface);
    const Edges edges = make_edges(surface, shapes);
    const Eigen::MatrixXd M = whitney_mass(edges, shapes, WhitneyMass::one_point);
    const Vector values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(M, Eigen::EigenvaluesOnly).eigenvalues();
    const auto found = (values.array() < 1e-9 * values.maxCoeff()).count();
    EXPECT_EQ(massless_rotations(edges, shapes), found);
    return found;
  };
  EXPECT_EQ(null_space(fixtures::torus(8, 6)), 1);
  EXPECT_EQ(null_space(fixtures::beside(fixtures::torus(8, 6), fixtures::torus(6, 6))), 2);
  Mesh square = fixtures::flat_square(5, 0.2);
  square.uvs.clear(), square.corner_uvs.clear();
  EXPECT_EQ(null_space(square), 1);
  EXPECT_EQ(null_space(fixtures::one_triangle()), 1);
  EXPECT_EQ(null_space(fixtures::tetrahedron()), 0);  // an odd number of triangles around each vertex
  EXPECT_EQ(null_space(fixtures::sphere(2)), 0);
  null_space(fixtures::moebius_strip(12));
}

TEST(GradientBasis, ProlongatesToGradientsAndTurnedGradients) {
  const VertexSpace space(make_surface(fixtures::sphere(2)));
  const Vector phi = random_signal(space.size(), 1);
  Vector kappa = Vector::Zero(2 * space.size()), xi = kappa;
  kappa.head(space.size()) = phi;
  xi.tail(space.size()) = phi;
  const SparseMatrix P = gradient_prolongation(space);
  const Vector gradient = space.gradient(phi), turned_gradient = P * xi;
  EXPECT_LE((P * kappa - gradient).cwiseAbs().maxCoeff(), 1e-13);
  for (int t = 0; t < space.triangle_count(); ++t)
    EXPECT_LE((turned_gradient.segment<2>(2 * t) - mq::turned(gradient.segment<2>(2 * t))).norm(), 1e-12);
}

TEST(GradientMass, IsTheStiffnessTwiceOnAClosedSurface) {
  const VertexSpace space(make_surface(fixtures::torus(16, 10)));
  const int n = space.size();
  const Eigen::MatrixXd M = gradient_mass(space), S = space.stiffness();
  EXPECT_LE((M.topLeftCorner(n, n) - S).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LE((M.bottomRightCorner(n, n) - S).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LE(M.topRightCorner(n, n).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(GradientMass, CouplesGradientsAndTurnedGradientsAtABoundary) {
  const VertexSpace space(make_surface(fixtures::flat_square(5, 0.2)));
  const Eigen::MatrixXd M = gradient_mass(space);
  EXPECT_GT(M.topRightCorner(space.size(), space.size()).cwiseAbs().maxCoeff(), 0.4);
}

TEST(GradientMass, HasOneConstantOfEachKindInItsNullSpace) {
  const VertexSpace space(make_surface(fixtures::sphere(2)));
  const Vector lambda =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(Eigen::MatrixXd(gradient_mass(space))).eigenvalues();
  EXPECT_LE(std::abs(lambda[1]), 1e-13);
  EXPECT_GT(lambda[2], 0.01);
}

}  // namespace
}  // namespace mq
