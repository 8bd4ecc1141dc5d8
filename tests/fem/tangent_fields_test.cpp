// Fields that a surface has by itself, against closed forms and the topology that counts them.

#include "mq/fem/tangent_fields.h"

#include <gtest/gtest.h>

#include <cmath>

#include "atlas/atlas_fixtures.h"
#include "fem/handlebody.h"
#include "mq/fem/edges.h"
#include "mq/fem/exterior.h"
#include "mq/fem/vertex_space.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

double inner(const Surface& surface, const TangentField& x, const TangentField& y) {
  double sum = 0;
  for (int t = 0; t < surface.triangle_count(); ++t)
    sum += triangle_area(surface.mesh, t) * x[t].dot(y[t]);
  return sum;
}

void expect_harmonic(const Mesh& mesh, int count) {
  const Surface surface = make_surface(mesh);
  const std::vector<TangentField> fields = harmonic_fields(surface);
  ASSERT_EQ(std::ssize(fields), count);
  const VertexSpace space(surface);
  const std::vector<FlatTriangle> shapes = flat_triangles(surface);
  const Edges edges = make_edges(surface, shapes);
  const SparseMatrix curl = d1(edges);
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j <= i; ++j) EXPECT_NEAR(inner(surface, fields[i], fields[j]), i == j, 1e-9);
    const Vector flat = field_in_frames(surface, fields[i]);
    EXPECT_LE(space.gradient_moments(flat).cwiseAbs().maxCoeff(), 1e-9) << "divergence";
    // Both triangles of an edge agree on the integral along it.
    Vector omega = Vector::Constant(edges.count(), std::nan(""));
    for (int h = 0; h < int(edges.from_half_edge.size()); ++h) {
      const int e = edges.from_half_edge[h];
      if (e < 0) continue;
      const Vector3 along = mesh.position(next(h) / 3, next(h) % 3) - mesh.position(h / 3, h % 3);
      const double integral = edges.sign[h] * fields[i][h / 3].dot(along);
      if (!std::isnan(omega[e])) {
        EXPECT_NEAR(omega[e], integral, 1e-9);
      }
      omega[e] = integral;
    }
    EXPECT_LE((curl * omega).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(HarmonicFields, AreTwiceTheGenus) {
  expect_harmonic(fixtures::cut_sphere(6, {}), 0);
  expect_harmonic(fixtures::torus(20, 12), 2);
  expect_harmonic(test::handlebody(2, 6), 4);
  expect_harmonic(test::handlebody(4, 6), 8);
}

TEST(HarmonicFields, AreOneLessThanTheBoundariesOfAPlane) {
  expect_harmonic(fixtures::flat_square(8, 0.2), 0);
  Mesh holed = fixtures::flat_square(12, 0.1);
  std::erase_if(holed.triangles, [&](const Triangle& t) {
    const Vector3 m = (holed.positions[t[0]] + holed.positions[t[1]] + holed.positions[t[2]]) / 3;
    return (m - Vector3(0.3, 0.3, 0)).norm() < 0.15 || (m - Vector3(0.7, 0.6, 0)).norm() < 0.15;
  });
  holed.uvs.clear();
  holed.corner_uvs.clear();
  expect_harmonic(holed, 2);
}

TEST(HarmonicFields, AreThoseOfEachComponent) {
  Mesh two = fixtures::torus(16, 10);
  const int vertices = two.vertex_count(), triangles = two.triangle_count();
  for (int v = 0; v < vertices; ++v) two.positions.push_back(two.positions[v] + Vector3(5, 0, 0));
  for (int t = 0; t < triangles; ++t) {
    const Triangle& old = two.triangles[t];
    two.triangles.push_back({old[0] + vertices, old[1] + vertices, old[2] + vertices});
  }
  two.uvs.clear();
  two.corner_uvs.clear();
  expect_harmonic(two, 4);
}

/// On a torus the larger curvature is that of the tube, 1/r, except where κ₂ = cos v/ρ is near it.
TEST(CurvatureField, RunsAroundTheTubeOfATorus) {
  fixtures::CutOptions options;
  options.cells = 80;
  options.parts = 1;
  options.jitter = 0;
  const double r = 0.4;
  const Surface surface = make_surface(fixtures::cut_torus(options, 1, r));
  const TangentField around = curvature_field(surface, Principal::max),
                     along = curvature_field(surface, Principal::min);
  for (int t = 0; t < surface.triangle_count(); ++t) {
    Vector3 m = Vector3::Zero();
    for (int k = 0; k < 3; ++k) m += surface.mesh.position(t, k) / 3;
    const Vector3 axis = Vector3(-m.y(), m.x(), 0).normalized();
    const double rho = std::hypot(m.x(), m.y()), difference = 1 / r - (rho - 1) / r / rho;
    EXPECT_NEAR(around[t].norm(), difference, 0.03 * difference);
    EXPECT_NEAR(along[t].norm(), difference, 0.03 * difference);
    EXPECT_LE(std::abs(around[t].normalized().dot(axis)), 0.03);
    EXPECT_GE(std::abs(along[t].normalized().dot(axis)), 0.999);
  }
}

TEST(GradientField, OfALinearFunctionIsItsTangentPart) {
  const Surface surface = make_surface(fixtures::torus(20, 12));
  const Vector3 slope(1, -2, 0.5);
  Vector psi(surface.mesh.vertex_count());
  for (Eigen::Index v = 0; v < psi.size(); ++v) psi[v] = slope.dot(surface.mesh.positions[v]);
  const TangentField field = gradient_field(surface, psi);
  std::vector<Vector3> everywhere(surface.mesh.positions.size(), slope);
  const TangentField tangent = field_from_vertices(surface, everywhere);
  for (int t = 0; t < surface.triangle_count(); ++t)
    EXPECT_LE((field[t] - tangent[t]).norm(), 1e-12);
}

TEST(TangentField, IsScaledToLengthOne) {
  const Surface surface = make_surface(fixtures::torus(20, 12));
  const TangentField field = curvature_field(surface, Principal::max);
  int whole = 0;
  for (const Vector3& v : scaled_to_one(surface, field)) {
    EXPECT_LE(v.norm(), 1 + 1e-12);
    whole += v.norm() > 1 - 1e-12;
  }
  EXPECT_GT(whole, 0);
  EXPECT_LT(whole, surface.triangle_count() / 2);
  for (const Vector3& v : normalised(surface, field)) EXPECT_NEAR(v.norm(), 1, 1e-12);
}

/// On triangles of one area, of lengths 1, 2, 3, ...: of all of them, and of those that have one where nearly none has; so
/// at every scale of the surface.
TEST(TangentField, HasTheStrengthOfItsQuantile) {
  for (const double scale : {0.05, 1.0, 30.0}) {
    Mesh mesh = fixtures::flat_square(10, 0);
    for (Vector3& p : mesh.positions) p *= scale;
    const Surface surface = make_surface(mesh);
    ASSERT_EQ(surface.triangle_count(), 200);
    const auto strength = [&](int zeros) {
      TangentField field(200, Vector3::Zero());
      for (int t = zeros; t < 200; ++t) field[std::size_t((7 * t) % 200)].x() = t - zeros + 1;
      return strength_of(surface, field, 0.795);
    };
    EXPECT_EQ(strength(0), 159) << scale;
    EXPECT_EQ(strength(100), 59) << scale;
    EXPECT_EQ(strength(180), 16) << scale;
  }
}

TEST(TangentField, IsScaledToLengthOneWhereItVanishesNearlyEverywhere) {
  const Surface surface = make_surface(fixtures::torus(20, 12));
  TangentField field(std::size_t(surface.triangle_count()), Vector3::Zero());
  for (int t = 0; t < 4; ++t)
    field[t] = 20 * triangle_normal(surface.mesh, t).unitOrthogonal();
  const TangentField scaled = scaled_to_one(surface, field);
  for (int t = 0; t < 8; ++t) EXPECT_NEAR(scaled[t].norm(), t < 4 ? 1 : 0, 1e-12);
}

}  // namespace
}  // namespace mq
