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

constexpr double pi = std::numbers::pi;

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

}  // namespace
}  // namespace mq
