// Eigenfields of the four bases: that they are fields of the surface, orthonormal, and as many as
// the topology says.

#include "mq/fem/field_spectrum.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <cmath>

#include "fem/field_product.h"
#include "fem/handlebody.h"
#include "fixtures.h"
#include "mq/fem/vertex_space.h"
#include "mq/linear/eigen.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

using fixtures::error_of;
using test::handlebody;
using testing::HasSubstr;

constexpr FieldBasis bases[] = {FieldBasis::triangle, FieldBasis::gradient, FieldBasis::whitney,
                                FieldBasis::vertex};

using fixtures::product;

/// A mesh with edges that are not Delaunay.
Surface sheared_torus() {
  Mesh mesh = fixtures::torus(40, 16);
  for (Vector3& p : mesh.positions) p.z() += 0.8 * p.x();
  return make_surface(mesh);
}

TEST(FieldSpectrum, IsOfUnitFieldsThatAreOrthogonalAndTangent) {
  const Surface surface = sheared_torus();
  for (const FieldBasis basis : bases) {
    const FieldSpectrum found = field_spectrum(surface, {.basis = basis, .count = 6});
    ASSERT_EQ(found.fields.size(), 6U);
    for (int i = 0; i < 6; ++i) {
      if (i > 0) {
        EXPECT_GE(found.values[i], found.values[i - 1]);
      }
      // The triangle and the vertex basis come back by way of means.
      for (int j = 0; j < 6; ++j)
        EXPECT_NEAR(product(surface, found.fields[i], found.fields[j]), i == j, 0.02)
            << int(basis) << " " << i << " " << j;
      for (int t = 0; t < surface.triangle_count(); ++t)
        EXPECT_LE(std::abs(found.fields[i][t].dot(triangle_normal(surface.mesh, t))), 1e-12);
    }
  }
}

/// Obtuse triangles: what the form measures as printed is no smoothness.
TEST(FieldSpectrum, OfCircumcentresAsPrintedGoesBelowZeroOnObtuseTriangles) {
  for (const auto& [across, along] : {std::pair(14, 9), {40, 16}}) {  // as a dense pencil and not
    Mesh mesh = fixtures::torus(across, along);
    for (Vector3& p : mesh.positions) p.z() += 0.8 * p.x();
    const Surface surface = make_surface(mesh);
    const FieldSpectrum printed = field_spectrum(
        surface, {.basis = FieldBasis::triangle, .count = 4, .centre = DualCentre::circumcentre_as_printed});
    EXPECT_GT(printed.negative_weights, 10);
    EXPECT_EQ(printed.flips, 0);
    EXPECT_LT(printed.values[0], -1);
    // The Rayleigh quotients of the fields that came with them.
    const auto shapes = flat_triangles(surface);
    const SparseMatrix S = vector_differences(surface, shapes, DualCentre::circumcentre_as_printed);
    for (int k = 0; k < 4; ++k) {
      const Vector X = field_in_frames(surface, printed.fields[std::size_t(k)]);
      EXPECT_NEAR(X.dot(S * X), printed.values[k], 1e-6 * std::abs(printed.values[0]));
    }
    EXPECT_GT(field_spectrum(surface, {.basis = FieldBasis::triangle, .count = 1}).values[0], 0);
  }
}

/// Less mass of the same fields: no eigenvalue is smaller, and on a grid one is infinite.
TEST(FieldSpectrum, OfTheOnePointMassIsNoSmallerAndOfSecondOrder) {
  double before = 0;
  for (const int n : {12, 24}) {
    const Surface surface = make_surface(fixtures::torus(3 * n, n));
    const FieldSpectrum exact = field_spectrum(surface, {.count = 8}),
                        one = field_spectrum(surface, {.count = 8, .mass = WhitneyMass::one_point});
    EXPECT_EQ(exact.massless, 0);
    EXPECT_EQ(one.massless, 1);
    EXPECT_EQ(one.unknowns, exact.unknowns - 1);
    for (int k = 0; k < 2; ++k) EXPECT_LT(std::abs(one.values[k]), 1e-8) << "harmonic fields have no curl to lose";
    double apart = 0;
    for (int k = 2; k < 8; ++k) {
      EXPECT_GE(one.values[k], exact.values[k] * (1 - 1e-9));
      apart += one.values[k] / exact.values[k] - 1;
    }
    EXPECT_GT(apart, 1e-4);
    if (before > 0) EXPECT_NEAR(before / apart, 4, 1);
    before = apart;
  }
}

/// Table 4.2 of the thesis in structure: 2g zeros in the whitney basis alone, after which it and
/// the gradient basis agree; its triangle basis, which measures another energy, does not.
TEST(FieldSpectrum, HasTwoHarmonicFieldsPerHandleInTheWhitneyBasisAlone) {
  const Surface surface = make_surface(handlebody(4, 4));
  const auto spectrum = [&](FieldBasis basis, int count) {
    return field_spectrum(surface, {.basis = basis, .count = count}).values;
  };
  const Vector whitney = spectrum(FieldBasis::whitney, 20),
               gradient = spectrum(FieldBasis::gradient, 12);
  for (int k = 0; k < 8; ++k) EXPECT_LE(std::abs(whitney[k]), 1e-8 * whitney[8]);
  for (int k = 0; k < 12; ++k) EXPECT_NEAR(whitney[8 + k] / gradient[k], 1, 0.03) << k;
  for (int k = 0; k < 12; k += 2) EXPECT_EQ(gradient[k], gradient[k + 1]);
  EXPECT_GT(spectrum(FieldBasis::triangle, 2)[0], 0.01 * whitney[8]);
  EXPECT_GT(spectrum(FieldBasis::vertex, 2)[0], 0.01 * whitney[8]);
}

/// ∫ |∇X|² = ∫ div² + curl² − K|X|²: both bases of the left side agree with each other.
TEST(FieldSpectrum, OfTheWholeDerivativeIsTheSameAtTrianglesAndAtVertices) {
  const Surface surface = sheared_torus();
  const Vector triangles =
      field_spectrum(surface, {.basis = FieldBasis::triangle, .count = 10}).values;
  const Vector vertices =
      field_spectrum(surface, {.basis = FieldBasis::vertex, .count = 10}).values;
  for (int k = 0; k < 10; ++k) EXPECT_NEAR(triangles[k] / vertices[k], 1, 0.06) << k;
}

/// Vertices moved on the sphere by a tenth of an edge: some edges are no longer Delaunay.
Mesh jittered_sphere(int levels) {
  Mesh mesh = fixtures::sphere(levels);
  const Random random(3);
  const double most = 0.24 / (1 << levels);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    for (int k = 0; k < 3; ++k)
      mesh.positions[v][k] += random.uniform(3 * v + std::uint64_t(k), -most, most);
    mesh.positions[v].normalize();
  }
  return mesh;
}

/// Of a unit field on the unit sphere the norm of the part outside the span of the gradients of x,
/// y and z and the rotations around the axes, which are orthogonal.
double outside_rotations_and_gradients(const Surface& surface, TangentField field) {
  for (int n = 0; n < 6; ++n) {
    TangentField truth(field.size());
    for (int t = 0; t < surface.triangle_count(); ++t) {
      const Vector3 axis = Vector3::Unit(n % 3), at = triangle_normal(surface.mesh, t);
      truth[t] = n < 3 ? Vector3(axis - axis.dot(at) * at) : Vector3(axis.cross(at));
    }
    const double part = product(surface, field, truth) / product(surface, truth, truth);
    for (std::size_t t = 0; t < field.size(); ++t) field[t] -= part * truth[t];
  }
  return std::sqrt(product(surface, field, field));
}

/// What comes back from the flipped triangulation is the field itself: the unit sphere's smallest
/// eigenfields of ∫ |∇X|² are the rotations and the gradients of x, y, z.
TEST(FieldSpectrum, BringsFieldsBackFromFlippedTriangles) {
  for (const FieldBasis basis : {FieldBasis::triangle, FieldBasis::vertex}) {
    std::vector<double> missed;
    for (const int levels : {4, 5}) {
      const Surface surface = make_surface(jittered_sphere(levels));
      const FieldSpectrum found = field_spectrum(surface, {.basis = basis, .count = 6});
      EXPECT_GT(found.flips, 20);
      missed.push_back(0);
      for (int k = 0; k < 6; ++k) {
        EXPECT_NEAR(found.values[k], 1, levels == 4 ? 0.012 : 0.003);
        missed.back() =
            std::max(missed.back(), outside_rotations_and_gradients(surface, found.fields[k]));
      }
    }
    EXPECT_LT(missed[1], 0.01);
    EXPECT_LT(missed[1], 0.5 * missed[0]);
  }
}

/// On the unit disc fields tangent to the boundary: gradients of functions with no slope across it
/// and turned gradients of functions that are 0 there, j'₁₁² = 3.390 twice and j₀₁² = 5.783.
TEST(FieldSpectrum, OfADiscIsOfFieldsTangentToItsBoundary) {
  Mesh disc = fixtures::flat_square(40);
  disc.uvs.clear(), disc.corner_uvs.clear();
  for (Vector3& p : disc.positions) {
    const double x = 2 * p.x() - 1, y = 2 * p.y() - 1;
    p = {x * std::sqrt(1 - y * y / 2), y * std::sqrt(1 - x * x / 2), 0};
  }
  const Surface surface = make_surface(disc);
  for (const FieldBasis basis : {FieldBasis::gradient, FieldBasis::whitney}) {
    const FieldSpectrum found = field_spectrum(surface, {.basis = basis, .count = 3});
    EXPECT_NEAR(found.values[0], 3.390, 0.02);
    EXPECT_NEAR(found.values[1], 3.390, 0.02);
    EXPECT_NEAR(found.values[2], 5.783, 0.03);
    // The third turns around the centre.
    double along = 0;
    for (int t = 0; t < surface.triangle_count(); ++t) {
      const Vector3 c = (surface.mesh.position(t, 0) + surface.mesh.position(t, 1) +
                         surface.mesh.position(t, 2)) /
                        3;
      along = std::max(along, std::abs(found.fields[2][t].dot(c)));
    }
    EXPECT_LT(along, 0.05);
  }
}

TEST(FieldSpectrum, TakesUglyMeshes) {
  Mesh slivers = fixtures::flat_square(6, 0.2);
  slivers.uvs.clear(), slivers.corner_uvs.clear();
  slivers.triangles.push_back({0, 1, 2});
  slivers.triangles.push_back({6, 6, 7});
  slivers.positions.insert(slivers.positions.end(), {{2, 0, 0}, {3, 0, 0}, {4, 0, 0}});
  const int lone = slivers.vertex_count() - 3;
  slivers.triangles.push_back({lone, lone + 1, lone + 2});
  for (const Mesh& mesh : {slivers, fixtures::moebius_strip(12), fixtures::nonmanifold_edge(),
                           fixtures::nonmanifold_vertex(),
                           fixtures::beside(fixtures::sphere(2), fixtures::torus(12, 8))}) {
    const Surface surface = make_surface(mesh);
    for (const FieldBasis basis : bases) {
      FieldSpectrum found;
      const std::string error =
          error_of([&] { found = field_spectrum(surface, {.basis = basis, .count = 3}); });
      if (found.fields.empty()) {
        EXPECT_THAT(error, HasSubstr("the basis has")) << int(basis);
        continue;
      }
      EXPECT_TRUE(found.values.allFinite());
      EXPECT_GT(found.values[0], -1e-9);
      for (const TangentField& field : found.fields) {
        for (const Vector3& X : field) EXPECT_TRUE(X.allFinite());
        EXPECT_NEAR(product(surface, field, field), 1, 1e-9);
      }
    }
  }
}

TEST(FieldSpectrum, IsTheSameForAnyNumberOfThreads) {
  const Surface surface = sheared_torus();
  for (const FieldBasis basis : bases) {
    const auto with = [&](std::size_t threads) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      return field_spectrum(surface, {.basis = basis, .count = 4}).fields;
    };
    EXPECT_TRUE(with(1) == with(7));
  }
}

TEST(FieldSpectrum, RefusesMoreFieldsThanThereAre) {
  const Surface surface = make_surface(fixtures::tetrahedron());
  EXPECT_THAT(
      error_of([&] { field_spectrum(surface, {.basis = FieldBasis::whitney, .count = 7}); }),
      HasSubstr("7 eigenvalues were asked for; the basis has 6"));
  EXPECT_THAT(
      error_of([&] { field_spectrum(surface, {.basis = FieldBasis::gradient, .count = 7}); }),
      HasSubstr("the basis has 6"));
  EXPECT_EQ(field_spectrum(surface, {.basis = FieldBasis::gradient, .count = 6}).values.size(), 6);
}

}  // namespace
}  // namespace mq
