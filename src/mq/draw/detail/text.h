#pragma once
/// Labels in pictures, in a font of 5 × 9 dots (two below the line) that belongs
/// to the program.

#include <string>

#include "mq/image/colour.h"
#include "mq/image/image.h"

namespace mq {

struct TextStyle {
  Colour colour = {0.12f, 0.12f, 0.14f};
  int scale = 2;                                                    ///< pixels per dot, at least 1
  enum class Anchor { left, centre, right } anchor = Anchor::left;  ///< what x is
};

/// Pixels a line of text takes: 6 · scale per character, less the last gap, by 9 · scale.
int text_width(const std::string& text, int scale);
int text_height(int scale);

/// Draws one line with its top at row y into a picture of one channel or more; alpha, the last of
/// two or four channels, becomes 1. What leaves the picture is cut off. Bytes outside ASCII 32 to
/// 126 are drawn as boxes, one per character of UTF-8.
void draw_text(Image<float>& image, int x, int y, const std::string& text,
               const TextStyle& style = {});

}  // namespace mq
