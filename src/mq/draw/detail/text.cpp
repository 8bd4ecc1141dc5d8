#include "mq/draw/detail/text.h"

#include <algorithm>
#include <vector>

#include "mq/base/error.h"
#include "mq/draw/detail/glyph.h"

namespace mq {
namespace {

/// Pixels above and below the line, times the scale.
constexpr int above = 7, below = 2;

constexpr char32_t damaged = 0xFFFD;

/// The characters of UTF-8; bytes that are none become U+FFFD, one for each.
std::vector<char32_t> characters_of(const std::string& text) {
  std::vector<char32_t> found;
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = [&](std::size_t k) -> unsigned {
      return i + k < text.size() ? static_cast<unsigned char>(text[i + k]) : 0;
    };
    // How many bytes follow the first says it; these begin with 10.
    const unsigned first = byte(0);
    const std::size_t more = first < 0xC0 ? 0 : first < 0xE0 ? 1 : first < 0xF0 ? 2 : 3;
    bool is_whole = first < 0x80 || (first >= 0xC0 && first < 0xF8);
    char32_t character = more == 0 ? first : first & (0x3FU >> more);
    for (std::size_t k = 1; k <= more; ++k) {
      is_whole = is_whole && (byte(k) & 0xC0U) == 0x80;
      character = character << 6U | (byte(k) & 0x3FU);
    }
    found.push_back(is_whole ? character : damaged);
    i += is_whole ? more + 1 : 1;
  }
  return found;
}

/// Draws a glyph whose pen is at (x, line).
void draw_glyph(Image<float>& image, int x, int line, const Glyph& glyph, const Colour& colour) {
  const int colours = colour_channels(image.channels());
  const int left = x + glyph.left, top = line - glyph.top;
  for (int row = std::max(top, 0); row < std::min(top + glyph.height, image.height()); ++row)
    for (int column = std::max(left, 0); column < std::min(left + glyph.width, image.width()); ++column) {
      const float share = float(glyph.coverage[std::size_t((row - top) * glyph.width + column - left)]) / 255;
      if (share == 0) continue;
      const auto pixel = image.pixel(column, row);
      for (int k = 0; k < int(pixel.size()); ++k) {
        const float ink = k >= colours  ? 1
                          : colours < 3 ? (colour[0] + colour[1] + colour[2]) / 3
                          : k < 3       ? colour[std::size_t(k)]
                                        : 0;
        float& value = pixel[std::size_t(k)];
        value = k >= colours ? std::max(value, share) : value + share * (ink - value);
      }
    }
}

}  // namespace

int text_width(const std::string& text, int scale) {
  int width = 0;
  for (const char32_t character : characters_of(text)) width += glyph(character, scale).advance;
  return width;
}

int text_height(int scale) { return (above + below) * scale; }

void draw_text(Image<float>& image, int x, int y, const std::string& text, const TextStyle& style) {
  require(style.scale >= 1, "the scale of a text is at least 1");
  const int width = text_width(text, style.scale);
  int pen = style.anchor == TextStyle::Anchor::left     ? x
            : style.anchor == TextStyle::Anchor::centre ? x - width / 2
                                                        : x - width;
  for (const char32_t character : characters_of(text)) {
    const Glyph& drawn = glyph(character, style.scale);
    draw_glyph(image, pen, y + above * style.scale, drawn, style.colour);
    pen += drawn.advance;
  }
}

}  // namespace mq
