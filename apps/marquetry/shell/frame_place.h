#pragma once
/// Places for a frame's number in names of outputs.

#include <string>

namespace mq::app {

/// Without --frames: refuses an output with a place for a frame's number. Throws `InvalidInput`.
void require_no_frame_place(const std::string& output);

}  // namespace mq::app
