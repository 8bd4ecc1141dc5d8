#include "verbs/shared/evolving_frames.h"

#include "mq/io/frame_files.h"
#include "shell/frame_numbers.h"

namespace mq::app {

void add_evolving_frames_option(OptionTable& table) {
  Option frames = frames_option();
  frames.help = "which frames, by their numbers; else all";
  table.add(frames);
}

std::vector<int> wanted_frames(const OptionValues& options, const EvolvingReader& reader) {
  return frames_with(
      reader, options.has("frames") ? parse_frames(options.text("frames")) : std::vector<int>(),
      "--frames: ");
}

}  // namespace mq::app
