#pragma once
/// A font of 5 × 9 dots (two below the line) that belongs to the program, for machines without fonts.

#include "mq/draw/detail/glyph.h"

namespace mq {

/// ASCII 32 to 126; a box for all others.
Glyph dot_glyph(char32_t character, int scale);

}  // namespace mq
