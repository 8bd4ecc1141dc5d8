#include "mq/model/evolving_input.h"

#include <algorithm>

#include "mq/model/stored_frames.h"

namespace mq {

bool EvolvingInput::has_pictures() const {
  return std::ranges::any_of(pictures, [](const Image<float>& picture) { return !picture.values().empty(); });
}

EvolvingInput open_evolving(const std::filesystem::path& path, Messages& messages, const Progress& progress) {
  if (!names_moving_file(path)) {
    EvolvingInput input{EvolvingReader(path)};
    warn_of_broken(messages, input.reader);
    return input;
  }
  OpenAnimation opened = open_animation(path, progress);
  for (const std::string& note : opened.notes) messages.warning(path.string() + ": " + note);
  return {std::move(opened.reader), opened.frames_per_second, std::move(opened.pictures)};
}

}  // namespace mq
