#pragma once
/// Metadata that OpenImageIO would not survive: it is looked at before, and left out where it is damaged.

#include <string>
#include <vector>

#include "mq/io/bytes.h"

namespace mq {

struct SoundPicture {
  Bytes changed;                      ///< the file without what was damaged; empty: nothing was
  std::vector<std::string> left_out;  ///< in words: "colour profile"
};

/// A file of that format (`picture_format`), whose frame has been looked at already (picture_check.h).
SoundPicture without_damaged_metadata(ByteView bytes, const std::string& file_format);

/// The chunks of a PNG that say what its colours are, as they lie in the file: cICP, iCCP, sRGB, gAMA and cHRM
/// [PNG, third edition, 11.3.2]. OpenImageIO keeps the profile alone, and gAMA without the cHRM beside it.
Bytes png_colour_chunks(ByteView png);

/// A PNG with these in place of its own, which must be whole; without an offset of 0 and texts of "oiio:", which
/// OpenImageIO adds. Empty: its own stay.
Bytes with_png_colour(ByteView png, ByteView chunks);

/// Whether the tags of an ICC profile lie in it, and are as long as what they are needs [ICC.1:2022, 7.3 and 10].
bool is_sound_profile(ByteView profile);

}  // namespace mq
