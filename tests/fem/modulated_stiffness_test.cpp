// What is kept of a product with a modulated stiffness gives it again, whatever the modulation.
#include "mq/fem/modulated_stiffness.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "fem/cut_squares.h"
#include "linear/matrices.h"
#include "mq/base/error.h"

namespace mq {
namespace {

std::vector<double> modulation(int size, int seed) {
  const Signal values = test::random_signal(size, 1 + seed);
  std::vector<double> beta;
  for (int k = 0; k < size; ++k) beta.push_back(2 * values(k, seed));
  return beta;
}

/// The rows for two modulations against what the space says, in any order, and asked for again.
void expect_rows_of(const TexelSpace& space, const Signal& psi, const std::string& name) {
  ModulatedStiffness stiffness(space, psi);
  for (const int round : {0, 1}) {
    const std::vector<double> one = modulation(space.size(), 2 * round), other = modulation(space.size(), 2 * round + 1);
    std::vector<int> rows;
    for (int k = space.size() - 1; k >= 0; k -= round == 0 ? 2 : 1) rows.push_back(k);
    const std::array<std::span<const double>, 2> betas = {one, other};
    const Signal found = stiffness.rows(rows, betas);
    ASSERT_EQ(found.cols(), 2 * psi.cols());
    Signal wanted(found.rows(), found.cols());
    wanted << space.stiffness_rows(rows, psi, one), space.stiffness_rows(rows, psi, other);
    ASSERT_GT(wanted.cwiseAbs().maxCoeff(), 0);
    EXPECT_LT((found - wanted).cwiseAbs().maxCoeff(), 1e-12 * wanted.cwiseAbs().maxCoeff()) << name;
  }
}

TEST(ModulatedStiffness, GivesTheRowsOfTheSpaceHoweverItIsCut) {
  for (const fixtures::Cut& cut : fixtures::cut_squares()) {
    const TexelSpace space(cut.model->surface, cut.model->atlas);
    for (const int channels : {1, 3, 5}) expect_rows_of(space, test::random_signal(space.size(), channels), cut.name);
  }
}

TEST(ModulatedStiffness, GivesThemWhereSeamsAreSoftToo) {
  const fixtures::Cut cut = fixtures::cut("turned", fixtures::turned(fixtures::odd_angle), {48, 48});
  TexelSpaceOptions options;
  options.seams = TexelSpaceOptions::Seams::soft;
  options.seam_penalty = 10;
  const TexelSpace space(cut.model->surface, cut.model->atlas, options);
  expect_rows_of(space, test::random_signal(space.size(), 3), cut.name);
}

TEST(ModulatedStiffness, GivesThemWhereATextureRepeats) {
  fixtures::CutOptions cut;
  cut.parts = 1;
  cut.scale = 0.8;
  cut.shift = [](int) { return Vector2(0.5, 0); };
  const auto model = fixtures::textured(fixtures::cut_square(cut), {{64, 64, Wrap::repeat}});
  const TexelSpace space(model->surface, model->atlas);
  expect_rows_of(space, test::random_signal(space.size(), 3), "repeats");
}

TEST(ModulatedStiffness, WantsSignalsAndModulationsOfTheSpace) {
  const fixtures::Cut cut = fixtures::cut("turned", fixtures::turned(fixtures::odd_angle), {48, 48});
  const TexelSpace space(cut.model->surface, cut.model->atlas);
  const Signal psi = test::random_signal(space.size(), 3), few = psi.topRows(2);
  EXPECT_THROW(ModulatedStiffness(space, few), InvalidInput);
  ModulatedStiffness stiffness(space, psi);
  const std::vector<double> beta(3, 1.0);
  const std::array<std::span<const double>, 1> betas = {beta};
  EXPECT_THROW(stiffness.rows(std::vector<int>{0}, betas), InvalidInput);
}

}  // namespace
}  // namespace mq
