// The smoothest fields through what is wished: parallel where the surface is flat, with zeros where it must.

#include "mq/fem/smoothest_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "fem/cut_squares.h"
#include "mq/base/error.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();

TEST(SmoothestField, IsParallelOnAFlatSurfaceHoweverItIsCut) {
  const Vector3 wish(0.6, -0.8, 0);
  const WishedVector wishes[] = {{{0, {0.2, 0.3, 0.5}}, wish, 1}};
  // It fades over ten times the square's side.
  for (fixtures::Cut& cut : fixtures::cut_squares()) {
    const fixtures::Textured& model = *cut.model;
    const TexelSpace space(model.surface, model.atlas);
    const TexelVectorSpace vectors(model.surface, model.atlas, space);
    const SmoothestTexels found = smoothest_field(vectors, wishes, {.tolerance = 1e-9});
    EXPECT_TRUE(found.report.converged) << cut.name;
    for (const TangentField& field : {vectors.on_triangles(found.field), smoothest_field(model.surface, wishes)}) {
      double turned = 0, shorter = 0;
      for (const Vector3& X : field) {
        turned = std::max(turned, (X.normalized() - wish).norm());
        shorter = std::max(shorter, std::abs(X.norm() - 1));
      }
      EXPECT_LT(turned, 1e-7) << cut.name;
      EXPECT_LT(shorter, 0.025) << cut.name;
    }
  }
}

TEST(SmoothestField, GoesAlongItsWishesAndBetweenThemTurnsEvenly) {
  // On a strip the field turns from one end to the other: its angle is linear for unit vectors, here components are,
  // with ∂X/∂n = 0 beside: X = (1 − x)·a + x·b.
  const Surface surface = make_surface(fixtures::flat_square(24, 0.2));
  std::vector<WishedVector> wishes;
  for (int t = 0; t < surface.triangle_count(); ++t)
    for (int k = 0; k < 3; ++k) {
      const double x = surface.mesh.position(t, k).x();
      if (x == 0) wishes.push_back({{t, Vector3::Unit(k)}, {1, 0, 0}, 1});
      if (x == 1) wishes.push_back({{t, Vector3::Unit(k)}, {0, 1, 0}, 1});
    }
  ASSERT_GT(wishes.size(), 40U);
  const TangentField field = smoothest_field(surface, wishes, {.hold = 1e6});
  for (int t = 0; t < surface.triangle_count(); ++t) {
    const double x = (surface.mesh.position(t, 0).x() + surface.mesh.position(t, 1).x() + surface.mesh.position(t, 2).x()) / 3;
    EXPECT_LT((field[std::size_t(t)] - Vector3(1 - x, x, 0)).norm(), 0.005) << x;
  }
}

TEST(SmoothestField, IsTheSameOnTexelsAndOnTrianglesOfASphere) {
  const auto model = fixtures::textured(fixtures::cut_sphere(40, fixtures::turned(fixtures::odd_angle)), {{288, 192}});
  const TexelSpace space(model->surface, model->atlas);
  const TexelVectorSpace vectors(model->surface, model->atlas, space);
  const Mesh& mesh = model->surface.mesh;
  std::vector<WishedVector> wishes;  // around the equator
  for (int t = 0; t < model->surface.triangle_count(); ++t) {
    const Vector3 m = (mesh.position(t, 0) + mesh.position(t, 1) + mesh.position(t, 2)) / 3;
    if (std::abs(m.z()) < 0.03) wishes.push_back({{t, Vector3::Constant(1.0 / 3)}, Vector3(-m.y(), m.x(), 0), 1});
  }
  ASSERT_GT(wishes.size(), 50U);
  const TangentField coarse = smoothest_field(model->surface, wishes);
  const SmoothestTexels texels = smoothest_field(vectors, wishes);
  ASSERT_TRUE(texels.report.converged);
  const TangentField fine = vectors.on_triangles(texels.field);
  double difference = 0, whole = 0;
  for (int t = 0; t < model->surface.triangle_count(); ++t) {
    const Vector3 m = ((mesh.position(t, 0) + mesh.position(t, 1) + mesh.position(t, 2)) / 3).normalized();
    const double area = triangle_area(mesh, t);
    difference += area * (coarse[std::size_t(t)] - fine[std::size_t(t)]).squaredNorm();
    whole += area * coarse[std::size_t(t)].squaredNorm();
    // It goes round everywhere, and vanishes at the poles, as a field on a sphere must somewhere.
    if (std::hypot(m.x(), m.y()) > 0.3) {
      EXPECT_GT(fine[std::size_t(t)].normalized().dot(Vector3(-m.y(), m.x(), 0).normalized()), 0.99);
    }
    if (std::hypot(m.x(), m.y()) < 0.05) {
      EXPECT_LT(fine[std::size_t(t)].norm(), 0.1);
    }
  }
  EXPECT_LT(difference, 0.002 * whole);
}

TEST(SmoothestField, FadesOverItsReachAndIsZeroWhereNothingIsWished) {
  Mesh mesh = fixtures::flat_square(30, 0.2);
  mesh.uvs.clear(), mesh.corner_uvs.clear();
  const int vertices = mesh.vertex_count(), triangles = mesh.triangle_count();
  for (int v = 0; v < vertices; ++v) mesh.positions.push_back(mesh.positions[v] + Vector3(5, 0, 0));
  for (int t = 0; t < triangles; ++t) {
    const Triangle old = mesh.triangles[t];
    mesh.triangles.push_back({old[0] + vertices, old[1] + vertices, old[2] + vertices});
  }
  const Surface surface = make_surface(mesh);
  std::vector<WishedVector> wishes;
  for (int t = 0; t < triangles; ++t)
    for (int k = 0; k < 3; ++k)
      if (surface.mesh.position(t, k).x() == 0) wishes.push_back({{t, Vector3::Unit(k)}, {0, 1, 0}, 1});
  const double reach = 0.2;
  const TangentField field = smoothest_field(surface, wishes, {.hold = 1e6, .reach = reach});
  for (int t = 0; t < surface.triangle_count(); ++t) {
    const double x = (surface.mesh.position(t, 0).x() + surface.mesh.position(t, 1).x() + surface.mesh.position(t, 2).x()) / 3;
    // X'' = X/reach², X'(1) = 0.
    const double expected = x > 2 ? 0 : std::cosh((1 - x) / reach) / std::cosh(1 / reach);
    EXPECT_NEAR(field[std::size_t(t)].y(), expected, 0.01) << x;
  }
}

/// hold·weight is what counts.
TEST(SmoothestField, HoldsAWishByItsWeight) {
  const Surface surface = make_surface(fixtures::flat_square(6, 0.2));
  const auto with = [&](double hold, double weight) {
    const WishedVector wishes[] = {{{3, {0.5, 0.2, 0.3}}, {1, 0, 0}, weight}, {{40, {0.2, 0.2, 0.6}}, {0, 1, 0}, weight}};
    return smoothest_field(surface, wishes, {.hold = hold});
  };
  const TangentField field = with(12, 0.25), same = with(3, 1), other = with(3, 4);
  double largest = 0, apart = 0;
  for (std::size_t t = 0; t < field.size(); ++t) {
    largest = std::max(largest, (field[t] - same[t]).norm());
    apart = std::max(apart, (field[t] - other[t]).norm());
  }
  EXPECT_LT(largest, 1e-9);
  EXPECT_GT(apart, 0.01);
}

TEST(SmoothestField, RefusesWhatItCannotMean) {
  const Surface surface = make_surface(fixtures::flat_square(3, 0));
  EXPECT_THROW(smoothest_field(surface, {}), InvalidInput);
  const WishedVector nowhere[] = {{{99, {1, 0, 0}}, {1, 0, 0}, 1}};
  EXPECT_THROW(smoothest_field(surface, nowhere), InvalidInput);
  const WishedVector endless[] = {{{0, {1, 0, 0}}, {inf, 0, 0}, 1}};
  EXPECT_THROW(smoothest_field(surface, endless), InvalidInput);
  const WishedVector good[] = {{{0, {1, 0, 0}}, {1, 0, 0}, 1}};
  EXPECT_THROW(smoothest_field(surface, good, {.reach = 0}), InvalidInput);
}

TEST(TexelVectorSpaceOfTriangles, TakesFieldsPerTriangleAndSaysWhereTexturesGoRight) {
  const Vector3 constant(0.3, 0.7, 0);
  for (fixtures::Cut& cut : fixtures::cut_squares()) {
    const fixtures::Textured& model = *cut.model;
    const TexelSpace space(model.surface, model.atlas);
    const TexelVectorSpace vectors(model.surface, model.atlas, space);
    const Vector z = vectors.from_triangles(TangentField(std::size_t(model.surface.triangle_count()), constant));
    for (const Vector3& X : vectors.on_triangles(z)) EXPECT_LT((X - constant).norm(), 1e-10) << cut.name;
    const std::vector<std::complex<double>> right = vectors.rightward();
    for (int t = 0; t < model.surface.triangle_count(); ++t) {
      const auto& uv = model.surface.mesh.corner_uvs[std::size_t(t)];
      const int chart = model.atlas.chart[std::size_t(t)];
      if (chart < 0) continue;
      // u as a function on the triangle grows along its gradient at right angles to where v grows.
      Eigen::Matrix2d texture, plane;
      for (int k = 0; k < 2; ++k) {
        texture.col(k) = model.surface.mesh.uvs[std::size_t(uv[std::size_t(k) + 1])] - model.surface.mesh.uvs[std::size_t(uv[0])];
        plane.col(k) = (model.surface.mesh.position(t, k + 1) - model.surface.mesh.position(t, 0)).head<2>();
      }
      const Vector2 expected = (plane * texture.inverse()).col(0).normalized();
      for (int i = 0; i < space.size(); ++i) {
        if (space.texels().chart[std::size_t(i)] != chart) continue;
        const Vector3 found = vectors.plane(i).in_space(right[std::size_t(i)].real(), right[std::size_t(i)].imag());
        EXPECT_NEAR(found.head<2>().dot(expected), 1, 1e-9) << cut.name;
        break;
      }
    }
  }
}

}  // namespace
}  // namespace mq
