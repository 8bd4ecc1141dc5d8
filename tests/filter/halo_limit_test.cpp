// Sharpening without halos: what an edge may do, what stays as the equation has it, and that seams do not matter.

#include "mq/filter/halo_limit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "fem/cut_squares.h"
#include "linear/matrices.h"
#include "mq/fem/image_space.h"
#include "mq/filter/live_modulation.h"

namespace mq {
namespace {

constexpr double beta = 3;

std::vector<double> everywhere(const SignalSpace& space, double value) {
  return std::vector<double>(std::size_t(space.size()), value);
}

/// A step of this height in the middle of an image, from 0.1.
Signal step(const ImageSpace& space, int side, double height) {
  Signal psi(space.size(), 1);
  for (int i = 0; i < space.size(); ++i) psi(i, 0) = i % side < side / 2 ? 0.1 : 0.1 + height;
  return psi;
}

TEST(HaloLimit, KeepsWhatAStepOvershootsBelowTheFractionOfIt) {
  constexpr int side = 48;
  constexpr double height = 0.6;
  const ImageSpace space(side, side);
  const ScreenedPoisson equation(space, 9);
  const Signal psi = step(space, side, height), as_said = equation.solve(psi, beta).signal;
  // Of (β − 1)/2 of it, by the equation in one dimension, what is a pixel wide takes a part away.
  EXPECT_GT(as_said.maxCoeff() - 0.1 - height, 0.8 * (beta - 1) / 2 * height);
  for (const double fraction : {0.0, 0.1, 0.4}) {
    const Signal phi =
        solve_without_halos(equation, space, psi, everywhere(space, beta), {.fraction = fraction}).signal;
    const double over = phi.maxCoeff() - 0.1 - height, under = 0.1 - phi.minCoeff();
    EXPECT_LE(over, fraction * height + 1e-6);
    EXPECT_LE(under, fraction * height + 1e-6);
    EXPECT_GE(over, 0.9 * fraction * height);  // and it is made use of
    EXPECT_GE(under, 0.9 * fraction * height);
  }
}

TEST(HaloLimit, MakesASoftEdgeSteeper) {
  constexpr int side = 64;
  const ImageSpace space(side, side);
  Signal psi(space.size(), 1);
  for (int i = 0; i < space.size(); ++i) psi(i, 0) = 0.5 + 0.3 * std::tanh((i % side - 31.5) / 3);
  const Signal phi =
      solve_without_halos(ScreenedPoisson(space, 9), space, psi, everywhere(space, beta)).signal;
  const int middle = side * side / 2 + side / 2;
  EXPECT_GT(phi(middle, 0) - phi(middle - 1, 0), 1.4 * (psi(middle, 0) - psi(middle - 1, 0)));
  EXPECT_LT(phi.maxCoeff(), psi.maxCoeff() + HaloOptions{}.fraction * 0.6);
}

TEST(HaloLimit, SharpensWhereContrastIsLowBitForBitAsTheEquationDoes) {
  constexpr int side = 40;
  const ImageSpace space(side, side);
  const ScreenedPoisson equation(space, 9);
  Signal ramp(space.size(), 2), texture(space.size(), 2);
  const Signal noise = test::random_signal(space.size(), 2);
  for (int i = 0; i < space.size(); ++i) {
    ramp.row(i).setConstant(0.014 * (i % side));  // 6 steps of it lie within reach
    texture.row(i) = ramp.row(i) + 0.004 * noise.row(i);
  }
  ASSERT_LT(noise.cwiseAbs().maxCoeff(), 2);
  for (const Signal& psi : {ramp, texture})
    EXPECT_EQ(solve_without_halos(equation, space, psi, everywhere(space, beta)).signal,
              equation.solve(psi, beta).signal);
}

/// Ripples of half the threshold stay bit for bit, those of three times it become what they are without one.
TEST(HaloLimit, LeavesContrastBelowTheThresholdAlone) {
  constexpr int side = 48;
  const ImageSpace space(side, side);
  const ScreenedPoisson equation(space, 4);
  const auto ripples = [&](double contrast) {
    Signal psi(space.size(), 1);
    for (int i = 0; i < space.size(); ++i) psi(i, 0) = 0.5 + 0.5 * contrast * std::sin(i % side);
    return psi;
  };
  const HaloOptions options{.threshold = 0.02};
  const Signal faint = ripples(0.01), clear = ripples(0.095);
  EXPECT_LT((solve_without_halos(equation, space, faint, everywhere(space, beta), options).signal - faint)
                .cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_EQ(solve_without_halos(equation, space, clear, everywhere(space, beta), options).signal,
            solve_without_halos(equation, space, clear, everywhere(space, beta)).signal);
  EXPECT_GT((equation.solve(faint, beta).signal - faint).cwiseAbs().maxCoeff(), 0.002);
}

TEST(HaloLimit, LeavesAloneWhatDoesNotSharpen) {
  constexpr int side = 40;
  const ImageSpace space(side, side);
  const ScreenedPoisson equation(space, 9);
  const Signal psi = test::random_signal(space.size(), 3);
  EXPECT_EQ(solve_without_halos(equation, space, psi, everywhere(space, 1)).signal, psi);
  for (const double smoothing : {0.0, 0.5})
    EXPECT_EQ(solve_without_halos(equation, space, psi, everywhere(space, smoothing)).signal,
              equation.solve(psi, smoothing).signal);
}

TEST(HaloLimit, SmoothsAsTheEquationDoesFarFromWhereItSharpens) {
  constexpr int side = 64;
  const ImageSpace space(side, side);
  const ScreenedPoisson equation(space, 1);
  const Signal psi = test::random_signal(space.size(), 1);
  std::vector<double> both = everywhere(space, 0);
  for (int i = 0; i < space.size(); ++i)
    if (i % side >= side / 2) both[std::size_t(i)] = beta;
  const Signal limited = solve_without_halos(equation, space, psi, both).signal, all = equation.solve(psi, both).signal;
  double near = 0, far = 0;
  for (int i = 0; i < space.size(); ++i)
    (i % side < 8 ? far : near) = std::max(i % side < 8 ? far : near, std::abs(limited(i, 0) - all(i, 0)));
  EXPECT_LT(far, 1e-6);
  EXPECT_GT(near, 0.1);
}

TEST(HaloLimit, KeepsItsBoundAcrossASeam) {
  fixtures::CutOptions options;
  options.scale = 0.9;
  const std::array<int, 2> size{128, 128};
  const auto model = fixtures::textured(fixtures::cut_square(options), {{size[0], size[1]}});
  const TexelSpace space(model->surface, model->atlas);
  const auto x = fixtures::texels_on_square(options, {size[0], size[1]}, space.texels());
  Signal psi(space.size(), 1);
  // An edge along the cut, a texel beside it: its foot lies across the seam.
  for (int i = 0; i < space.size(); ++i) psi(i, 0) = 0.5 + 0.3 * std::tanh((x[i].x() - 0.51) * 200);
  const ScreenedPoisson equation(space, std::pow(3 * space.scale().texel_spacing, 2));
  const auto overshoot = [&](const Signal& phi) {
    double over = 0, under = 0;
    for (int i = 0; i < space.size(); ++i) {
      if (x[i].x() < 0 || x[i].x() > 1 || x[i].y() < 0 || x[i].y() > 1) continue;
      over = std::max(over, phi(i, 0) - 0.8);
      under = std::max(under, 0.2 - phi(i, 0));
    }
    return std::pair(under, over);
  };
  const auto [under_as_said, over_as_said] = overshoot(equation.solve(psi, beta).signal);
  const auto [under, over] = overshoot(solve_without_halos(equation, space, psi, everywhere(space, beta)).signal);
  const double most = HaloOptions{}.fraction * 0.6;
  EXPECT_GT(std::min(under_as_said, over_as_said), 2 * most);
  EXPECT_LT(std::max(under, over), most);
  EXPECT_GT(std::min(under, over), 0.01);
}

TEST(HaloLimit, IsReachedByABrushToo) {
  const fixtures::Cut cut = fixtures::cut("turned", fixtures::turned(fixtures::odd_angle), {96, 96});
  const TexelSpace space(cut.model->surface, cut.model->atlas);
  const double weight = std::pow(3 * space.scale().texel_spacing, 2);
  const Signal psi = test::random_signal(space.size(), 3);
  const HaloLimit limit(space, psi, {.contrast = 2.2});
  LiveModulation live(space, weight, psi, {.texture = {limit.texture().begin(), limit.texture().end()}});
  std::vector<int> some;
  for (int k = 0; k < space.size(); k += 2) some.push_back(k);
  live.modulate(some, std::vector<double>(some.size(), beta));
  ASSERT_TRUE(live.settle({.tolerance = 1e-9}).converged);
  ASSERT_EQ(live.signal().cols(), 6);
  const ScreenedPoisson equation(space, weight);
  const Signal all = equation.solve(psi, live.beta()).signal,
               texture = equation.solve(psi, limit.of_texture(live.beta())).signal;
  ASSERT_GT((all - texture).cwiseAbs().maxCoeff(), 0.01);
  ASSERT_GT((texture - psi).cwiseAbs().maxCoeff(), 0.01);
  EXPECT_LT((live.signal().leftCols(3) - all).cwiseAbs().maxCoeff(), 1e-5);
  EXPECT_LT((live.signal().rightCols(3) - texture).cwiseAbs().maxCoeff(), 1e-5);
}

TEST(HaloLimit, RefusesWhatMeansNothing) {
  const ImageSpace space(4, 4);
  const Signal psi = Signal::Zero(16, 1);
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  for (const HaloOptions& wrong :
       {HaloOptions{.fraction = -0.1}, HaloOptions{.fraction = nan}, HaloOptions{.contrast = 0},
        HaloOptions{.reach = 0}})
    EXPECT_THROW(HaloLimit(space, psi, wrong), InvalidInput);
  EXPECT_THROW(HaloLimit(space, Signal::Zero(15, 1)), InvalidInput);
  EXPECT_THROW(HaloLimit(space, psi).of_texture(std::vector<double>(3, 1.0)), InvalidInput);
}

}  // namespace
}  // namespace mq
