// An image is a flat surface of one chart: its matrices are those of bilinear elements on a grid, and
// what is solved on it is known in closed form.

#include "mq/fem/image_space.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "linear/matrices.h"
#include "mq/base/error.h"
#include "mq/filter/screened_poisson.h"
#include "mq/linear/direct_solver.h"

namespace mq {
namespace {

using std::numbers::pi;

/// cos(π k x/width) at the centres of pixels: no slope at the border.
Signal waves(int width, int height, int k) {
  Signal signal(width * height, 1);
  for (int i = 0; i < signal.rows(); ++i)
    signal(i, 0) = std::cos(pi * k * (i % width + 0.5) / width);
  return signal;
}

TEST(ImageSpace, HasAnUnknownForEachPixelRowByRow) {
  const ImageSpace space(5, 3);
  ASSERT_EQ(space.size(), 15);
  for (int i = 0; i < 15; ++i) {
    EXPECT_EQ(space.texels().places[std::size_t(i)].x, i % 5);
    EXPECT_EQ(space.texels().places[std::size_t(i)].y, i / 5);
    EXPECT_LE((space.positions()[std::size_t(i)] - Vector3(i % 5 + 0.5, 3 - i / 5 - 0.5, 0)).norm(),
              1e-6);
  }
  EXPECT_NEAR(space.scale().area, 15, 1e-12);
  EXPECT_NEAR(space.scale().texel_spacing, 1, 1e-12);
}

TEST(ImageSpace, HasTheMatricesOfBilinearElements) {
  const ImageSpace space(7, 6);
  const SparseMatrix M = space.mass(), S = space.stiffness();
  const int middle = 3 * 7 + 3;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      const int other = middle + 7 * dy + dx;
      const double mass = (dx == 0 ? 4.0 : 1.0) / 6 * (dy == 0 ? 4.0 : 1.0) / 6;
      EXPECT_NEAR(M.coeff(middle, other), mass, 1e-12);
      EXPECT_NEAR(S.coeff(middle, other), dx == 0 && dy == 0 ? 8.0 / 3 : -1.0 / 3, 1e-12);
    }
  EXPECT_NEAR(M.sum(), 42, 1e-10);
  EXPECT_LE((S * Vector::Ones(space.size())).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(ImageSpace, KnowsItsBorder) {
  const ImageSpace space(6, 4);
  std::vector<int> border;
  for (int i = 0; i < 24; ++i)
    if (i % 6 == 0 || i % 6 == 5 || i / 6 == 0 || i / 6 == 3) border.push_back(i);
  EXPECT_EQ(space.boundary(), border);
}

/// The gain (1 + β w λ)/(1 + w λ) of a wave with λ = (π k/width)², where waves are long beside pixels.
TEST(ImageSpace, FiltersWavesByTheirGain) {
  constexpr int width = 256, height = 8, k = 6;
  constexpr double weight = 100;
  const ImageSpace space(width, height);
  const Signal before = waves(width, height, k);
  const double lambda = std::pow(pi * k / width, 2);
  for (const double beta : {0.0, 3.0}) {
    const Signal after = ScreenedPoisson(space, weight).solve(before, beta).signal;
    const double gain = (1 + beta * weight * lambda) / (1 + weight * lambda);
    EXPECT_LE((after - gain * before).cwiseAbs().maxCoeff(), 2e-3) << beta;
  }
}

TEST(ImageSpace, SolvesByMultigridWhatAFactorisationSolves) {
  const ImageSpace space(211, 190);
  EXPECT_GT(space.size(), most_for_factorisation);
  const Signal psi = test::random_signal(space.size(), 3);
  const Filtered own = ScreenedPoisson(space, 50).solve(psi, 0);
  const Filtered direct = ScreenedPoisson(space, 50, direct_solver()).solve(psi, 0);
  EXPECT_TRUE(own.report.converged);
  EXPECT_EQ(own.report.method.find("direct"), std::string::npos);
  EXPECT_LE((own.signal - direct.signal).cwiseAbs().maxCoeff(), 1e-5);
}

TEST(ImageSpace, MovesWhole) {
  ImageSpace first(9, 4);
  const SparseMatrix before = first.stiffness();
  const ImageSpace second = std::move(first);
  EXPECT_EQ((second.stiffness() - before).norm(), 0);
}

TEST(ImageSpace, TakesSinglePixelsAndRefusesNone) {
  EXPECT_EQ(ImageSpace(1, 1).size(), 1);
  EXPECT_EQ(ImageSpace(1, 40).size(), 40);
  EXPECT_THROW(ImageSpace(0, 4), InvalidInput);
  EXPECT_THROW(ImageSpace(4, -1), InvalidInput);
}

}  // namespace
}  // namespace mq
