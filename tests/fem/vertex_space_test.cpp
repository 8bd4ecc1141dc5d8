#include "mq/fem/vertex_space.h"

#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "fem/flat_torus.h"
#include "fixtures.h"
#include "linear/matrices.h"
#include "mq/base/error.h"
#include "mq/mesh/surface_point.h"

namespace mq {
namespace {

using test::flat_torus;
using test::random_signal;

std::vector<Surface> surfaces() {
  return {make_surface(fixtures::one_triangle()),      make_surface(fixtures::flat_square(9, 0.2)),
          make_surface(fixtures::sphere(3)),           make_surface(fixtures::torus(20, 12)),
          make_surface(fixtures::moebius_strip(12)),   make_surface(fixtures::nonmanifold_edge()),
          make_surface(fixtures::nonmanifold_vertex())};
}

/// The vertices of flat_square(n) that are not on its border.
bool inner(const Vector3& p) { return p.x() > 0 && p.x() < 1 && p.y() > 0 && p.y() < 1; }

Vector coordinate(const Surface& surface, int axis) {
  Vector values(surface.mesh.vertex_count());
  for (int v = 0; v < values.size(); ++v) values[v] = surface.mesh.positions[v][axis];
  return values;
}

TEST(FlatTriangle, HasTheGradientsOfItsHatFunctions) {
  const FlatTriangle shape = flat_triangle(Vector3(1, 2, 0.5), Vector3(-0.3, 1, 2));
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < 3; ++i)
      EXPECT_NEAR(shape.gradient(k).dot(shape.corner(i) - shape.corner(0)),
                  (i == k) - (k == 0), 1e-15);
}

TEST(FlatTriangle, HasTheAnglesOfTheTriangleInSpace) {
  const std::array<Vector3, 3> p{Vector3(0, 0, 0), Vector3(1, 2, 0.5), Vector3(-0.3, 1, 2)};
  const FlatTriangle shape = flat_triangle(p[1] - p[0], p[2] - p[0]);
  for (int k = 0; k < 3; ++k) {
    const Vector3 a = p[(k + 1) % 3] - p[k], b = p[(k + 2) % 3] - p[k];
    EXPECT_NEAR(shape.half_cotangent(k), 0.5 * a.dot(b) / a.cross(b).norm(), 1e-15);
  }
}

TEST(FlatTriangle, TurnsBy90DegreesCounterClockwise) {
  const Vector2 v(0.3, -1.7);
  EXPECT_EQ(turned(v).dot(v), 0);
  EXPECT_EQ(turned(v).norm(), v.norm());
  EXPECT_EQ(turned(turned(v)), -v);
  EXPECT_EQ(turned(Vector2(1, 0)), Vector2(0, 1));
}

TEST(FlatTriangle, TurnsTheOtherWayWhenItIsTurnedOver) {
  Mesh mesh = fixtures::one_triangle();
  const Surface front = make_surface(mesh);
  std::swap(mesh.triangles[0][1], mesh.triangles[0][2]);
  const Surface back = make_surface(mesh);
  const std::vector<Vector3> v{Vector3(0.6, 0.8, 0)};
  const auto turn = [&](const Surface& surface) {
    Vector field = field_in_frames(surface, v);
    field.head<2>() = turned(field.head<2>());
    return field_in_space(surface, field)[0];
  };
  EXPECT_LE((turn(front) - Vector3(-0.8, 0.6, 0)).norm(), 1e-15);
  EXPECT_LE((turn(back) - Vector3(0.8, -0.6, 0)).norm(), 1e-15);
}

TEST(FlatTriangle, OfAMetricIsThatOfItsEdges) {
  const Vector3 a(1, 2, 0.5), b(-0.3, 1, 2);
  const FlatTriangle edges = flat_triangle(a, b), metric = flat_triangle(a.dot(a), a.dot(b), b.dot(b));
  EXPECT_NEAR(edges.base, metric.base, 1e-15);
  EXPECT_NEAR(edges.foot, metric.foot, 1e-15);
  EXPECT_NEAR(edges.height, metric.height, 1e-14);
  EXPECT_THROW(flat_triangle(1, 2, 1), InvalidInput);
}

TEST(FlatTriangle, KeepsTheAreaOfNeedles) {
  const FlatTriangle needle = flat_triangle(Vector3(1, 0, 0), Vector3(0.5, 1e-12, 0));
  EXPECT_NEAR(needle.area(), 0.5e-12, 1e-26);
  EXPECT_TRUE(flat_triangle(Vector3(1, 0, 0), Vector3(0.5, 0, 0)).empty());
  EXPECT_TRUE(flat_triangle(Vector3(0, 0, 0), Vector3(1, 0, 0)).empty());
}

TEST(FlatTriangle, FieldsGoToSpaceAndBack) {
  const Surface surface = make_surface(fixtures::sphere(2));
  const Vector field = random_signal(2 * surface.triangle_count(), 1);
  EXPECT_LE((field_in_frames(surface, field_in_space(surface, field)) - field).cwiseAbs().maxCoeff(),
            1e-14);
}

TEST(Mass, SumsToTheArea) {
  for (const Surface& surface : surfaces()) {
    const VertexSpace space(surface);
    const Vector ones = Vector::Ones(space.size());
    EXPECT_NEAR(ones.dot(space.mass() * ones), surface.area, 1e-13 * surface.area);
    EXPECT_NEAR(space.scale().area, surface.area, 1e-13 * surface.area);
    EXPECT_LE((space.lumped_mass() - space.mass() * ones).cwiseAbs().maxCoeff(), 1e-14 * surface.area);
  }
}

TEST(Mass, OfOneTriangleIsItsAreaOverSixAndTwelve) {
  const VertexSpace space(make_surface(fixtures::one_triangle()));
  Eigen::Matrix3d expected = Eigen::Matrix3d::Constant(0.5 / 12);
  expected.diagonal().setConstant(0.5 / 6);
  EXPECT_LE((Eigen::MatrixXd(space.mass()) - expected).cwiseAbs().maxCoeff(), 1e-16);
}

TEST(Stiffness, OfOneTriangleHoldsHalfCotangents) {
  const VertexSpace space(make_surface(fixtures::one_triangle()));
  Eigen::Matrix3d expected;
  expected << 1, -0.5, -0.5, -0.5, 0.5, 0, -0.5, 0, 0.5;
  EXPECT_LE((Eigen::MatrixXd(space.stiffness()) - expected).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(Stiffness, VanishesOnConstants) {
  for (const Surface& surface : surfaces()) {
    const VertexSpace space(surface);
    const Vector ones = Vector::Constant(space.size(), 0.1);
    EXPECT_LE((space.stiffness() * ones).cwiseAbs().maxCoeff(), 1e-15);
    EXPECT_TRUE(space.stiffness_times(ones).isZero(0));
  }
}

TEST(Stiffness, IsSymmetricAndSemidefinite) {
  for (const Surface& surface : surfaces()) {
    const Eigen::MatrixXd S = VertexSpace(surface).stiffness();
    EXPECT_EQ((S - S.transpose()).cwiseAbs().maxCoeff(), 0);
    const Vector lambda = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(S).eigenvalues();
    EXPECT_GE(lambda[0], -1e-12 * lambda[lambda.size() - 1]);
  }
}

TEST(Stiffness, VanishesOnLinearFunctionsInsideAPlane) {
  const Surface surface = make_surface(fixtures::flat_square(12, 0.24));
  const VertexSpace space(surface);
  for (int axis = 0; axis < 2; ++axis) {
    const Vector image = space.stiffness() * coordinate(surface, axis);
    for (int v = 0; v < space.size(); ++v)
      if (inner(surface.mesh.positions[v])) {
        EXPECT_NEAR(image[v], 0, 1e-12);
      }
  }
}

TEST(Stiffness, DoesNotChangeWithScaleWhileMassDoes) {
  Mesh mesh = fixtures::torus(20, 12);
  const VertexSpace one(make_surface(mesh));
  for (Vector3& p : mesh.positions) p *= 1000;
  const VertexSpace large(make_surface(mesh));
  const Eigen::MatrixXd S = one.stiffness(), M = one.mass();
  EXPECT_LE((Eigen::MatrixXd(large.stiffness()) - S).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LE((Eigen::MatrixXd(large.mass()) - 1e6 * M).cwiseAbs().maxCoeff(), 1e-6 * M.maxCoeff());
}

TEST(VertexSpace, AssemblesSystemsOfOnePattern) {
  const VertexSpace space(make_surface(fixtures::torus(20, 12)));
  const SparseMatrix A = space.system(2, 3), M = space.mass(), S = space.stiffness();
  EXPECT_LE((Eigen::MatrixXd(A) - Eigen::MatrixXd(2 * M + 3 * S)).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_EQ(A.nonZeros(), M.nonZeros());
  EXPECT_EQ(A.nonZeros(), S.nonZeros());
  EXPECT_EQ(A.nonZeros(), 7 * space.size());
}

TEST(VertexSpace, MultipliesByTheStiffnessWithoutAMatrix) {
  const VertexSpace space(make_surface(fixtures::torus(20, 12)));
  const Signal psi = random_signal(space.size(), 3);
  EXPECT_LE((space.stiffness_times(psi) - space.stiffness() * psi).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(VertexSpace, ModulatesByTheMeanOverEachTriangle) {
  const VertexSpace space(make_surface(fixtures::torus(20, 12)));
  const Signal psi = random_signal(space.size(), 2), random = random_signal(space.size(), 1, 3);
  const std::vector<double> beta(random.data(), random.data() + random.size());
  Signal field = space.gradient(psi);
  for (int t = 0; t < space.triangle_count(); ++t) {
    const Triangle& v = space.triangles()[t];
    field.middleRows(2 * t, 2) *= (beta[v[0]] + beta[v[1]] + beta[v[2]]) / 3;
  }
  const Signal modulated = space.stiffness_times(psi, beta);
  EXPECT_LE((modulated - space.gradient_moments(field)).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_LE(modulated.colwise().sum().cwiseAbs().maxCoeff(), 1e-12);
}

TEST(VertexSpace, HasTheEndsOfEdgesOfOneTriangleForBoundary) {
  const Surface square = make_surface(fixtures::flat_square(6, 0.2));
  std::vector<int> border;
  for (int v = 0; v < square.mesh.vertex_count(); ++v)
    if (!inner(square.mesh.positions[v])) border.push_back(v);
  EXPECT_EQ(VertexSpace(square).boundary(), border);
  EXPECT_TRUE(VertexSpace(make_surface(fixtures::sphere(2))).boundary().empty());
  Surface without_twins;
  without_twins.mesh = square.mesh;
  without_twins.degenerate = square.degenerate;
  EXPECT_EQ(VertexSpace(without_twins).boundary(), border);
}

TEST(VertexSpace, EvaluatesLinearFunctionsAtPointsOfTriangles) {
  const Surface surface = make_surface(fixtures::torus(20, 12));
  const VertexSpace space(surface);
  const std::vector<Vector3> positions = space.positions();
  const Vector3 barycentric(0.2, 0.5, 0.3);
  for (int t = 0; t < surface.triangle_count(); ++t) {
    Vector3 place = Vector3::Zero();
    for (const BasisWeight& w : space.basis_at(t, barycentric)) place += w.weight * positions[w.unknown];
    EXPECT_LE((place - point_at(surface.mesh, {t, barycentric})).norm(), 1e-14);
  }
}

TEST(VertexSpace, ShowsTheLargestFiniteValue) {
  const VertexSpace space(make_surface(fixtures::one_triangle()));
  EXPECT_EQ(space.largest_shown(Vector3(1, 5, std::numeric_limits<double>::infinity())), 5);
  EXPECT_EQ(space.largest_shown(Vector3(-1, -5, -2)), 0);
}

TEST(Gradient, OfALinearFunctionIsConstant) {
  const Surface surface = make_surface(fixtures::flat_square(9, 0.2));
  const VertexSpace space(surface);
  const Signal phi = 3 * coordinate(surface, 0) - 2 * coordinate(surface, 1);
  for (const Vector3& g : field_in_space(surface, space.gradient(phi)))
    EXPECT_LE((g - Vector3(3, -2, 0)).norm(), 1e-12);
}

TEST(Gradient, FactorsTheStiffness) {
  for (const Surface& surface : surfaces()) {
    const VertexSpace space(surface);
    const Signal phi = random_signal(space.size(), 2);
    EXPECT_LE((space.gradient_moments(space.gradient(phi)) - space.stiffness_times(phi))
                  .cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LE((space.gradient_matrix() * phi - space.gradient(phi)).cwiseAbs().maxCoeff(), 1e-12);
  }
}

/// −moments / ∫φ_i is the divergence at an inner vertex.
TEST(Divergence, OfThePositionIsTwoInsideAPlane) {
  const Surface surface = make_surface(fixtures::flat_square(12, 0.24));
  const VertexSpace space(surface);
  std::vector<Vector3> field;
  for (int t = 0; t < surface.triangle_count(); ++t)
    field.push_back((surface.mesh.position(t, 0) + surface.mesh.position(t, 1) +
                     surface.mesh.position(t, 2)) / 3);
  const Vector mass = space.mass() * Vector::Ones(space.size());
  const Vector moments = space.gradient_moments(field_in_frames(surface, field));
  for (int v = 0; v < space.size(); ++v)
    if (inner(surface.mesh.positions[v])) {
      EXPECT_NEAR(-moments[v] / mass[v], 2, 1e-12);
    }
}

TEST(VertexSpace, LeavesTrianglesWithoutAreaOut) {
  Mesh mesh = fixtures::flat_square(4);
  mesh.uvs.clear(), mesh.corner_uvs.clear();
  const VertexSpace clean(make_surface(mesh));
  const int lone = mesh.vertex_count();
  mesh.positions.insert(mesh.positions.end(), {{2, 0, 0}, {3, 0, 0}, {4, 0, 0}});
  mesh.triangles.push_back({lone, lone + 1, lone + 2});
  mesh.triangles.push_back({0, 1, 1});
  const Surface surface = make_surface(mesh);
  const VertexSpace space(surface);
  const Eigen::MatrixXd A = space.system(1, 1), expected = clean.system(1, 1);
  EXPECT_EQ((A.topLeftCorner(lone, lone) - expected).cwiseAbs().maxCoeff(), 0);
  EXPECT_GT(A.diagonal().minCoeff(), 0);
  EXPECT_NEAR(space.mass().sum(), 1, 1e-11);
  EXPECT_TRUE(space.gradient(random_signal(space.size(), 1)).bottomRows(4).isZero(0));
}

TEST(VertexSpace, RefusesASurfaceWithoutArea) {
  EXPECT_THROW(VertexSpace{make_surface(Mesh{})}, InvalidInput);
  Mesh line;
  line.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  line.triangles = {{0, 1, 2}};
  EXPECT_THROW(VertexSpace{make_surface(line)}, InvalidInput);
}

TEST(VertexSpace, RefusesSizesThatDoNotFit) {
  const Surface surface = make_surface(fixtures::sphere(1));
  EXPECT_THROW(VertexSpace(surface, std::vector<FlatTriangle>(3)), InvalidInput);
  const VertexSpace space(surface);
  EXPECT_THROW(space.stiffness_times(random_signal(3, 1)), InvalidInput);
  EXPECT_THROW(space.stiffness_times(random_signal(space.size(), 1), std::vector<double>(3)),
               InvalidInput);
  EXPECT_THROW(space.gradient(random_signal(3, 1)), InvalidInput);
  EXPECT_THROW(space.gradient_moments(random_signal(3, 1)), InvalidInput);
}

TEST(VertexSpace, GivesEqualBitsForAnyNumberOfThreads) {
  const Surface surface = make_surface(fixtures::torus(150, 80));
  const auto assemble = [&](int threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const VertexSpace space(surface);
    const SparseMatrix A = space.system(1, 0.3);
    Vector values = Eigen::Map<const Vector>(A.valuePtr(), A.nonZeros());
    values.conservativeResize(values.size() + 1);
    values[values.size() - 1] = space.scale().area;
    return values;
  };
  const Vector one = assemble(1);
  EXPECT_TRUE(one == assemble(2));
  EXPECT_TRUE(one == assemble(7));
}

}  // namespace
}  // namespace mq
