// Gains of regions: steps that are the same along a border are found whatever else is there, and nothing is invented.
#include "mq/filter/region_levels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "mq/base/error.h"
#include "mq/fem/image_space.h"
#include "mq/image/colour.h"

namespace mq {
namespace {

constexpr int width = 60, height = 40;

/// A picture of strips, each a region.
class RegionLevelsTest : public testing::Test {
 protected:
  RegionLevelsTest() : space_(width, height), stiffness_(space_.stiffness()), mass_(space_.lumped_mass()) {}

  std::vector<int> strips(int count) const {
    std::vector<int> labels;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) labels.push_back(x * count / width);
    return labels;
  }

  Signal of(int channels, const auto& function) const {
    Signal signal(width * height, channels);
    for (int i = 0; i < width * height; ++i)
      for (int c = 0; c < channels; ++c) signal(i, c) = function(i % width, i / width, c);
    return signal;
  }

  RegionLevels of_regions(const Signal& psi, const std::vector<int>& labels, LightLaw law) const {
    return {stiffness_, mass_, psi, labels, law};
  }

  ImageSpace space_;
  SparseMatrix stiffness_;
  Vector mass_;
};

/// Logarithms of the gains that three strips were taken with.
constexpr double taken[3][3] = {{0.1, -0.2, 0.3}, {-0.05, 0.3, -0.1}, {0.2, 0.05, 0}};

/// Light of 0.3 as strips show it, in values of a law; the rest of the channels is 0.7.
double shown(LightLaw law, int x, int c) {
  if (c == 3) return 0.7;
  const double light = 0.3 * std::exp(taken[x * 3 / width][c]);
  if (law == LightLaw::log) return log_from_linear(light);
  return law == LightLaw::linear ? light : srgb_from_linear(light);
}

TEST_F(RegionLevelsTest, TakeGainsOutWhateverValuesAreOfLight) {
  const std::vector<int> labels = strips(3);
  for (const LightLaw law : {LightLaw::log, LightLaw::linear, LightLaw::display}) {
    const Signal psi = of(4, [&](int x, int, int c) { return shown(law, x, c); });
    const RegionLevels levels = of_regions(psi, labels, law);
    const Signal after = levels.raised(psi, labels);
    EXPECT_EQ(levels.gains().cols(), 3) << "the fourth channel is alpha";
    EXPECT_EQ(after.col(3), psi.col(3));
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(after.col(c).maxCoeff(), after.col(c).minCoeff(), 1e-3) << "held by a ten-thousandth";
    EXPECT_LT(levels.gains().colwise().mean().cwiseAbs().maxCoeff(), 1e-9) << "strips are equally wide";
  }
}

TEST_F(RegionLevelsTest, GoByWhatMostOfABorderShows) {
  // Something dark stands before a third of the second strip's left border.
  const std::vector<int> labels = strips(3);
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 0.005);
  const Signal psi = of(3, [&](int x, int y, int c) {
    const bool hidden = x >= 20 && x < 30 && y < height / 3;
    return (hidden ? 0.2 : 1) * shown(LightLaw::display, x, c) + noise(random);
  });
  const Signal gains = of_regions(psi, labels, LightLaw::display).gains();
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(gains(1, c) - gains(0, c), taken[0][c] - taken[1][c], 0.03) << "the mean would be off by a third";
}

TEST_F(RegionLevelsTest, DoNotBelieveWhatIsWhiteOrBlack) {
  // Two thirds of each border show nothing: paper that is overexposed on both sides, and a hole.
  const std::vector<int> labels = strips(3);
  const Signal psi = of(3, [&](int x, int y, int c) {
    return y % 3 == 0 ? 1.0 : y % 3 == 1 ? 0.0 : shown(LightLaw::display, x, c);
  });
  const Signal gains = of_regions(psi, labels, LightLaw::display).gains();
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(gains(1, c) - gains(0, c), taken[0][c] - taken[1][c], 1e-3);
}

TEST_F(RegionLevelsTest, BelieveLightAsMuchAsItIsAboveTheDark) {
  // Three rows of four are dim and show other gains. Light of 0.02 counts a half: three rows of 0.05 count 3 · 5/7 where
  // one of 0.3 counts 15/16; three of 0.004 count 3 · 1/6.
  const std::vector<int> labels = strips(2);
  for (const LightLaw law : {LightLaw::log, LightLaw::linear, LightLaw::display})
    for (const double dim : {0.05, 0.004}) {
      const Signal psi = of(3, [&](int x, int y, int) {
        const double light = (y % 4 == 0 ? 0.3 : dim) * std::exp(x < width / 2 ? 0 : y % 4 == 0 ? 0.2 : -0.3);
        return law == LightLaw::log ? log_from_linear(light) : law == LightLaw::linear ? light : srgb_from_linear(light);
      });
      const Signal gains = of_regions(psi, labels, law).gains();
      // Where they disagree neither has its way altogether.
      if (dim > 0.02)
        EXPECT_GT(gains(1, 0) - gains(0, 0), 0.1) << int(law);
      else
        EXPECT_LT(gains(1, 0) - gains(0, 0), -0.1) << int(law);
    }
}

TEST_F(RegionLevelsTest, LeaveWhatIsUnseenAndWhatIsAlone) {
  std::vector<int> labels = strips(3);
  for (int& label : labels)
    if (label == 1) label = unseen;
  const Signal psi = of(3, [&](int x, int, int c) { return shown(LightLaw::linear, x, c); });
  const RegionLevels levels = of_regions(psi, labels, LightLaw::linear);
  EXPECT_EQ(levels.gains().rows(), 3);
  EXPECT_EQ(levels.gains().cwiseAbs().maxCoeff(), 0) << "nothing borders on anything";
  EXPECT_EQ(levels.raised(psi, labels), psi);
  EXPECT_EQ(RegionLevels().raised(psi, labels), psi);
  EXPECT_EQ(of_regions(psi, std::vector<int>(labels.size(), unseen), LightLaw::linear).gains().rows(), 0);
}

TEST_F(RegionLevelsTest, RefuseOtherSizes) {
  const Signal psi = Signal::Zero(width * height, 1);
  EXPECT_THROW(of_regions(psi, std::vector<int>(3, 0), LightLaw::log), InvalidInput);
  EXPECT_THROW(of_regions(Signal::Zero(5, 1), strips(2), LightLaw::log), InvalidInput);
}

}  // namespace
}  // namespace mq
