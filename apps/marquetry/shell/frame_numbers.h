#pragma once
/// Numbers of frames: the option that says which, and their places in names of outputs.

#include <string>

#include "mq/base/options.h"

namespace mq::app {

/// --frames, which takes a number or a range (`parse_frames`); what it is for is up to the verb.
Option frames_option();

/// Without --frames: refuses an output with a place for a frame's number. Throws `InvalidInput`.
void require_no_frame_place(const std::string& output);

}  // namespace mq::app
