// Denoising: what stays, what is kept, what goes, and that seams do not matter.

#include "mq/filter/denoise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "fem/cut_squares.h"
#include "linear/matrices.h"
#include "mq/fem/multigrid_solver.h"
#include "mq/fem/vertex_space.h"
#include "mq/fem/weighted_stiffness_space.h"

namespace mq {
namespace {

constexpr double deviation = 0.1;

/// A step at x = 0.5 from 1 to 3 on a cut square, with noise; and what tells its halves apart.
struct Stepped {
  explicit Stepped(const fixtures::CutOptions& options, int side)
      : model(fixtures::textured(fixtures::cut_square(options), {{side, side}})),
        space(model->surface, model->atlas),
        x(fixtures::texels_on_square(options, {side, side}, space.texels())),
        clean(space.size(), 2),
        noisy(space.size(), 2) {
    const Random random(4);
    for (int i = 0; i < space.size(); ++i) {
      const double value = x[i].x() < 0.5 ? 1 : 3;
      clean.row(i) << value, 2 * value;
      for (int c = 0; c < 2; ++c)
        noisy(i, c) = clean(i, c) + random.uniform(2 * i + c, -deviation, deviation) * std::sqrt(3.0);
    }
  }

  /// Root mean square of the error at texels this far from the step.
  double error(const Signal& signal, double from, double to) const {
    double sum = 0;
    int count = 0;
    for (int i = 0; i < space.size(); ++i) {
      const double away = std::abs(x[i].x() - 0.5);
      if (away < from || away > to || x[i].x() < 0 || x[i].x() > 1) continue;
      sum += (signal.row(i) - clean.row(i)).squaredNorm() / 2;
      ++count;
    }
    return std::sqrt(sum / count);
  }

  std::unique_ptr<fixtures::Textured> model;
  TexelSpace space;
  std::vector<Vector2> x;
  Signal clean, noisy;
};

const fixtures::CutOptions one_chart{.parts = 1, .scale = 0.9};

fixtures::CutOptions nine_charts() {  // the step runs through the middle of charts and over seams
  return fixtures::turned(fixtures::odd_angle, 3);
}

/// Those of the signal itself do not count.
constexpr double no_edges = std::numeric_limits<double>::infinity();

TEST(Denoise, TakesNoiseOffAndKeepsTheEdge) {
  for (const auto& options : {one_chart, nine_charts()}) {
    const Stepped step(options, 160);
    const double h = step.space.scale().texel_spacing;
    const DenoiseOptions wanted{.weight = 16 * h * h, .edge = 0.2, .steps = 2};
    const Signal found = denoise(step.space, step.noisy, {}, wanted).signal;
    const Signal smooth = ScreenedPoisson(step.space, wanted.weight).solve(step.noisy, 0).signal;
    EXPECT_LE(step.error(found, 5 * h, 0.45), 0.25 * deviation);
    EXPECT_LE(step.error(found, 1.5 * h, 5 * h), 0.3 * step.error(smooth, 1.5 * h, 5 * h));
  }
}

TEST(Denoise, KeepsTheEdgesOfAGuide) {
  const Stepped step(nine_charts(), 160);
  const double h = step.space.scale().texel_spacing;
  Guide guide{.values = step.clean.col(0), .edge = 0.05};
  const Signal found = denoise(step.space, step.noisy, {guide}, {.weight = 16 * h * h, .edge = no_edges}).signal;
  EXPECT_LE(step.error(found, 5 * h, 0.45), 0.25 * deviation);
  EXPECT_LE(step.error(found, 1.5 * h, 5 * h), 0.6 * deviation);
}

/// What is measured goes with the noise and not with the resolution, and finds the step.
TEST(Denoise, MeasuresTheNoise) {
  const Stepped fine(one_chart, 160), coarse(one_chart, 80);
  std::vector<double> edges;
  for (const Stepped* step : {&fine, &coarse}) {
    const double h = step->space.scale().texel_spacing;
    const Denoised found = denoise(step->space, step->noisy, {}, {.weight = 16 * h * h});
    EXPECT_LE(step->error(found.signal, 5 * h, 0.45), 0.3 * deviation);
    const Signal smooth = ScreenedPoisson(step->space, 16 * h * h).solve(step->noisy, 0).signal;
    EXPECT_LE(step->error(found.signal, 1.5 * h, 5 * h), 0.3 * step->error(smooth, 1.5 * h, 5 * h));
    edges.push_back(found.edge);
    const Signal twice = 2 * step->noisy;
    EXPECT_NEAR(denoise(step->space, twice, {}, {.weight = 16 * h * h}).edge / found.edge, 2, 1e-6);
    EXPECT_NEAR(denoise(step->space, step->noisy, {}, {.weight = 16 * h * h, .strength = 3}).edge / found.edge, 3, 1e-12);
  }
  EXPECT_NEAR(edges[0] / edges[1], 1, 0.1);
}

TEST(Denoise, LeavesASignalWithoutNoiseAsItIs) {
  const Stepped step(one_chart, 96);
  const Denoised found = denoise(step.space, step.clean, {}, {.weight = 1e-3});
  EXPECT_EQ(found.edge, 0);
  EXPECT_TRUE(found.signal == step.clean);
}

TEST(Denoise, WithoutEdgesIsSmoothing) {
  const VertexSpace space(make_surface(fixtures::torus(30, 20)));
  const Signal psi = test::random_signal(space.size(), 5);
  const Signal a = denoise(space, psi, {}, {.weight = 0.02, .edge = no_edges}).signal,
               b = ScreenedPoisson(space, 0.02).solve(psi, 0).signal;
  EXPECT_LE((a - b).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(Denoise, LeavesConstantsAndMeansAlone) {
  const Stepped step(nine_charts(), 96);
  const DenoiseOptions wanted{.weight = 1e-3, .edge = 0.2, .steps = 2};
  const Signal constant = Signal::Constant(step.space.size(), 3, 7e4);
  EXPECT_TRUE(denoise(step.space, constant, {}, wanted).signal == constant);
  const SparseMatrix M = step.space.mass();
  const Signal found = denoise(step.space, step.noisy, {}, wanted).signal;
  const Vector ones = Vector::Ones(step.space.size());
  const Eigen::RowVectorXd before = ones.transpose() * (M * step.noisy),
                           after = ones.transpose() * (M * found);
  EXPECT_LE((after - before).cwiseAbs().maxCoeff(), 1e-9);
}

/// The steps after the first go on with a solver that was made for other edges.
TEST(Denoise, GivesTheSameWithAnySolver) {
  const Stepped step(nine_charts(), 96);
  const DenoiseOptions wanted{.weight = 1e-3, .edge = 0.2, .steps = 3};
  const Signal direct = denoise(step.space, step.noisy, {}, wanted).signal;
  const Filtered found = denoise(step.space, step.noisy, {}, wanted,
                                 multigrid_solver(step.space.texels(), {.tolerance = 1e-8}));
  EXPECT_TRUE(found.report.converged);
  EXPECT_LE((found.signal - direct).cwiseAbs().maxCoeff(), 1e-5);
}

TEST(WeightedStiffnessSpace, TakesAnotherConductivity) {
  const VertexSpace space(make_surface(fixtures::torus(8, 6)));
  const std::vector<float> one(std::size_t(space.element_count()), 0.5F), other(one.size(), 0.25F);
  WeightedStiffnessSpace changed(space, one);
  changed.set_conductivity(other);
  EXPECT_EQ((changed.system(1, 2) - WeightedStiffnessSpace(space, other).system(1, 2)).norm(), 0);
  EXPECT_GT((changed.system(1, 2) - WeightedStiffnessSpace(space, one).system(1, 2)).norm(), 0);
}

TEST(Denoise, RefusesWhatDoesNotFit) {
  const VertexSpace space(make_surface(fixtures::torus(8, 6)));
  const Signal psi = test::random_signal(space.size(), 1);
  EXPECT_THROW(denoise(space, psi, {}, {.weight = 1, .edge = 0}), InvalidInput);
  EXPECT_THROW(denoise(space, psi, {}, {.weight = 1, .edge = 1, .steps = 0}), InvalidInput);
  EXPECT_THROW(denoise(space, psi, {{Signal::Zero(3, 1), 0.1}}, {.weight = 1}), InvalidInput);
  EXPECT_THROW(WeightedStiffnessSpace(space, {1.0F}), InvalidInput);
  EXPECT_THROW(WeightedStiffnessSpace(space, std::vector<float>(space.element_count(), -1.0F)),
               InvalidInput);
}

}  // namespace
}  // namespace mq
