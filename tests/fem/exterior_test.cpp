#include "mq/fem/exterior.h"

#include <cmath>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "fem/flat_torus.h"
#include "fem/handlebody.h"
#include "fixtures.h"
#include "linear/matrices.h"
#include "mq/base/error.h"
#include "mq/fem/vertex_frames.h"
#include "mq/linear/eigen.h"

namespace mq {
namespace {

using test::flat_torus;
using test::handlebody;
using test::random_signal;
using test::whitney_operators;
using test::WhitneyOperators;

Edges edges_of(const Surface& surface) { return make_edges(surface, flat_triangles(surface)); }

std::vector<Surface> samples() {
  return {make_surface(fixtures::flat_square(7, 0.2)), make_surface(fixtures::sphere(2)),
          make_surface(fixtures::torus(16, 10)), make_surface(fixtures::moebius_strip(12)),
          make_surface(fixtures::nonmanifold_edge()), make_surface(handlebody(2, 2))};
}

TEST(Edges, AreAsManyAsEulerSays) {
  for (const Surface& surface : samples())
    EXPECT_EQ(surface.mesh.vertex_count() - edges_of(surface).count() + surface.triangle_count(),
              surface.euler_characteristic);
}

TEST(Edges, RunAlongTheirLowestHalfEdge) {
  const Surface surface = make_surface(fixtures::sphere(2));
  const Edges edges = edges_of(surface);
  for (HalfEdge h = 0; h < 3 * surface.triangle_count(); ++h) {
    const Triangle& t = surface.mesh.triangles[h / 3];
    const auto& [source, target] = edges.vertices[edges.from_half_edge[h]];
    const bool along = h < surface.twins[h];
    EXPECT_EQ(edges.sign[h], along ? 1 : -1);
    EXPECT_EQ(along ? source : target, t[h % 3]);
    EXPECT_EQ(along ? target : source, t[(h + 1) % 3]);
  }
}

TEST(Edges, OfTrianglesWithoutAreaAreLeftOut) {
  Mesh mesh = fixtures::flat_square(3);
  mesh.uvs.clear(), mesh.corner_uvs.clear();
  const int before = edges_of(make_surface(mesh)).count();
  mesh.positions.insert(mesh.positions.end(), {{2, 0, 0}, {3, 0, 0}, {4, 0, 0}});
  const int lone = mesh.vertex_count() - 3;
  mesh.triangles.push_back({lone, lone + 1, lone + 2});
  EXPECT_EQ(edges_of(make_surface(mesh)).count(), before);
}

TEST(ExteriorDerivative, AppliedTwiceIsExactlyZero) {
  for (const Surface& surface : samples()) {
    const Edges edges = edges_of(surface);
    const SparseMatrix zero = d1(edges) * d0(edges, surface.mesh.vertex_count());
    EXPECT_EQ(zero.coeffs().size() == 0 ? 0 : zero.coeffs().abs().maxCoeff(), 0);
  }
}

TEST(ExteriorDerivative, IsTargetMinusSource) {
  const Surface surface = make_surface(fixtures::one_triangle());
  const Edges edges = edges_of(surface);
  const Vector phi = Vector3(1, 10, 100);
  const Vector omega = d0(edges, 3) * phi;
  for (int e = 0; e < 3; ++e)
    EXPECT_EQ(omega[e], phi[edges.vertices[e][1]] - phi[edges.vertices[e][0]]);
}

TEST(ExteriorDerivative, SatisfiesStokesOnARegion) {
  const Surface surface = make_surface(fixtures::sphere(2));
  const Edges edges = edges_of(surface);
  const Vector omega = random_signal(edges.count(), 1);
  const Vector curl = d1(edges) * omega;
  double inside = 0, around = 0;
  const int region = surface.triangle_count() / 3;
  for (int t = 0; t < region; ++t) inside += curl[t];
  for (HalfEdge h = 0; h < 3 * region; ++h)
    if (surface.twins[h] >= 3 * region)
      around += edges.sign[h] * omega[edges.from_half_edge[h]];
  EXPECT_NEAR(inside, around, 1e-13);
}

TEST(ExteriorDerivative, OfARotationIsTwiceTheArea) {
  const Surface surface = make_surface(fixtures::flat_square(9, 0.2));
  const Edges edges = edges_of(surface);
  Vector omega(edges.count());
  for (int e = 0; e < edges.count(); ++e) {
    const Vector3& a = surface.mesh.positions[edges.vertices[e][0]];
    const Vector3& b = surface.mesh.positions[edges.vertices[e][1]];
    const Vector3 middle = (a + b) / 2;
    omega[e] = Vector3(-middle.y(), middle.x(), 0).dot(b - a);
  }
  const Vector curl = d1(edges) * omega;
  const auto shapes = flat_triangles(surface);
  for (int t = 0; t < surface.triangle_count(); ++t)
    EXPECT_NEAR(curl[t] / shapes[t].area(), 2, 1e-12);
}

TEST(HodgeStars, ShareTheAreaAmongVertices) {
  for (const Surface& surface : samples())
    for (const VertexArea kind : {VertexArea::barycentric, VertexArea::mixed}) {
      const auto shapes = flat_triangles(surface);
      const HodgeStars stars = hodge_stars(make_edges(surface, shapes), surface.mesh.triangles,
                                           shapes, surface.mesh.vertex_count(), kind);
      EXPECT_NEAR(stars.zero.sum(), surface.area, 1e-13 * surface.area);
      EXPECT_GT(stars.zero.minCoeff(), 0);
    }
}

TEST(HodgeStars, GiveTheStiffness) {
  for (const Surface& surface : samples()) {
    const auto shapes = flat_triangles(surface);
    const Edges edges = make_edges(surface, shapes);
    const int n = surface.mesh.vertex_count();
    const HodgeStars stars = hodge_stars(edges, surface.mesh.triangles, shapes, n);
    const SparseMatrix D = d0(edges, n);
    const Eigen::MatrixXd S = SparseMatrix(D.transpose() * diagonal_matrix(stars.one)) * D;
    EXPECT_LE((S - Eigen::MatrixXd(VertexSpace(surface).stiffness())).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(HodgeStars, OfVerticesStayPositiveOnObtuseTriangles) {
  Mesh mesh = fixtures::flat_square(6, 0.2);
  for (Vector3& p : mesh.positions) p.x() += 5 * p.y();
  mesh.uvs.clear(), mesh.corner_uvs.clear();
  const Surface surface = make_surface(mesh);
  const auto shapes = flat_triangles(surface);
  const HodgeStars stars = hodge_stars(make_edges(surface, shapes), surface.mesh.triangles, shapes,
                                       surface.mesh.vertex_count());
  EXPECT_LT(stars.one.minCoeff(), 0);
  EXPECT_GT(stars.zero.minCoeff(), 0);
}

TEST(HodgeLaplacian, IsSymmetricAndSemidefinite) {
  for (const Surface& surface : samples()) {
    const Eigen::MatrixXd S = whitney_operators(surface, flat_triangles(surface)).laplacian;
    EXPECT_LE((S - S.transpose()).cwiseAbs().maxCoeff(), 1e-12 * S.cwiseAbs().maxCoeff());
    const Vector lambda = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(S).eigenvalues();
    EXPECT_GE(lambda[0], -1e-12 * lambda[lambda.size() - 1]);
  }
}

/// With the diagonal ⋆₁, and with the Whitney mass in its place.
TEST(HodgeLaplacian, HasTwiceTheGenusAsItsNullSpace) {
  const std::vector<Mesh> meshes{fixtures::sphere(3), fixtures::torus(24, 12), handlebody(2, 3),
                                 handlebody(4, 3)};
  const std::vector<int> genus{0, 1, 2, 4};
  for (int m = 0; m < 4; ++m) {
    const Surface surface = make_surface(meshes[m]);
    const WhitneyOperators w = whitney_operators(surface, flat_triangles(surface));
    for (const SparseMatrix& S : {w.laplacian, hodge_laplacian(w.edges, w.stars, w.mass)}) {
      const Vector lambda = smallest_eigenpairs(S, w.mass, {.count = 12}).values;
      for (int k = 0; k < 2 * genus[m]; ++k)
        EXPECT_LE(std::abs(lambda[k]), 1e-8 * lambda[2 * genus[m]]) << "genus " << genus[m];
      EXPECT_GT(lambda[2 * genus[m]], 0.01);
    }
  }
}

TEST(HodgeLaplacian, HasOneNullFieldPerFurtherBoundary) {
  Mesh annulus = fixtures::torus(24, 12), disc = fixtures::flat_square(8, 0.2);
  annulus.triangles.resize(2 * 24 * 7);
  disc.uvs.clear(), disc.corner_uvs.clear();
  const auto spectrum = [](const Mesh& mesh) {
    const Surface surface = make_surface(mesh);
    const WhitneyOperators w = whitney_operators(surface, flat_triangles(surface));
    return smallest_eigenpairs(w.laplacian, w.mass, {.count = 3}).values;
  };
  EXPECT_GT(spectrum(disc)[0], 1);
  EXPECT_LE(std::abs(spectrum(annulus)[0]), 1e-8 * spectrum(annulus)[1]);
  EXPECT_GT(spectrum(annulus)[1], 0.1);
}

TEST(HodgeLaplacian, VanishesOnConstantFieldsOfTheFlatTorus) {
  const test::FlatTorus torus = flat_torus(20, 0.2);
  const WhitneyOperators w = whitney_operators(torus.surface, torus.shapes);
  const double side = 2 * std::numbers::pi;
  Vector omega(w.edges.count());
  for (int e = 0; e < w.edges.count(); ++e) {
    const Vector2 d = torus.positions[w.edges.vertices[e][1]] - torus.positions[w.edges.vertices[e][0]];
    omega[e] = 0.6 * std::remainder(d.x(), side) - 0.8 * std::remainder(d.y(), side);
  }
  EXPECT_LE((w.laplacian * omega).cwiseAbs().maxCoeff(), 1e-11);
  EXPECT_NEAR(omega.dot(w.mass * omega), side * side, 1e-11);
}

TEST(ConnectionLaplacian, IsSymmetricAndVanishesOnParallelFieldsOfThePlane) {
  const Surface surface = make_surface(fixtures::flat_square(9, 0.2));
  const SparseMatrix L = connection_laplacian(surface, flat_triangles(surface));
  EXPECT_LE((Eigen::MatrixXd(L) - Eigen::MatrixXd(L.transpose())).cwiseAbs().maxCoeff(), 1e-13);
  const HodgeStars stars = hodge_stars(edges_of(surface), surface.mesh.triangles,
                                       flat_triangles(surface), surface.mesh.vertex_count());
  const Vector lambda =
      smallest_eigenpairs(L, vertex_area_mass(stars.zero), {.count = 4}).values;
  EXPECT_LE(std::abs(lambda[1]), 1e-10);
  EXPECT_GT(lambda[2], 1);
}

TEST(ConnectionLaplacian, HasTheSpectrumOfTheFlatTorus) {
  const test::FlatTorus torus = flat_torus(32);
  const HodgeStars stars =
      hodge_stars(make_edges(torus.surface, torus.shapes), torus.surface.mesh.triangles,
                  torus.shapes, torus.surface.mesh.vertex_count());
  const Vector lambda = smallest_eigenpairs(connection_laplacian(torus.surface, torus.shapes),
                                            vertex_area_mass(stars.zero), {.count = 12}).values;
  for (int k = 0; k < 12; ++k) EXPECT_NEAR(lambda[k], k < 2 ? 0 : k < 10 ? 1 : 2, 0.02) << k;
}

TEST(ExteriorCalculus, RefusesSizesThatDoNotFit) {
  const Surface surface = make_surface(fixtures::sphere(1));
  const std::vector<FlatTriangle> none;
  EXPECT_THROW(make_edges(surface, none), InvalidInput);
  EXPECT_THROW(connection_laplacian(surface, none), InvalidInput);
  const WhitneyOperators w = whitney_operators(surface, flat_triangles(surface));
  EXPECT_THROW(hodge_laplacian(w.edges, w.stars, SparseMatrix(3, 3)), InvalidInput);
}

}  // namespace
}  // namespace mq
