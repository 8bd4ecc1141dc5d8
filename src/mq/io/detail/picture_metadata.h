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

/// Whether the tags of an ICC profile lie in it, and are as long as what they are needs [ICC.1:2022, 7.3 and 10].
bool is_sound_profile(ByteView profile);

}  // namespace mq
