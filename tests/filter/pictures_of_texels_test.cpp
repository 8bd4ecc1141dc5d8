// What pictures say of texels, and texels of pictures around charts.

#include <gtest/gtest.h>

#include <limits>

#include "fem/cut_squares.h"
#include "mq/atlas/coverage.h"
#include "mq/base/random.h"
#include "mq/filter/chart_borders.h"
#include "mq/filter/chart_windows.h"
#include "mq/filter/stitch.h"

namespace mq {
namespace {

struct FourCharts {
  fixtures::Cut cut = fixtures::cut("turned", fixtures::turned(fixtures::odd_angle), {96, 80});
  TexelSpace space{cut.model->surface, cut.model->atlas};
};

TEST(LabelsOfPictures, AreThoseOfThePixelUnderEachTexelsCentre) {
  const FourCharts four;
  const std::vector<TextureSize> sizes = {{96, 80}};
  for (const auto& [width, height] : {std::pair(96, 80), std::pair(48, 40), std::pair(192, 160), std::pair(7, 3)}) {
    Image<float> picture(width, height, 1);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) picture(x, y) = float((3 * x + 5 * y) % 11) / 16;
    const std::vector<int> found = labels_of_pictures(four.space.texels(), sizes, std::vector{picture}, std::nullopt);
    ASSERT_EQ(std::ssize(found), four.space.size());
    std::map<int, float> colour_of;
    for (int i = 0; i < four.space.size(); ++i) {
      const Texels::Place& at = four.space.texels().places[std::size_t(i)];
      const int x = int((at.x + 0.5) / 96 * width), y = int((at.y + 0.5) / 80 * height);
      const auto [known, is_new] = colour_of.try_emplace(found[std::size_t(i)], picture(x, y));
      ASSERT_EQ(known->second, picture(x, y)) << i << " of " << width;
    }
    EXPECT_EQ(std::ssize(colour_of), 11);
  }
}

TEST(LabelsOfPictures, NothingIsSeenWhereAPictureIsTransparent) {
  const FourCharts four;
  Image<float> picture(96, 80, 4);
  for (int y = 0; y < 80; ++y)
    for (int x = 0; x < 96; ++x) {
      picture(x, y, 0) = x < 48 ? 0.25F : 0.5F;
      picture(x, y, 3) = y < 20 ? 0.0F : y < 40 ? 0.5F : 1.0F;  // half transparent is seen
    }
  const std::vector<TextureSize> sizes = {{96, 80}};
  const std::vector<float> half = {0.5F, 0, 0};
  for (const bool named : {false, true}) {
    const std::vector<int> found = labels_of_pictures(four.space.texels(), sizes, std::vector{picture},
                                                      named ? std::optional(half) : std::nullopt);
    for (int i = 0; i < four.space.size(); ++i) {
      const Texels::Place& at = four.space.texels().places[std::size_t(i)];
      EXPECT_EQ(found[std::size_t(i)] == unseen, at.y < 20 || (named && at.x >= 48)) << at.x << ", " << at.y;
    }
  }
}

TEST(SpreadPastBorders, OfAllIsTheWholeAndOfNoneIsNothing) {
  const FourCharts four;
  const Coverage coverage = texel_coverage(four.cut.model->surface, four.cut.model->atlas)[0];
  const Random random(2);
  Image<float> picture(96, 80, 3);
  for (std::size_t i = 0; i < picture.values().size(); ++i) picture.values()[i] = float(random.uniform(i));
  Image<float> whole = picture, of_all = picture, of_none = picture;
  EXPECT_GT(spread_past_borders(four.space, 0, coverage, std::numeric_limits<double>::infinity(), whole), 500);
  const auto size = std::size_t(four.space.size());
  spread_past_borders_of(std::vector<char>(size, 1), four.space, 0, coverage, of_all);
  spread_past_borders_of(std::vector<char>(size, 0), four.space, 0, coverage, of_none);
  EXPECT_FALSE(whole == picture);
  EXPECT_TRUE(of_all == whole);
  EXPECT_TRUE(of_none == picture);
}

TEST(ChartWindows, BeyondSeamsLookNearWhatTheyShow) {
  // On a flat square whatever is shown at a place of a window lies there on the surface: so far from its chart's
  // texels as the window says, but for whole texels.
  const FourCharts four;
  const ChartWindows windows(four.cut.model->surface, four.cut.model->atlas, four.space);
  const auto& positions = four.space.texels().positions;
  const double spacing = four.space.scale().texel_spacing;
  constexpr int border = 4;
  int beyond = 0;
  double worst = 0;
  for (int k = 0; k < windows.count(); ++k) {
    const ChartWindow window = windows.window(k, border);
    const auto at = [&](int i) { return positions[std::size_t(window.unknowns[std::size_t(i)])]; };
    for (int i = 0; i < window.width * window.height; ++i) {
      if (window.own[std::size_t(i)] || window.unknowns[std::size_t(i)] < 0) continue;
      // By the nearest own texel two or more to each side.
      double nearest = std::numeric_limits<double>::infinity();
      int from = -1;
      for (int j = 0; j < window.width * window.height; ++j) {
        if (!window.own[std::size_t(j)]) continue;
        const double distance = std::hypot(i % window.width - j % window.width, i / window.width - j / window.width);
        if (distance < nearest) nearest = distance, from = j;
      }
      if (from < 0) continue;
      double squared = 0;
      for (int d = 0; d < 3; ++d) squared += std::pow(at(i)[d] - at(from)[d], 2);
      ++beyond;
      worst = std::max(worst, std::abs(std::sqrt(squared) / spacing - nearest));
    }
  }
  EXPECT_GT(beyond, 300);
  EXPECT_LT(worst, 2.5);
}

}  // namespace
}  // namespace mq
