#include "mq/filter/luminance.h"

#include <gtest/gtest.h>

#include "fem/cut_squares.h"
#include "mq/base/error.h"
#include "mq/base/random.h"
#include "mq/fem/texel_space.h"
#include "mq/filter/screened_poisson.h"

namespace mq {
namespace {

Signal noise_of(Eigen::Index rows, Eigen::Index channels) {
  const Random random(5);
  Signal values(rows, channels);
  for (Eigen::Index i = 0; i < values.size(); ++i) values.data()[i] = random.uniform(std::uint64_t(i));
  return values;
}

TEST(Luminance, OfGreyIsItself) {
  for (const int channels : {1, 2}) {
    const Signal grey = noise_of(40, channels);
    EXPECT_EQ(luminance(grey), Signal(grey.leftCols(1)));
  }
  Signal equal(40, 3);
  equal.colwise() = Vector(noise_of(40, 1).col(0));
  EXPECT_LT((luminance(equal) - Signal(equal.leftCols(1))).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(Luminance, IsWhatItWasSetTo) {
  for (const int channels : {3, 4}) {
    const Signal colours = noise_of(50, channels), wanted = noise_of(50, 1);
    const Signal changed = with_luminance(colours, luminance(colours), wanted);
    EXPECT_LT((luminance(changed) - wanted).cwiseAbs().maxCoeff(), 1e-14);
    // Differences of channels stay, and alpha does.
    const Signal kept = (changed.col(0) - changed.col(1)) - (colours.col(0) - colours.col(1));
    EXPECT_LT(kept.cwiseAbs().maxCoeff(), 1e-15);
    for (int c = 3; c < channels; ++c) EXPECT_EQ(Vector(changed.col(c)), Vector(colours.col(c)));
    EXPECT_EQ(with_luminance(colours, wanted, wanted), colours);
  }
  EXPECT_THROW(luminance(Signal(5, 0)), InvalidInput);
  EXPECT_THROW(with_luminance(noise_of(5, 3), noise_of(4, 1), noise_of(4, 1)), InvalidInput);
}

/// The filter is linear, so where all channels are filtered luminance is filtered too.
TEST(Luminance, IsFilteredAsThatOfAFilteredSignal) {
  const auto model = fixtures::textured(fixtures::cut_square({}), {{48, 48}});
  const TexelSpace space(model->surface, model->atlas);
  const Signal colours = noise_of(space.size(), 3), Y = luminance(colours);
  const ScreenedPoisson equation(space, 1e-3);
  const Signal of_all = luminance(equation.solve(colours, 2.5).signal);
  const Signal changed = with_luminance(colours, Y, equation.solve(Y, 2.5).signal);
  EXPECT_LT((luminance(changed) - of_all).cwiseAbs().maxCoeff(), 1e-3);
}

}  // namespace
}  // namespace mq
