#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "fixtures.h"
#include "mq/draw/contact_sheet.h"
#include "mq/draw/false_colour.h"
#include "mq/draw/detail/text.h"
#include "mq/image/colour.h"
#include "mq/image/compare.h"
#include "mq/image/resample.h"

namespace mq {
namespace {

using fixtures::error_of;
using fixtures::noise;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

double mean(const Image<float>& image) {
  double sum = 0;
  for (const float v : image.values()) sum += v;
  return sum / double(image.values().size());
}

float sampled(const Image<float>& image, double column, double row, Wrap wrap) {
  float value = 0;
  sample(image, column, row, wrap, {&value, 1});
  return value;
}

// ---- Colour spaces ----

TEST(ColourSpace, ComesBackOnAllNumbers) {
  for (double v = -3; v <= 3; v += 0.01) {
    EXPECT_NEAR(srgb_from_linear(linear_from_srgb(v)), v, 1e-7);  // the standard's own rounding
    EXPECT_NEAR(linear_from_log(log_from_linear(v)), v, 1e-13);
    EXPECT_EQ(linear_from_srgb(-v), -linear_from_srgb(v));
  }
}

TEST(ColourSpace, KnowsMiddleGrey) {
  EXPECT_NEAR(linear_from_srgb(0.5), 0.21404114, 1e-8);
  EXPECT_EQ(linear_from_srgb(0), 0);
  EXPECT_NEAR(linear_from_srgb(1), 1, 1e-15);
}

TEST(ColourSpace, LogarithmTurnsRatiosIntoDifferences) {
  EXPECT_NEAR(log_from_linear(0.8) - log_from_linear(0.4), std::log(2), 1e-5);
  EXPECT_NEAR(log_from_linear(1e-7) / 1e-7, 1 / (2 * log_threshold), 1);
}

TEST(ColourSpace, LeavesAlphaAlone) {
  const Image<float> image = noise(5, 4, 4);
  for (const ColourSpace space : {ColourSpace::linear, ColourSpace::log}) {
    const Image<float> decoded = decode(image, space, TransferFunction::srgb);
    const Image<float> back = encode(decoded, space, TransferFunction::srgb);
    for (int x = 0; x < 5; ++x) {
      EXPECT_EQ(decoded(x, 1, 3), image(x, 1, 3));
      EXPECT_NE(decoded(x, 1, 0), image(x, 1, 0));
      EXPECT_NEAR(back(x, 1, 0), image(x, 1, 0), 1e-6);
    }
  }
  EXPECT_EQ(decode(image, ColourSpace::stored, TransferFunction::srgb), image);
  EXPECT_EQ(decode(image, ColourSpace::linear, TransferFunction::linear), image);
}

TEST(ColourSpace, BlendsAlphaAndSpreadsGrey) {
  Image<float> image(1, 1, 2);
  image(0, 0, 0) = 0.5f, image(0, 0, 1) = 0.25f;
  EXPECT_THAT(as_rgb(image, Colour{1, 0, 0}).values(), ElementsAre(0.875f, 0.125f, 0.125f));
  EXPECT_THAT(as_rgb(image, std::nullopt).values(), ElementsAre(0.5f, 0.5f, 0.5f));
}

// ---- Sampling ----

TEST(Sample, IsThePixelAtItsCentre) {
  const Image<float> image = noise(7, 5, 1);
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 7; ++x) EXPECT_EQ(sampled(image, x, y, Wrap::clamp), image(x, y));
}

TEST(Sample, ReproducesBilinearFunctions) {
  Image<float> image(8, 6, 1);
  const auto f = [](double x, double y) { return 1 + 0.5 * x - 0.25 * y + 0.125 * x * y; };
  for (int y = 0; y < 6; ++y)
    for (int x = 0; x < 8; ++x) image(x, y) = float(f(x, y));
  Image<float> one_cell(2, 2, 1);
  EXPECT_NEAR(sampled(image, 3.3, 2.7, Wrap::clamp), f(3.3, 2.7), 1e-6);
  EXPECT_NEAR(sampled(image, 6.9, 4.1, Wrap::repeat), f(6.9, 4.1), 1e-6);
}

TEST(Sample, ClampsOrRepeatsOutside) {
  Image<float> image(4, 1, 1);
  std::iota(image.values().begin(), image.values().end(), 0.f);
  EXPECT_EQ(sampled(image, -5, 0, Wrap::clamp), 0);
  EXPECT_EQ(sampled(image, 9, 3, Wrap::clamp), 3);
  EXPECT_EQ(sampled(image, -0.5, 0, Wrap::clamp), 0);
  EXPECT_EQ(sampled(image, -0.5, 0, Wrap::repeat), 1.5);  // between 3 and 0
  EXPECT_EQ(sampled(image, 3.5, 0, Wrap::repeat), 1.5);
  EXPECT_EQ(sampled(image, -7, 0, Wrap::repeat), 1);
  EXPECT_EQ(sampled(image, 4e6 + 2, 0, Wrap::repeat), 2);
}

TEST(Sample, IsNotSpoiltByANeighbourWithoutWeight) {
  Image<float> image(2, 1, 1);
  image(1, 0) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(sampled(image, 0, 0, Wrap::clamp), 0);
}

// ---- Sizes ----

TEST(AreaScaled, KeepsTheMean) {
  const Image<float> image = noise(37, 23, 3);
  for (const int side : {1, 5, 11, 23})
    EXPECT_NEAR(mean(area_scaled(image, side, side)), mean(image), 1e-6);
}

TEST(AreaScaled, AveragesWholePixels) {
  Image<float> image(4, 2, 1);
  std::iota(image.values().begin(), image.values().end(), 0.f);
  EXPECT_THAT(area_scaled(image, 2, 1).values(), ElementsAre(2.5f, 4.5f));
  EXPECT_EQ(area_scaled(image, 4, 2), image);
  EXPECT_THAT(area_scaled(Image<float>(1, 1, 1, 3), 2, 2).values(), ElementsAre(3, 3, 3, 3));
  EXPECT_THAT(error_of([&] { area_scaled(image, 0, 1); }), HasSubstr("to 0 x 1"));
}

TEST(AreaScaled, FitsWithinASide) {
  EXPECT_EQ(fitted(noise(40, 20, 1), 10).width(), 10);
  EXPECT_EQ(fitted(noise(40, 20, 1), 10).height(), 5);
  EXPECT_EQ(fitted(noise(1000, 2, 1), 100).height(), 1);
  EXPECT_EQ(fitted(noise(4, 2, 1), 10), noise(4, 2, 1));
}

TEST(Cropped, TakesThatPartOrRefuses) {
  const Image<float> image = noise(6, 5, 2);
  const Image<float> part = cropped(image, 2, 1, 3, 4);
  EXPECT_EQ(part(0, 0, 1), image(2, 1, 1));
  EXPECT_EQ(part(2, 3, 0), image(4, 4, 0));
  EXPECT_THAT(error_of([&] { cropped(image, 4, 0, 3, 1); }),
              HasSubstr("leaves a picture of 6 x 5"));
}

// ---- Comparison ----

TEST(Compare, MeasuresAConstantDifference) {
  const Comparison c = compare(Image<float>(9, 200, 3, 0.5f), Image<float>(9, 200, 3, 0.25f));
  EXPECT_DOUBLE_EQ(c.rms, 0.25);
  EXPECT_DOUBLE_EQ(c.psnr, 20 * std::log10(4));
  EXPECT_THAT(c.channel_rms, ElementsAre(0.25, 0.25, 0.25));
  EXPECT_EQ(c.pixels, 1800);
}

TEST(Compare, FindsTheWorstPixelWhereverItLies) {
  const Image<float> a = noise(31, 150, 2);
  Image<float> b = a;
  b(17, 140, 1) += 0.5f;
  const Comparison c = compare(a, b);
  EXPECT_EQ(c.x, 17);
  EXPECT_EQ(c.y, 140);
  EXPECT_EQ(c.channel, 1);
  EXPECT_EQ(c.a, a(17, 140, 1));
  EXPECT_NEAR(c.largest, 0.5, 1e-7);
}

TEST(Compare, IsPerfectForEqualPictures) {
  const Comparison c = compare(noise(3, 3, 1), noise(3, 3, 1));
  EXPECT_EQ(c.rms, 0);
  EXPECT_EQ(c.psnr, std::numeric_limits<double>::infinity());
}

TEST(Compare, LooksOnlyWhereThePictureIsCovered) {
  const Image<float> a(4, 4, 1);
  Image<float> b = a, coverage(4, 4, 1);
  b(0, 0) = std::numeric_limits<float>::quiet_NaN();
  b(1, 1) = 1;
  coverage(1, 1) = 1, coverage(2, 2) = 1;
  EXPECT_DOUBLE_EQ(compare(a, b, {.coverage = &coverage}).rms, std::sqrt(0.5));
  EXPECT_THAT(error_of([&] { compare(a, b); }), HasSubstr("(column 0, row 0)"));
  const Image<float> nothing(4, 4, 1);
  EXPECT_THAT(error_of([&] { compare(a, b, {.coverage = &nothing}); }), HasSubstr("covered"));
  EXPECT_THAT(error_of([&] { compare(a, Image<float>(4, 3, 1)); }), HasSubstr("4 x 3"));
}

// ---- False colours ----

double lightness(const Colour& c) {  // of the CIE: monotone in luminance
  return 0.2126 * linear_from_srgb(c[0]) + 0.7152 * linear_from_srgb(c[1]) +
         0.0722 * linear_from_srgb(c[2]);
}

TEST(FalseColour, GetsLighterWithTheValue) {
  double last = -1;
  for (double v = 0; v <= 1; v += 1 / 64.) {
    const double now = lightness(false_colour(v, {}));
    EXPECT_GT(now, last) << v;
    last = now;
  }
}

TEST(FalseColour, DivergesFromWhite) {
  const FalseColour scale{FalseColour::Map::diverging, -2, 2};
  EXPECT_GT(lightness(false_colour(0, scale)), 0.85);
  EXPECT_GT(false_colour(2, scale)[0], false_colour(2, scale)[2]);
  EXPECT_LT(false_colour(-2, scale)[0], false_colour(-2, scale)[2]);
  EXPECT_EQ(false_colour(-9, scale), false_colour(-2, scale));
}

TEST(FalseColour, ShowsWhatIsNotANumberInGrey) {
  EXPECT_EQ(false_colour(std::nan(""), {}), (Colour{0.5f, 0.5f, 0.5f}));
}

TEST(FalseColour, DrawsIsolinesBetweenBands) {
  Image<float> ramp(100, 4, 1);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 100; ++x) ramp(x, y) = float(x) / 99;
  FalseColour scale;
  scale.isolines = 3;
  const Image<float> picture = false_colour(ramp, scale);
  int lines = 0;
  for (int x = 1; x < 100; ++x) lines += picture(x, 2, 0) == 0.1f;
  EXPECT_EQ(lines, 3);
}

TEST(FalseColour, SpansTheFiniteValues) {
  const std::vector<float> values = {3, -1, std::numeric_limits<float>::infinity(), NAN};
  EXPECT_EQ(scale_of(values).low, -1);
  EXPECT_EQ(scale_of(values).high, 3);
  EXPECT_EQ(scale_of(values, FalseColour::Map::diverging).low, -3);
  EXPECT_EQ(scale_of(std::vector<float>{2}).low, 1.5);
  EXPECT_EQ(scale_of({}).high, 1);
}

TEST(FalseColour, PutsRoundNumbersBesideTheLegend) {
  EXPECT_THAT(round_ticks(0, 1, 5), ElementsAre(0, 0.2, 0.4, ::testing::DoubleEq(0.6), 0.8, 1));
  EXPECT_THAT(round_ticks(-3.3, 7.1, 4), ElementsAre(-2, 0, 2, 4, 6));
  const Image<float> picture = legend({FalseColour::Map::sequential, -1e-3, 2e-3}, {.height = 200});
  EXPECT_EQ(picture.height(), 200);
  EXPECT_THAT(error_of([&] { legend({}, {.height = 20}); }), HasSubstr("height"));
}

// ---- Sheets ----

int dark(const Image<float>& image) {
  int count = 0;
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) count += image(x, y) < 0.5f;
  return count;
}

TEST(ContactSheet, HoldsEveryTileWhole) {
  const Image<float> a(20, 10, 3, 0.25f), b(10, 20, 1, 0.5f), c(20, 20, 4, 1.f);
  const Image<float> page = contact_sheet({{a, "a"}, {b, "a label that is too long"}, {c, ""}},
                                          {.gap = 5, .text_scale = 1});
  double quarter = 0, half = 0;
  for (int y = 0; y < page.height(); ++y)
    for (int x = 0; x < page.width(); ++x)
      quarter += page(x, y) == 0.25f, half += page(x, y) == 0.5f;
  EXPECT_EQ(quarter, 200);
  EXPECT_EQ(half, 200);
}

TEST(ContactSheet, BreaksATitleThatIsWiderThanThePage) {
  // The same words with room for all of them and for one: as many dots, in three lines.
  const auto page = [](int width, const std::string& title) {
    return contact_sheet({{Image<float>(width, 10, 3, 0.9f), ""}},
                         {.gap = 5, .text_scale = 1, .title = title});
  };
  const Image<float> wide = page(400, "captured; followed; distance"),
                     narrow = page(120, "captured; followed; distance");
  EXPECT_EQ(dark(narrow), dark(wide));
  EXPECT_EQ(narrow.height(), wide.height() + 2 * text_height(2));
  EXPECT_EQ(page(120, "").height() + text_height(2) + 5, wide.height());
  EXPECT_LE(page(60, "captured").height(), wide.height());  // a word alone is cut
}

TEST(ContactSheet, RefusesNothing) {
  EXPECT_THAT(error_of([] { contact_sheet({}); }), HasSubstr("at least one"));
  EXPECT_THAT(error_of([] { contact_sheet({{Image<float>(), "x"}}); }), HasSubstr("\"x\""));
}

}  // namespace
}  // namespace mq
