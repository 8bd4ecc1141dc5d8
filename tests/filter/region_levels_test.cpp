// Levels of regions: steps that are the same along a border are found whatever else is there, and nothing is invented.
#include "mq/filter/region_levels.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "mq/base/error.h"
#include "mq/fem/image_space.h"
#include "mq/filter/stitch.h"

namespace mq {
namespace {

constexpr int width = 60, height = 40;

/// A picture of strips, each a region.
class RegionLevels : public testing::Test {
 protected:
  RegionLevels() : space_(width, height), stiffness_(space_.stiffness()), mass_(space_.lumped_mass()) {}

  std::vector<int> strips(int count) const {
    std::vector<int> labels;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) labels.push_back(x * count / width);
    return labels;
  }

  Signal of(const auto& function) const {
    Signal signal(width * height, 2);
    for (int i = 0; i < width * height; ++i)
      for (int c = 0; c < 2; ++c) signal(i, c) = function(i % width, i / width, c);
    return signal;
  }

  Signal levels(const Signal& psi, const std::vector<int>& labels) const {
    return region_levels(stiffness_, mass_, psi, labels);
  }

  ImageSpace space_;
  SparseMatrix stiffness_;
  Vector mass_;
};

constexpr double offsets[3][2] = {{0.1, -0.2}, {-0.05, 0.3}, {0.2, 0.05}};

TEST_F(RegionLevels, TakeOffsetsOutAndKeepTheMean) {
  const std::vector<int> labels = strips(3);
  const Signal psi = of([&](int x, int, int c) { return 0.5 + offsets[x * 3 / width][c]; });
  const Signal found = levels(psi, labels), after = with_levels(psi, found, labels);
  for (int c = 0; c < 2; ++c) {
    EXPECT_NEAR(after.col(c).maxCoeff(), after.col(c).minCoeff(), 2e-4) << "held by a ten-thousandth";
    EXPECT_NEAR(mass_.dot(after.col(c)), mass_.dot(psi.col(c)), 1e-9 * mass_.sum());
  }
}

TEST_F(RegionLevels, GoByWhatMostOfABorderShows) {
  // Something dark stands before a third of the second strip's left border.
  const std::vector<int> labels = strips(3);
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 0.01);
  const Signal psi = of([&](int x, int y, int c) {
    const bool hidden = x >= 20 && x < 30 && y < height / 3;
    return (hidden ? 0.0 : 0.5) + offsets[x * 3 / width][c] + noise(random);
  });
  const Signal found = levels(psi, labels);
  for (int c = 0; c < 2; ++c)
    EXPECT_NEAR(found(1, c) - found(0, c), offsets[0][c] - offsets[1][c], 0.02) << "the mean would be off by 0.17";
}

TEST_F(RegionLevels, LeaveWhatIsUnseenAndWhatIsAlone) {
  std::vector<int> labels = strips(3);
  for (int& label : labels)
    if (label == 1) label = unseen;
  const Signal psi = of([&](int x, int, int c) { return offsets[x * 3 / width][c]; });
  const Signal found = levels(psi, labels);
  EXPECT_EQ(found.rows(), 3);
  EXPECT_EQ(found.cwiseAbs().maxCoeff(), 0) << "nothing borders on anything";
  EXPECT_EQ(with_levels(psi, found, labels), psi);
  EXPECT_EQ(levels(psi, std::vector<int>(labels.size(), unseen)).rows(), 0);
}

TEST_F(RegionLevels, RefuseOtherSizes) {
  const Signal psi = Signal::Zero(width * height, 1);
  EXPECT_THROW(levels(psi, std::vector<int>(3, 0)), InvalidInput);
  EXPECT_THROW(region_levels(stiffness_, mass_, Signal::Zero(5, 1), strips(2)), InvalidInput);
}

}  // namespace
}  // namespace mq
