// Filters that work more strongly here than there.
#include "mq/filter/modulation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "fem/cut_squares.h"
#include "fixtures.h"
#include "linear/matrices.h"
#include "mq/base/error.h"
#include "mq/fem/vertex_space.h"
#include "mq/filter/screened_poisson.h"
#include "mq/linear/direct.h"

namespace mq {
namespace {

using fixtures::Cut;
using fixtures::places_of;
using testing::HasSubstr;

/// ∫ β ⟨∇ψ, ∇φ_i⟩ piece by piece with β the mean over the corners of each cell: nothing of what
/// `stiffness_times` keeps is used.
Signal modulated_moments(const Cut& cut, const TexelSpace& space, const Signal& psi,
                         const std::vector<double>& beta) {
  const Atlas& atlas = cut.model->atlas;
  std::map<std::array<int, 3>, int> number;
  for (int i = 0; i < space.size(); ++i) {
    const Texels::Place& p = space.texels().places[i];
    number[{p.texture, p.x, p.y}] = i;
  }
  Signal result = Signal::Zero(space.size(), psi.cols());
  space.for_each_piece([&](const TexelSamples& samples) {
    // The cell, from the place of the first point.
    const auto& corners = atlas.corners[samples.triangle];
    double x = 0, y = 0;
    for (int k = 0; k < 3; ++k) {
      x += samples.barycentric(0, k) * corners[k].column();
      y += samples.barycentric(0, k) * corners[k].row();
    }
    double b = 0;
    for (int dx = 0; dx < 2; ++dx)
      for (int dy = 0; dy < 2; ++dy)
        b += beta[number.at({0, int(std::floor(x)) + dx, int(std::floor(y)) + dy})] / 4;
    const TexelMetric metric = texel_metric(cut.model->surface, atlas, samples.triangle);
    const auto count = Eigen::Index(samples.texels.size());
    Signal local(count, psi.cols());
    for (Eigen::Index k = 0; k < count; ++k) local.row(k) = psi.row(samples.texels[k]);
    const Signal gx = samples.dx * local, gy = samples.dy * local;
    const Signal fx = samples.weights.asDiagonal() * (metric.a * gx + metric.b * gy);
    const Signal fy = samples.weights.asDiagonal() * (metric.b * gx + metric.c * gy);
    const Signal sum = b * (samples.dx.transpose() * fx + samples.dy.transpose() * fy);
    for (Eigen::Index k = 0; k < count; ++k) result.row(samples.texels[k]) += sum.row(k);
  });
  return result;
}

/// A prepared equation given one mask after another gives what assembling everything anew for each
/// gives.
TEST(Modulation, NeedsNoNewFactorisation) {
  const double w = 2e-3;
  const Cut cut = fixtures::cut("", fixtures::turned(fixtures::odd_angle), {48, 48});
  const TexelSpace space(cut.model->surface, cut.model->atlas);
  const Signal psi = test::random_signal(space.size(), 2);
  const ScreenedPoisson prepared(space, w);
  const std::vector<Vector3> places = places_of(space);
  for (const double x : {0.2, 0.5, 0.8}) {
    std::vector<double> mask(places.size(), 0.0);
    add_spots(std::vector<Spot>{{.center = {x, 0.4, 0}, .radius = 0.3}}, places, mask);
    const std::vector<double> beta = modulation(mask, 4);
    const Signal anew =
        DirectSolver(space.regularised_system(1, w))
            .solve(w * (modulated_moments(cut, space, psi, beta) - space.stiffness_times(psi)));
    const Signal change = prepared.solve(psi, beta).signal - psi;
    EXPECT_GT(change.cwiseAbs().maxCoeff(), 0.1);
    EXPECT_LT((change - anew).cwiseAbs().maxCoeff(), 1e-6 * change.cwiseAbs().maxCoeff()) << x;
  }
}

TEST(Modulation, EqualEverywhereIsThePlainFilterBitForBit) {
  const Cut cut = fixtures::cut("", fixtures::turned(fixtures::odd_angle), {48, 48});
  const TexelSpace texels(cut.model->surface, cut.model->atlas);
  const VertexSpace vertices(cut.model->surface);
  for (const SignalSpace* space : std::initializer_list<const SignalSpace*>{&texels, &vertices}) {
    const Signal psi = test::random_signal(space->size(), 3);
    const ScreenedPoisson equation(*space, 1e-3);
    const std::vector<double> full(space->size(), 1.0), none(space->size(), 0.0);
    for (const double beta : {0.0, 0.1, 3.0})
      EXPECT_TRUE(equation.solve(psi, modulation(full, beta)).signal ==
                  equation.solve(psi, beta).signal)
          << beta;
    EXPECT_TRUE(equation.solve(psi, modulation(none, 3)).signal == psi);
  }
}

/// What is changed in one place fades like exp(−distance / length) elsewhere.
TEST(Modulation, LeavesFarAwayAlone) {
  const VertexSpace space(make_surface(fixtures::flat_square(60)));
  const std::vector<Vector3> places = make_surface(fixtures::flat_square(60)).mesh.positions;
  std::vector<double> mask(places.size(), 0.0);
  add_spots(std::vector<Spot>{{.center = {0.2, 0.5, 0}, .radius = 0.15}}, places, mask);
  const Signal psi = test::random_signal(space.size(), 1);
  const double length = 0.03;
  const Signal change =
      ScreenedPoisson(space, length * length).solve(psi, modulation(mask, 0)).signal - psi;
  double near = 0, far = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double d = (places[i] - Vector3(0.2, 0.5, 0)).norm() - 0.15;
    double& largest = d < 0 ? near : far;
    if (d < 0 || d > 10 * length) largest = std::max(largest, std::abs(change(i, 0)));
  }
  EXPECT_GT(near, 0.05);
  EXPECT_LT(far, 2 * std::exp(-10.0) * near);
}

TEST(Modulation, SmoothsBelowZeroWhateverBetaIs) {
  const std::vector<double> mask = {-1, -0.5, 0, 0.5, 1};
  EXPECT_THAT(modulation(mask, 3), testing::ElementsAre(0, 0.5, 1, 2, 3));
  EXPECT_THAT(modulation(mask, 9), testing::ElementsAre(0, 0.5, 1, 5, 9));
}

/// The equation is linear in β − 1: what sharpens and what smooths add up.
TEST(Modulation, SharpensHereAsIfItDidNotSmoothThere) {
  const VertexSpace space(make_surface(fixtures::flat_square(30)));
  const std::vector<Vector3> places = make_surface(fixtures::flat_square(30)).mesh.positions;
  std::vector<double> both, sharpens, smooths;
  for (const Vector3& p : places) {
    both.push_back(std::clamp(3 * (p.x() - 0.5), -1.0, 1.0));
    sharpens.push_back(std::max(0.0, both.back()));
    smooths.push_back(std::max(0.0, -both.back()));
  }
  const Signal psi = test::random_signal(space.size(), 2);
  const ScreenedPoisson equation(space, 0.001);
  const Signal sum = equation.solve(psi, modulation(sharpens, 4)).signal +
                     equation.solve(psi, modulation(smooths, 0)).signal - psi;
  EXPECT_LT((equation.solve(psi, modulation(both, 4)).signal - sum).cwiseAbs().maxCoeff(), 1e-10);
}

TEST(Spots, GiveAllOfTheirStrengthWhereTheyAreHard) {
  const Spot soft{.radius = 2, .strength = 0.8}, half{.radius = 2, .strength = 0.8, .hardness = 0.5},
      hard{.radius = 2, .strength = 0.8, .hardness = 1};
  const auto at = [](double x) { return Vector3(x, 0, 0); };
  EXPECT_EQ(paint_at(half, at(0)), 0.8);
  EXPECT_EQ(paint_at(half, at(0.99)), 0.8);
  EXPECT_LT(paint_at(soft, at(0.99)), 0.5);
  EXPECT_NEAR(paint_at(half, at(1.5)), 0.8 * std::pow(1 - 0.25, 2), 1e-12);  // halfway from hard to nothing
  EXPECT_EQ(paint_at(hard, at(1.999)), 0.8);
  for (const Spot& spot : {soft, half, hard}) {
    EXPECT_EQ(paint_at(spot, at(2)), 0);
    EXPECT_EQ(paint_at(spot, at(3)), 0);
  }
}

TEST(Spots, RaiseWhatIsBelowZeroAndTakeNothingFromIt) {
  const std::vector<Vector3> places(3, Vector3::Zero());
  std::vector<double> mask = {-0.8, 0, 0.6};
  add_spots(std::vector<Spot>{{.radius = 1, .strength = -0.5}}, places, mask);
  EXPECT_THAT(mask, testing::Pointwise(testing::DoubleEq(), {-0.8, 0.0, 0.6 - 0.5}));
  add_spots(std::vector<Spot>{{.radius = 1, .strength = 0.5}}, places, mask);
  EXPECT_THAT(mask, testing::Pointwise(testing::DoubleEq(), {-0.8 + 0.5, 0.5, 0.6 - 0.5 + 0.5}));
}

TEST(Masks, HoldValuesBelowZeroWhereTheyAreAskedTo) {
  Texels texels;
  for (int x = 0; x < 3; ++x) texels.places.push_back({0, x, 0});
  const std::vector<TextureSize> sizes = {{3, 1, Wrap::clamp}};
  Image<float> picture(3, 1, 1);
  picture(0, 0) = -0.5F, picture(1, 0) = -3, picture(2, 0) = 0.25F;
  EXPECT_THAT(mask_of_pictures(texels, sizes, std::vector{picture}, -1),
              testing::ElementsAre(-0.5, -1, 0.25));
  EXPECT_THAT(mask_of_pictures(texels, sizes, std::vector{picture}),
              testing::ElementsAre(0, 0, 0.25));
}

TEST(Spots, AreSmoothRoundAndClamped) {
  const std::vector<Vector3> places = {{0, 0, 0}, {0.5, 0, 0}, {0, 0, 0.5}, {1, 0, 0}, {2, 0, 0}};
  std::vector<double> mask(5, 0.0);
  add_spots(std::vector<Spot>{{.center = {0, 0, 0}, .radius = 1, .strength = 0.5}}, places, mask);
  EXPECT_THAT(mask, testing::ElementsAre(0.5, 0.28125, 0.28125, 0.0, 0.0));
  add_spots(std::vector<Spot>{{.center = {0, 0, 0}, .radius = 9}}, places, mask);
  EXPECT_EQ(mask[0], 1);
  add_spots(std::vector<Spot>{{.center = {2, 0, 0}, .radius = 0.5, .strength = -1}}, places, mask);
  EXPECT_EQ(mask[4], 0);
  EXPECT_GT(mask[3], 0.9);
}

TEST(Masks, OfPicturesAreInTheTexturesCoordinates) {
  Texels texels;
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 8; ++x) texels.places.push_back({0, x, y});
  const std::vector<TextureSize> sizes = {{8, 4, Wrap::clamp}};
  const Image<float> same = fixtures::noise(8, 4, 1);
  const auto mask = mask_of_pictures(texels, sizes, std::vector{same});
  for (int i = 0; i < 32; ++i) EXPECT_EQ(mask[i], same.values()[i]);

  // A ramp along u at another size is the same ramp, away from the border.
  Image<float> ramp(80, 10, 4);
  for (int y = 0; y < 10; ++y)
    for (int x = 0; x < 80; ++x)
      ramp(x, y, 0) = ramp(x, y, 1) = ramp(x, y, 2) = float((x + 0.5) / 80);
  const auto slope = mask_of_pictures(texels, sizes, std::vector{ramp});
  for (int i = 0; i < 32; ++i) EXPECT_NEAR(slope[i], (i % 8 + 0.5) / 8, 1e-6);
}

TEST(Masks, OfVerticesAreLinearInTriangles) {
  const Mesh mesh = fixtures::flat_square(4, 0.2);
  std::vector<double> values;
  for (const Vector3& p : mesh.positions) values.push_back(0.2 + 0.5 * p.x() + 0.3 * p.y());
  const std::vector<Vector3> places = {{0.31, 0.77, 0}, {0.5, 0.1, 0.01}, {1.2, 0.5, 0}};
  const auto mask = mask_of_vertices(mesh, values, places);
  EXPECT_NEAR(mask[0], 0.2 + 0.155 + 0.231, 1e-12);
  EXPECT_NEAR(mask[1], 0.2 + 0.25 + 0.03, 1e-12);
  EXPECT_NEAR(mask[2], 0.2 + 0.5 + 0.15, 1e-12);
}

TEST(Masks, AreRefusedWhereTheyDoNotFit) {
  Texels texels;
  texels.places = {{0, 0, 0}};
  const std::vector<TextureSize> sizes = {{1, 1, Wrap::clamp}};
  const auto error = [&](const std::vector<Image<float>>& pictures) {
    return fixtures::error_of([&] { mask_of_pictures(texels, sizes, pictures); });
  };
  EXPECT_THAT(error({}), HasSubstr("0 mask pictures for 1 textures"));
  EXPECT_THAT(error({Image<float>()}), HasSubstr("no pixels"));
  EXPECT_THAT(error({Image<float>(1, 1, 1, std::nanf(""))}), HasSubstr("not a number"));
  std::vector<double> mask(1);
  EXPECT_THAT(fixtures::error_of([&] {
                add_spots(std::vector<Spot>{{.radius = -1}}, std::vector<Vector3>(1), mask);
              }),
              HasSubstr("radius"));
  EXPECT_THAT(fixtures::error_of(
                  [&] { mask_of_vertices(fixtures::one_triangle(), std::vector<double>(2), {}); }),
              HasSubstr("2 values was given for 3 vertices"));
}

}  // namespace
}  // namespace mq
