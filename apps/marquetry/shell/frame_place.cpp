#include "shell/frame_place.h"

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/io/frame_files.h"

namespace mq::app {

void require_no_frame_place(const std::string& output) {
  require(
      !has_frame_place(output),
      fmt::format("--output: found '{}' with a place for a frame's number, but without --frames "
                  "there is none: give --frames, such as 0-24, or another name",
                  output));
}

}  // namespace mq::app
