#include "shell/frame_numbers.h"

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/io/frame_files.h"

namespace mq::app {

Option frames_option() {
  return {.name = "frames",
          .type = Option::Type::text,
          .accepts = [](const std::string& text) { return !parse_frames(text).empty(); },
          .wanted = "a number, a range such as 1-100, or 1-100x2 for every second; the smaller number first, at most a million",
          .metavar = "RANGE"};
}

void require_no_frame_place(const std::string& output) {
  require(
      !has_frame_place(output),
      fmt::format("--output: found '{}' with a place for a frame's number, but without --frames "
                  "there is none: give --frames, such as 0-24, or another name",
                  output));
}

}  // namespace mq::app
