// Letters in pictures: where they stand, and that no text and no place is too odd.
#include "mq/draw/detail/text.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "mq/base/error.h"
#include "mq/draw/detail/dot_font.h"

namespace mq {
namespace {

/// The columns and rows that are not white any more, of a picture that was.
struct Box {
  int left = 1000, right = -1, top = 1000, bottom = -1;
};

Box inked(const Image<float>& image) {
  Box box;
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x)
      if (image(x, y) < 0.9F)
        box = {std::min(box.left, x), std::max(box.right, x), std::min(box.top, y), std::max(box.bottom, y)};
  return box;
}

Box box_of(const std::string& text, TextStyle style, int x = 200, int y = 40) {
  Image<float> image(400, 120, 1, 1.0F);
  draw_text(image, x, y, text, style);
  return inked(image);
}

TEST(Text, StandsOnItsLineAsHighAsItsScaleSays) {
  for (const int scale : {1, 2, 4}) {
    const Box capital = box_of("H", {.scale = scale});
    EXPECT_NEAR(capital.bottom + 1 - 40, 7 * scale, 1) << "on the line";
    EXPECT_NEAR(capital.bottom + 1 - capital.top, 7 * scale, 0.15 * 7 * scale + 1);
    EXPECT_GT(box_of("g", {.scale = scale}).bottom, capital.bottom) << "below it";
    EXPECT_LE(box_of("g\u00c4|", {.scale = scale}).bottom, 40 + text_height(scale) + scale);
  }
}

TEST(Text, IsAsWideAsItSays) {
  EXPECT_EQ(text_width("", 2), 0);
  EXPECT_EQ(text_width("ab", 2), text_width("a", 2) + text_width("b", 2));
  const int width = text_width("after 12.5 %", 2);
  const Box left = box_of("after 12.5 %", {.anchor = TextStyle::Anchor::left});
  const Box centre = box_of("after 12.5 %", {.anchor = TextStyle::Anchor::centre});
  const Box right = box_of("after 12.5 %", {.anchor = TextStyle::Anchor::right});
  EXPECT_EQ(left.left - right.left, width);
  EXPECT_EQ(left.left - centre.left, width / 2);
  EXPECT_LE(left.right - left.left, width);
}

TEST(Text, TakesAnyBytes) {
  // Characters of two to four bytes, and what is none: a byte that only follows, one that misses some, 0xFF.
  for (const std::string text : {"\u00e4\u2211\U0001F600", "\x80", "\xe2\x88", "\xff\xfe", "a\xc3"}) {
    EXPECT_GT(text_width(text, 2), 0) << text;
    EXPECT_GE(box_of(text, {}).right, 0) << text;
  }
  EXPECT_EQ(text_width("\xe2\x88x", 2) - text_width("x", 2), 2 * text_width("\x80", 2));
}

TEST(Text, IsCutOffAtTheSidesAndMakesItselfSeen) {
  Image<float> image(20, 20, 4, 0.0F);
  draw_text(image, -5, -5, "MMMMMM", {.colour = {1, 0.5F, 0.25F}, .scale = 4});
  double most = 0;
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 20; ++x) most = std::max(most, double(image(x, y, 3)));
  EXPECT_EQ(most, 1) << "alpha";
  EXPECT_THROW(draw_text(image, 0, 0, "a", {.scale = 0}), InvalidInput);
}

TEST(Text, HasDotsForEveryCharacterOfAscii) {
  std::vector<Glyph> glyphs;
  for (char32_t c = U' '; c < 127; ++c) {
    const Glyph drawn = dot_glyph(c, 1);
    EXPECT_EQ(std::ranges::count(drawn.coverage, 0) == 45, c == U' ') << int(c);
    for (const Glyph& other : glyphs) EXPECT_NE(drawn.coverage, other.coverage) << int(c);
    glyphs.push_back(drawn);
  }
}

TEST(Text, HasDotsWhereThereIsNoFont) {
  const Glyph one = dot_glyph(U'1', 3), odd = dot_glyph(U'\u2211', 1);
  EXPECT_EQ(one.advance, 18);
  EXPECT_EQ(one.coverage.size(), std::size_t(15 * 27));
  EXPECT_EQ(std::count(one.coverage.begin(), one.coverage.end(), 255) % 9, 0) << "dots of 3 by 3";
  EXPECT_EQ(odd.coverage, dot_glyph(U'\x7', 1).coverage) << "a box";
}

}  // namespace
}  // namespace mq
