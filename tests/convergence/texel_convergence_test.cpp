// Orders of convergence of the texel space, with atlases cut in different ways: exact solutions are
// those of the square with free boundary, cos(kπx) cos(lπy) with eigenvalue π²(k² + l²).

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "atlas/atlas_fixtures.h"
#include "mq/fem/texel_space.h"
#include "mq/filter/screened_poisson.h"
#include "mq/linear/direct.h"

namespace mq {
namespace {

constexpr double pi = std::numbers::pi;

struct Case {
  std::string name;
  fixtures::CutOptions options;
};

std::vector<Case> cases() {
  std::vector<Case> all;
  for (int parts : {1, 2, 5}) {
    fixtures::CutOptions options;
    options.parts = parts;
    options.cells = 10;
    options.scale = parts == 1 ? 0.9 : 0.62;
    options.angle = parts == 1 ? [](int) { return 0.0; } : fixtures::odd_angle;
    all.push_back({std::to_string(parts * parts) + " charts", options});
  }
  return all;
}

/// The coordinates x and y of the square as signals: exact, for linear functions are reproduced.
Signal coordinates(const fixtures::Textured& model, const TexelSpace& space) {
  std::vector<int> triangle(model.atlas.charts.size(), -1);
  for (int t = 0; t < model.surface.triangle_count(); ++t)
    if (triangle[model.atlas.chart[t]] < 0) triangle[model.atlas.chart[t]] = t;
  Signal result(space.size(), 2);
  for (int i = 0; i < space.size(); ++i) {
    const int t = triangle[space.texels().chart[i]];
    const auto& p = model.atlas.corners[t];
    Eigen::Matrix2d E;
    E << p[1].column() - p[0].column(), p[2].column() - p[0].column(), p[1].row() - p[0].row(),
        p[2].row() - p[0].row();
    const auto& at = space.texels().places[i];
    const Eigen::Vector2d l =
        E.inverse() * Eigen::Vector2d(at.x - p[0].column(), at.y - p[0].row());
    const Mesh& m = model.surface.mesh;
    result.row(i) = (m.position(t, 0) + l[0] * (m.position(t, 1) - m.position(t, 0)) +
                     l[1] * (m.position(t, 2) - m.position(t, 0)))
                        .head<2>()
                        .transpose();
  }
  return result;
}

/// Errors in L² and in the H¹ seminorm of the solution of φ − wΔφ = (1 + 2π²w) cos πx cos πy.
std::pair<double, double> manufactured_errors(const fixtures::CutOptions& options, int size) {
  const double w = 0.05;
  const auto model = fixtures::textured(fixtures::cut_square(options), {{size, size}});
  const TexelSpace space(model->surface, model->atlas);
  const Signal xy = coordinates(*model, space);
  const auto at = [&](const TexelSamples& s, int q) {
    Eigen::Vector2d p = Eigen::Vector2d::Zero();
    for (std::size_t k = 0; k < s.texels.size(); ++k)
      p += s.values(q, Eigen::Index(k)) * xy.row(s.texels[k]).transpose();
    return p;
  };
  Signal b = Signal::Zero(space.size(), 1);
  space.for_each_piece([&](const TexelSamples& s) {
    const double density = texel_metric(model->surface, model->atlas, s.triangle).density;
    for (int q = 0; q < s.weights.size(); ++q) {
      const Eigen::Vector2d p = at(s, q);
      const double f = (1 + 2 * pi * pi * w) * std::cos(pi * p.x()) * std::cos(pi * p.y());
      for (std::size_t k = 0; k < s.texels.size(); ++k)
        b(s.texels[k], 0) += s.weights[q] * density * f * s.values(q, Eigen::Index(k));
    }
  });
  const Signal phi = DirectSolver(space.system(1, w)).solve(b);
  double l2 = 0, h1 = 0;
  space.for_each_piece([&](const TexelSamples& s) {
    const TexelMetric metric = texel_metric(model->surface, model->atlas, s.triangle);
    for (int q = 0; q < s.weights.size(); ++q) {
      const Eigen::Vector2d p = at(s, q);
      // The error and its derivatives by texel; those of x and y are the texel map's Jacobian.
      double value = 0;
      Eigen::Vector2d slope(0, 0), px(0, 0), py(0, 0);
      for (std::size_t k = 0; k < s.texels.size(); ++k) {
        const auto column = Eigen::Index(k);
        value += s.values(q, column) * phi(s.texels[k], 0);
        slope += Eigen::Vector2d(s.dx(q, column), s.dy(q, column)) * phi(s.texels[k], 0);
        px += Eigen::Vector2d(s.dx(q, column), s.dy(q, column)) * xy(s.texels[k], 0);
        py += Eigen::Vector2d(s.dx(q, column), s.dy(q, column)) * xy(s.texels[k], 1);
      }
      const double cx = std::cos(pi * p.x()), cy = std::cos(pi * p.y());
      const Eigen::Vector2d e =
          slope + pi * std::sin(pi * p.x()) * cy * px + pi * cx * std::sin(pi * p.y()) * py;
      l2 += s.weights[q] * metric.density * std::pow(value - cx * cy, 2);
      h1 += s.weights[q] *
            (metric.a * e.x() * e.x() + 2 * metric.b * e.x() * e.y() + metric.c * e.y() * e.y());
    }
  });
  return {std::sqrt(l2), std::sqrt(h1)};
}

TEST(TexelConvergence, IsOfOrderTwoInValuesAndOneInGradientsHoweverTheAtlasIsCut) {
  for (const Case& c : cases()) {
    const auto [l2_coarse, h1_coarse] = manufactured_errors(c.options, 48);
    const auto [l2_fine, h1_fine] = manufactured_errors(c.options, 192);
    EXPECT_GE(std::log2(l2_coarse / l2_fine) / 2, 1.8)
        << c.name << ' ' << l2_coarse << ' ' << l2_fine;
    EXPECT_GE(std::log2(h1_coarse / h1_fine) / 2, 0.9)
        << c.name << ' ' << h1_coarse << ' ' << h1_fine;
  }
}

TEST(TexelConvergence, FilteringHasTheGainOfItsFormula) {
  for (Case& c : cases()) {
    // 64 texels per period: cos 4πx, half a unit long.
    const int size = int(std::ceil(128 / c.options.scale));
    const auto model = fixtures::textured(fixtures::cut_square(c.options), {{size, size}});
    const TexelSpace space(model->surface, model->atlas);
    const Signal xy = coordinates(*model, space);
    const Signal psi = (4 * pi * xy.col(0)).array().cos().matrix();
    const SparseMatrix M = space.mass();
    const auto norm = [&](const Signal& v) { return std::sqrt((v.transpose() * (M * v))(0, 0)); };
    const double lambda = 16 * pi * pi;
    for (double beta : {0.0, 3.0})
      for (double w : {1e-3, 1e-2}) {
        const double gain = (1 + beta * w * lambda) / (1 + w * lambda);
        const Signal phi = ScreenedPoisson(space, w).solve(psi, beta).signal;
        EXPECT_LT(norm(phi - gain * psi), 0.005 * gain * norm(psi))
            << c.name << ' ' << beta << ' ' << w;
      }
  }
}

TEST(TexelConvergence, FilteringKeepsTheMeanAndBetaOneKeepsEverything) {
  const auto model = fixtures::textured(fixtures::cut_square(cases()[2].options), {{60, 60}});
  const TexelSpace space(model->surface, model->atlas);
  Signal psi(space.size(), 3);
  for (int i = 0; i < space.size(); ++i)
    psi.row(i) << (i * 37 % 101) / 101.0, (i * 53 % 89) / 89.0, (i * 29 % 97) / 97.0;
  const ScreenedPoisson equation(space, 1e-3);
  EXPECT_EQ(equation.solve(psi, 1).signal, psi);
  const SparseMatrix M = space.mass();
  const Eigen::RowVectorXd before = Signal::Ones(1, space.size()) * (M * psi);
  for (double beta : {0.0, 3.0}) {
    const Signal phi = equation.solve(psi, beta).signal;
    const Eigen::RowVectorXd after = Signal::Ones(1, space.size()) * (M * phi);
    EXPECT_LT((after - before).cwiseAbs().maxCoeff(), 1e-6);
  }
}

}  // namespace
}  // namespace mq
