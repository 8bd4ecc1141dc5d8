// The metric across a field: heat spreads along it as before, and 1 + κ² times slower across.

#include "mq/fem/field_metric.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem/cut_squares.h"
#include "mq/fem/vertex_space.h"
#include "mq/filter/screened_poisson.h"

namespace mq {
namespace {

using std::numbers::pi;

/// The factor by which cos(2πx) or cos(2πy) on the unit square is damped in the space.
double damping(const SignalSpace& space, const Vector& wave, double w) {
  const Vector damped = ScreenedPoisson(space, w).solve(wave, 0).signal.col(0);
  const SparseMatrix M = space.mass();
  return wave.dot(M * damped) / wave.dot(M * wave);
}

void expect_times(const SignalSpace& space, const Vector& along, const Vector& across,
                  double kappa) {
  // Weights for which both are damped alike.
  const double w = 0.02, k = 4 * pi * pi;
  EXPECT_NEAR(damping(space, along, w), 1 / (1 + w * k), 0.01 / (1 + w * k));
  const double slow = w * (1 + kappa * kappa);
  EXPECT_NEAR(damping(space, across, slow), 1 / (1 + w * k), 0.01 / (1 + w * k));
}

TEST(FieldMetric, MakesHeatSlowAcrossTheField) {
  for (const double kappa : {1.0, 10.0, 100.0})
    for (const bool cut : {false, true}) {
      // Where no texel line follows the field, texels spread heat across it themselves: by h².
      if (cut && kappa > 10) continue;
      fixtures::CutOptions options;
      if (cut)
        options = fixtures::slanted();
      else
        options.parts = 1, options.scale = 0.9;
      const int side = cut ? 400 : 100;
      const auto model = fixtures::textured(fixtures::cut_square(options), {{side, side}});
      const std::vector<Vector3> field(model->surface.mesh.triangles.size(), Vector3(1, 0, 3));
      TexelSpaceOptions across;
      across.metrics = texel_metrics_across(model->surface, model->atlas, field, kappa);
      const TexelSpace space(model->surface, model->atlas, across);
      const auto x = fixtures::texels_on_square(options, {side, side}, space.texels());
      Vector u(space.size()), v(space.size());
      for (int i = 0; i < space.size(); ++i)
        u[i] = std::cos(2 * pi * x[i].x()), v[i] = std::cos(2 * pi * x[i].y());
      expect_times(space, u, v, kappa);
    }
}

TEST(FieldMetric, DoesTheSameForVertices) {
  const Mesh mesh = fixtures::flat_square(100);
  const Surface surface = make_surface(mesh);
  const std::vector<Vector3> field(mesh.triangles.size(), Vector3(1, 0, 0));
  const VertexSpace space(surface, shapes_across(surface, field, 10));
  Vector u(space.size()), v(space.size());
  for (int i = 0; i < space.size(); ++i) {
    u[i] = std::cos(2 * pi * surface.mesh.positions[i].x());
    v[i] = std::cos(2 * pi * surface.mesh.positions[i].y());
  }
  expect_times(space, u, v, 10);
}

TEST(FieldMetric, OfNoFieldIsThatOfTheSurface) {
  const auto model = fixtures::textured(fixtures::cut_square(fixtures::slanted()), {{96, 96}});
  const std::vector<Vector3> none(model->surface.mesh.triangles.size(), Vector3::Zero());
  const auto metrics = texel_metrics_across(model->surface, model->atlas, none, 100);
  for (int t = 0; t < std::ssize(metrics); ++t) {
    const TexelMetric own = texel_metric(model->surface, model->atlas, t);
    EXPECT_NEAR(metrics[t].a, own.a, 1e-12 * own.a);
    EXPECT_NEAR(metrics[t].density, own.density, 1e-12 * own.density);
  }
}

TEST(FieldMetric, RefusesFieldsThatDoNotFit) {
  const auto model = fixtures::textured(fixtures::cut_square({}), {{96, 96}});
  std::vector<Vector3> field(model->surface.mesh.triangles.size(), Vector3(1, 0, 0));
  field[3].y() = std::nan("");
  EXPECT_THROW(texel_metrics_across(model->surface, model->atlas, field, 100), InvalidInput);
  field.pop_back();
  EXPECT_THROW(texel_metrics_across(model->surface, model->atlas, field, 100), InvalidInput);
  EXPECT_THROW(shapes_across(model->surface, field, 100), InvalidInput);
}

TEST(CreaseMetric, StretchesASphereEvenlyAndACylinderAroundItself) {
  // N = x on the unit sphere: each triangle is √(1 + ℓ²) times as large. On a cylinder of radius ½
  // N = 2x: lengths around are √(1 + 4ℓ²) times as large, those along it stay.
  const double length = 0.7;
  const Surface sphere = make_surface(fixtures::sphere(3));
  const auto plain = flat_triangles(sphere);
  const auto wide = shapes_across_creases(sphere, sphere.mesh.positions, length);
  const double by = std::sqrt(1 + length * length);
  for (std::size_t t = 0; t < plain.size(); ++t) {
    EXPECT_NEAR(wide[t].base, by * plain[t].base, 1e-14);
    EXPECT_NEAR(wide[t].foot, by * plain[t].foot, 1e-14);
    EXPECT_NEAR(wide[t].height, by * plain[t].height, 1e-14);
  }
  Mesh tube = fixtures::flat_square(16);
  std::vector<Vector3> normals;
  for (Vector3& p : tube.positions) {
    normals.emplace_back(std::cos(p.x()), std::sin(p.x()), 0);
    p = Vector3(0.5 * normals.back().x(), 0.5 * normals.back().y(), p.y());
  }
  const Surface cylinder = make_surface(tube);
  const auto shapes = shapes_across_creases(cylinder, normals, length);
  // Triangle 0 has its first edge around the cylinder, its last along it.
  const FlatTriangle before = flat_triangles(cylinder)[0];
  EXPECT_NEAR(shapes[0].base, std::sqrt(1 + 4 * length * length) * before.base, 1e-14);
  EXPECT_NEAR(shapes[0].height, before.height, 1e-14);
}

TEST(CreaseMetric, IsTheSurfacesOwnWhereNormalsAreEqualOrUnknown) {
  Mesh mesh = fixtures::flat_square(3);
  mesh.triangles.push_back({0, 0, 5});
  mesh.uvs.clear(), mesh.corner_uvs.clear();
  const Surface surface = make_surface(mesh);
  const auto plain = flat_triangles(surface);
  for (const auto& normals : {std::vector<Vector3>(16, Vector3(0, 0, 1)),
                              std::vector<Vector3>(16, Vector3(0, 0, 0))}) {
    const auto same = shapes_across_creases(surface, normals, 5);
    for (std::size_t t = 0; t < plain.size(); ++t) {
      EXPECT_EQ(same[t].base, plain[t].base);
      EXPECT_EQ(same[t].foot, plain[t].foot);
      EXPECT_EQ(same[t].height, plain[t].height);
    }
  }
  EXPECT_THROW(shapes_across_creases(surface, std::vector<Vector3>(15), 1), InvalidInput);
  EXPECT_THROW(shapes_across_creases(surface, std::vector<Vector3>(16), -1), InvalidInput);
}

}  // namespace
}  // namespace mq
