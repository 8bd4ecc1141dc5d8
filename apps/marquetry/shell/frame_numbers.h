#pragma once
/// Numbers of frames: the option that says which, and their places in names of outputs.

#include <optional>
#include <string>
#include <vector>

#include "mq/base/options.h"

namespace mq::app {

/// --frames, which takes a number or a range (`parse_frames`); what it is for is up to the verb.
Option frames_option();

/// --shard, which takes what `parse_shard` does; what becomes of the part is up to the verb.
Option shard_option();

/// A part of a sequence, one for each machine.
struct Shard {
  int number = 1;  ///< from 1
  int count = 1;
};

/// What "3/16" says; none where it says nothing.
std::optional<Shard> parse_shard(const std::string& text);

/// Of so many frames those of a part, counted from 0: parts follow one another, and their lengths differ by one at most.
struct FrameRange {
  int first = 0, end = 0;
};
FrameRange range_of(const Shard& shard, int frames);

/// The same of --shard as it was typed. Throws `InvalidInput` where the part has none of the frames.
FrameRange asked_range(const OptionValues& options, int frames);

/// The frames of a part, in order.
std::vector<int> frames_of(const Shard& shard, const std::vector<int>& frames);

/// Without --frames: refuses an output with a place for a frame's number. Throws `InvalidInput`.
void require_no_frame_place(const std::string& output);

}  // namespace mq::app
