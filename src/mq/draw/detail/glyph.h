#pragma once
/// A character as it is drawn.

#include <cstdint>
#include <vector>

namespace mq {

/// Sizes are in pixels, places from where the pen is, on the line.
struct Glyph {
  int left = 0, top = 0;  ///< of its first row: to the right, and upwards
  int width = 0, height = 0;
  int advance = 0;                     ///< of the pen
  std::vector<std::uint8_t> coverage = {};  ///< row by row, 255: wholly
};

/// Of the font in `font_file`, or of dots where there is none or it lacks the character. `scale` is a seventh of the
/// height of capitals. It stays where it is: any thread may ask.
const Glyph& glyph(char32_t character, int scale);

}  // namespace mq
