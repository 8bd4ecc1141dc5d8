#include "mq/video/relight_meter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "fixtures.h"
#include "linear/matrices.h"
#include "mq/fem/vertex_space.h"

namespace mq {
namespace {

using test::random_signal;

TEST(RelightMeter, SaysHowNearSignalsAreToTrueOnesUpToOneFactor) {
  const auto space = std::make_shared<VertexSpace>(make_surface(fixtures::torus(24, 16)));
  const auto texels = std::make_shared<Texels>();
  texels->interior.assign(std::size_t(space->size()), 1);
  RelightMeter meter;
  double squares = 0;
  for (int f = 0; f < 3; ++f) {
    const Signal truth = random_signal(space->size(), 3, f),
                 noise = random_signal(space->size(), 3, 9 + f);
    const Signal was = truth + 0.5 * noise, is = 2 * truth;
    const TemporalFrame frame{space, texels, was,
                              f == 0 ? TimeLinks{} : identical_links(space->size())};
    meter.add(frame, *space, was, is, &truth);
    squares += truth.squaredNorm();
  }
  const RelightMeasures found = meter.finish();
  ASSERT_TRUE(found.before.truth && found.after.truth);
  EXPECT_NEAR(found.after.truth->factor, 0.5, 1e-12);
  EXPECT_LT(found.after.truth->error, 1e-6);
  EXPECT_NEAR(found.after.truth->sharpness, 2, 1e-12);
  EXPECT_GT(found.before.truth->error, 0.1);
  EXPECT_GT(found.before.flicker.values, 0);
}

TEST(RelightMeter, SaysWhatFlickersBesideATruthThatChangesToo) {
  const auto space = std::make_shared<VertexSpace>(make_surface(fixtures::torus(24, 16)));
  const auto texels = std::make_shared<Texels>();
  texels->interior.assign(std::size_t(space->size()), 1);
  RelightMeter meter;
  const double amplitude = 0.1;
  for (int f = 0; f < 4; ++f) {
    const Signal truth = random_signal(space->size(), 3, f);
    const Signal was = truth.array() + (f % 2 == 0 ? amplitude : -amplitude), is = 2 * truth;
    const TemporalFrame frame{space, texels, was, f == 0 ? TimeLinks{} : identical_links(space->size())};
    meter.add(frame, *space, was, is, &truth);
  }
  const RelightMeasures found = meter.finish();
  ASSERT_TRUE(found.before.truth && found.after.truth);
  EXPECT_NEAR(found.before.truth->flicker, std::sqrt(2) * amplitude, 0.03 * amplitude);
  EXPECT_LT(found.after.truth->flicker, 1e-7);
  EXPECT_GT(found.after.flicker.step, 0.5);  // what the truth does
}

TEST(RelightMeter, SaysHowMuchOfGradientsIsLeft) {
  const auto space = std::make_shared<VertexSpace>(make_surface(fixtures::torus(24, 16)));
  const auto texels = std::make_shared<Texels>();
  texels->interior.assign(std::size_t(space->size()), 1);
  const Signal was = random_signal(space->size(), 1, 1), is = 0.25 * was;
  RelightMeter meter;
  meter.add({space, texels, was, {}}, *space, was, is, nullptr);
  meter.add({space, texels, was, identical_links(space->size())}, *space, was, is, nullptr);
  const RelightMeasures found = meter.finish();
  EXPECT_NEAR(found.gradients, 0.25, 1e-12);
  EXPECT_FALSE(found.before.truth || found.after.truth);
  EXPECT_EQ(found.after.flicker.deviation, 0);  // a still picture
}

}  // namespace
}  // namespace mq
