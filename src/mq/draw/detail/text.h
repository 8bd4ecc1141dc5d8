#pragma once
/// Labels in pictures, in the font that the machine has (font_file.h).

#include <string>

#include "mq/image/colour.h"
#include "mq/image/image.h"

namespace mq {

struct TextStyle {
  Colour colour = {0.12f, 0.12f, 0.14f};
  int scale = 2;  ///< a seventh of the height of capitals, pixels, at least 1
  enum class Anchor { left, centre, right } anchor = Anchor::left;  ///< what x is
};

/// Pixels that a line of text takes: 9 · scale high, two of nine below the line.
int text_width(const std::string& text, int scale);
int text_height(int scale);

/// Draws one line of UTF-8 with its top at row y into a picture of one channel or more; alpha, the last of two or four
/// channels, becomes 1. What leaves the picture is cut off.
void draw_text(Image<float>& image, int x, int y, const std::string& text,
               const TextStyle& style = {});

}  // namespace mq
