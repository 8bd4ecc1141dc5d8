#pragma once
/// What the index of an MP4 (ISO/IEC 14496-12) says of its first video track. Nothing is decoded.

#include <cstdint>
#include <optional>
#include <string>

#include "mq/io/bytes.h"

namespace mq {

struct Mp4Video {
  std::string codec;  ///< four characters that name it: avc1, hvc1, av01, ...
  /// How many pictures are shown. Nothing where the index alone does not say: in fragments, or
  /// where an edit list shows a part.
  std::optional<std::int64_t> pictures;
  /// Pictures a second. Nothing where `pictures` is nothing, or they do not come evenly: one would
  /// be half of one off.
  std::optional<double> rate;
};

/// `name` is for messages. Throws `IoError` for bytes that are no MP4, have no video track, or are
/// cut short or damaged. Cost: the boxes and the table of times once.
Mp4Video mp4_video(ByteView bytes, const std::string& name);

}  // namespace mq
