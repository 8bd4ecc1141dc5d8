#include "mq/model/evolving_input.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "mq/base/error.h"
#include "mq/io/file_names.h"
#include "mq/io/path_status.h"
#include "mq/model/stored_frames.h"

namespace mq {

bool EvolvingInput::has_pictures() const {
  return std::ranges::any_of(pictures, [](const Image<float>& picture) { return !picture.values().empty(); });
}

const Image<float>& EvolvingInput::picture(int frame) const {
  return pictures.at(std::size_t(reader.frames().at(std::size_t(frame)).segment));
}

EvolvingInput open_evolving(const std::filesystem::path& path, Messages& messages, const Progress& progress) {
  require(!is_folder(path) && (names_moving_file(path) || !names_model(path)),
          fmt::format("{}: found no evolving mesh but {}; make one of frames with marquetry evolve",
                      path.string(), names_model(path) ? "a model" : "a folder"));
  if (!names_moving_file(path)) {
    EvolvingInput input{EvolvingReader(path)};
    warn_of_broken(messages, input.reader);
    return input;
  }
  OpenAnimation opened = open_animation(path, progress);
  for (const std::string& note : opened.notes) messages.warning(note_on(path.string(), note));
  for (const std::string& remark : opened.remarks) messages.remark(note_on(path.string(), remark));
  return {std::move(opened.reader), opened.frames_per_second, opened.numbers_per_second, std::move(opened.pictures),
          std::move(opened.files)};
}

}  // namespace mq
