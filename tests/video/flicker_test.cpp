#include "mq/video/flicker.h"

#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "fem/cut_squares.h"
#include "linear/matrices.h"

namespace mq {
namespace {

constexpr int film_frames = 4;

/// Waves on a square of so many texels that slide by the same part of a texel in every frame, and may flicker.
class SlidingWaves {
 public:
  explicit SlidingWaves(int side) : side_(side) {
    fixtures::CutOptions one;
    one.parts = 1;
    one.jitter = 0;
    model_ = fixtures::textured(fixtures::cut_square(one), {{side, side}});
    space_ = std::make_unique<TexelSpace>(model_->surface, model_->atlas);
  }

  static constexpr double right = 0.7, down = -0.3;  // texels a frame

  enum class Known { drift, nothing };

  /// Of frames to which `flicker(f)` is added, and noise of texels; in the middle of the square.
  template <class Added>
  Flicker measured(const Added& flicker, Known known = Known::drift, double noise = 0) const {
    FrameDrift drift(model_, model_->surface, model_->atlas, *space_);
    if (known == Known::drift) {
      const Signal rest = Signal::Zero(space_->size(), 1);
      drift.follow(rest, rest);
      drift.follow(std::vector<std::array<double, 2>>(drift.field().size(), {right, down}));
    }
    FlickerMeter meter;
    for (int f = 0; f < film_frames; ++f) {
      const Signal shown = waves(f).array() + flicker(f) + noise * test::random_signal(space_->size(), 1, f + 1).array();
      const TimeLinks links = f > 0 ? identical_links(space_->size()) : TimeLinks();
      meter.add(links, middle(), shown, &drift);
    }
    return meter.finish();
  }

 private:
  Signal waves(int f) const {
    Signal values(space_->size(), 1);
    for (int i = 0; i < space_->size(); ++i) {
      const Texels::Place& at = space_->texels().places[std::size_t(i)];
      const double x = (at.x - f * right) / side_, y = (at.y - f * down) / side_;
      values(i, 0) = std::sin(6 * std::numbers::pi * x + 1) * std::cos(4 * std::numbers::pi * y);
    }
    return values;
  }

  std::vector<char> middle() const {
    std::vector<char> result;
    for (const Texels::Place& at : space_->texels().places)
      result.push_back(std::max(std::abs(at.x - side_ / 2), std::abs(at.y - side_ / 2)) < side_ / 4 ? 1 : 0);
    return result;
  }

  int side_;
  std::shared_ptr<const fixtures::Textured> model_;
  std::unique_ptr<TexelSpace> space_;
};

double none(int) { return 0; }

TEST(Flicker, LeavesOutWhatSlidesUnderTexels) {
  const Flicker coarse = SlidingWaves(64).measured(none), fine = SlidingWaves(128).measured(none),
                finest = SlidingWaves(256).measured(none);
  ASSERT_TRUE(coarse.along && fine.along && finest.along);
  EXPECT_LT(*coarse.along, 0.02 * coarse.step);
  // What lookups lose is of third order, but for extrema, as they stay within values.
  EXPECT_GT(std::log2(*coarse.along / *fine.along), 2.3);
  EXPECT_GT(std::log2(*fine.along / *finest.along), 2.3);
}

TEST(Flicker, IsAsLargeAsItIsUnderWhatSlides) {
  const double amplitude = 0.02;
  const Flicker found = SlidingWaves(128).measured([&](int f) { return f % 2 == 0 ? amplitude : -amplitude; });
  ASSERT_TRUE(found.along);
  EXPECT_NEAR(*found.along, std::numbers::sqrt2 * amplitude, 0.005 * amplitude);
  EXPECT_GT(found.step, 1.2 * *found.along);
}

TEST(Flicker, OfTexelsIsWhatLookupsLeaveOfIt) {
  const double noise = 0.1, whole = SlidingWaves(64).measured(none, SlidingWaves::Known::drift, noise).along.value(),
               plain = SlidingWaves(64).measured(none, SlidingWaves::Known::nothing, noise).step;
  EXPECT_GT(whole, 0.5 * noise / std::sqrt(3.0));
  EXPECT_LT(whole, 1.05 * noise / std::sqrt(3.0));
  EXPECT_GT(plain, whole);
}

TEST(Flicker, IsNotSaidAlongADriftThatNobodyFollowed) {
  EXPECT_FALSE(SlidingWaves(64).measured(none, SlidingWaves::Known::nothing).along);
}

}  // namespace
}  // namespace mq
