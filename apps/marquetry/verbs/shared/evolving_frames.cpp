#include "verbs/shared/evolving_frames.h"

#include "mq/io/frame_files.h"

namespace mq::app {

void add_evolving_frames_option(OptionTable& table) {
  table.add({.name = "frames",
             .type = Option::Type::text,
             .accepts = [](const std::string& text) { return !parse_frames(text).empty(); },
             .wanted = "a number, a range such as 1-100, or 1-100x2 for every second",
             .metavar = "RANGE",
             .help = "which frames, by their numbers; else all"});
}

std::vector<int> wanted_frames(const OptionValues& options, const EvolvingReader& reader) {
  return frames_with(
      reader, options.has("frames") ? parse_frames(options.text("frames")) : std::vector<int>(),
      "--frames: ");
}

}  // namespace mq::app
