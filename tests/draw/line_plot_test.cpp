// Charts: every value is where its axis says, and nothing else is drawn in its colour.
#include "mq/draw/line_plot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "mq/base/error.h"
#include "mq/draw/detail/text.h"

namespace mq {
namespace {

using testing::HasSubstr;

/// Rows of a column that have the colour of a line, from the bottom of the picture.
std::vector<int> rows_of(const Image<float>& image, int x, int line) {
  const Colour colour = chart_line_colour(line);
  std::vector<int> rows;
  for (int y = image.height() - 1; y >= 0; --y) {
    double off = 0;
    for (int c = 0; c < 3; ++c) off += std::abs(image(x, y, c) - colour[std::size_t(c)]);
    if (off < 0.1) rows.push_back(y);
  }
  return rows;
}

/// The columns that have the colour of a line below the words of the first panel.
std::pair<int, int> columns_of(const Image<float>& image, int line, int top) {
  const Colour colour = chart_line_colour(line);
  int first = image.width(), last = -1;
  for (int y = top; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      double off = 0;
      for (int c = 0; c < 3; ++c) off += std::abs(image(x, y, c) - colour[std::size_t(c)]);
      if (off < 0.1) first = std::min(first, x), last = std::max(last, x);
    }
  return {first, last};
}

constexpr int below_words = 40;

TEST(LineChart, PutsValuesInProportion) {
  // 0, 1 and 3 at the same distances: rows of the middle and the end are as 1 to 3.
  const Image<float> image =
      line_plot({0, 1, 2}, {{.title = "a [m]", .lines = {{"a", {0, 1, 3}}}}});
  const auto [first, last] = columns_of(image, 0, below_words);
  const auto row = [&](int x) {
    const std::vector<int> rows = rows_of(image, x, 0);
    EXPECT_FALSE(rows.empty()) << x;
    double sum = 0;
    int count = 0;
    for (const int y : rows)
      if (y > below_words) sum += y, ++count;
    return sum / count;
  };
  const double bottom = row(first + 3), middle = row((first + last) / 2), top = row(last - 3);
  EXPECT_NEAR((bottom - middle) / (bottom - top), 1 / 3.0, 0.02);
}

TEST(LineChart, PutsPowersOfTenAtEqualSteps) {
  const Image<float> image = line_plot(
      {0, 1, 2},
      {{.title = "a", .lines = {{"a", {0.01, 0.1, 1}}}, .scale = PlotPanel::Scale::logarithmic}});
  const auto [first, last] = columns_of(image, 0, below_words);
  // A straight line then: a quarter of the way along it is a quarter of the way up.
  const auto row = [&](int x) { return double(rows_of(image, x, 0).front()); };
  const double low = row(first + 8), high = row(last - 8);
  EXPECT_NEAR(row((3 * (first + 8) + last - 8) / 4), low + (high - low) / 4, 2);
  EXPECT_LT(high, low - 100);
}

TEST(LineChart, TellsTicksApartHoweverSmallTheRangeIs) {
  // Of words that are all alike the left margin would be as wide as of one digit.
  const auto margin = [](const std::vector<double>& values) {
    const Image<float> image =
        line_plot({0, 1, 2}, {{.title = "a", .lines = {{"a", values}}, .base = 1}});
    return columns_of(image, 0, below_words).first;
  };
  EXPECT_GT(margin({1, 1 + 1e-9, 1 + 2e-9}), margin({1, 3, 9}) + 4 * text_width("0", 2));
}

TEST(LineChart, GivesALineTheColourItIsToldTo) {
  const Image<float> image =
      line_plot({0, 1}, {{.title = "a", .lines = {{.name = "b", .values = {1, 2}, .colour = 1}}}});
  EXPECT_EQ(columns_of(image, 0, below_words).second, -1);
  EXPECT_GT(columns_of(image, 1, below_words).second, 0);
}

TEST(LineChart, LeavesGapsWhereThereIsNoValue) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  const Image<float> image =
      line_plot({0, 1, 2, 3}, {{.title = "a", .lines = {{"a", {1, none, none, 1}}}}});
  const auto [first, last] = columns_of(image, 0, below_words);
  for (int x = first + 20; x < last - 20; ++x)
    for (const int y : rows_of(image, x, 0)) EXPECT_LT(y, below_words) << x;  // the word's line
}

TEST(LineChart, HasAPanelForEachAndDrawsOneFrame) {
  const PlotPanel panel{.title = "a", .lines = {{"a", {2}}, {"b", {1}}}};
  const Image<float> one = line_plot({7}, {panel}), two = line_plot({7}, {panel, panel});
  EXPECT_GT(two.height(), one.height() + 240);
  EXPECT_GE(columns_of(one, 0, below_words).second, 0);
  EXPECT_GE(columns_of(one, 1, below_words).second, 0);
}

TEST(LineChart, HasTicksAtWholeFramesAlone) {
  // Below the axis of three frames are three ticks; of three times, those in between as well.
  const auto ticks = [](double step) {
    const LinePlotOptions options{.text_scale = 1};
    const Image<float> image = line_plot({step, 2 * step, 3 * step},
                                         {{.title = "a", .lines = {{"a", {1, 1, 1}}}}}, options);
    const int head = text_height(1) + 6, y = head + options.panel_height + 1;
    const int words = 28;  // of the axis upward
    int count = 0;
    for (int x = words; x < image.width(); ++x)
      count += image(x, y, 0) < 0.8f && image(x - 1, y, 0) >= 0.8f;
    return count;
  };
  EXPECT_EQ(ticks(1), 3);
  EXPECT_EQ(ticks(2), 5);
  EXPECT_GT(ticks(0.5), 5);
}

TEST(LineChart, IsDrawnOfNothingButZeros) {
  const Image<float> image = line_plot(
      {0, 1}, {{.title = "a", .lines = {{"a", {0, 0}}}, .scale = PlotPanel::Scale::logarithmic},
               {.title = "b", .lines = {{"b", {0, 0}}}}});
  EXPECT_EQ(image.channels(), 3);
  for (const float value : image.values()) ASSERT_TRUE(std::isfinite(value));
}

TEST(LineChart, RefusesWhatItCannotDraw) {
  const auto refusal = [](const std::vector<double>& places, const std::vector<PlotPanel>& panels,
                          const LinePlotOptions& options = {}) {
    try {
      line_plot(places, panels, options);
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const PlotPanel panel{.title = "a", .lines = {{"a", {1, 2}}}};
  EXPECT_THAT(refusal({}, {panel}), HasSubstr("at least one place"));
  EXPECT_THAT(refusal({0, 1}, {}), HasSubstr("one panel"));
  EXPECT_THAT(refusal({0}, {panel}), HasSubstr("2 values for 1 places"));
  EXPECT_THAT(refusal({1, 1}, {panel}), HasSubstr("ascend"));
  EXPECT_THAT(refusal({0, 1}, {panel}, {.width = 100}), HasSubstr("too small"));
}

}  // namespace
}  // namespace mq
