#include "evolving_frames.h"

#include <fmt/format.h>

#include <algorithm>

#include "mq/base/error.h"
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
  const auto& stored = reader.frames();
  std::vector<int> frames;
  if (!options.has("frames"))
    for (int f = 0; f < int(stored.size()); ++f) frames.push_back(f);
  else
    for (const int number : parse_frames(options.text("frames"))) {
      const auto found = std::ranges::find(stored, number, &StoredFrame::number);
      require(found != stored.end(),
              fmt::format("--frames: {} has no frame {}", options.text("evolving"), number));
      frames.push_back(int(found - stored.begin()));
    }
  require(!frames.empty(), options.text("evolving") + ": it holds no frame");
  return frames;
}

std::vector<int> numbers_of(const EvolvingReader& reader, const std::vector<int>& frames) {
  std::vector<int> numbers;
  for (const int f : frames) numbers.push_back(reader.frames()[std::size_t(f)].number);
  return numbers;
}

bool has_atlas(const EvolvingReader& reader) {
  return !reader.frames().empty() && !reader.segment(reader.frames().front().segment).uvs.empty();
}

void require_atlas(const EvolvingReader& reader) {
  require(has_atlas(reader),
          fmt::format("{}: it has no texture coordinates: give it some with the verb unwrap",
                      reader.manifest().string()));
}

void warn_of_broken(Terminal& terminal, const EvolvingReader& reader) {
  if (!reader.broken().empty()) terminal.warning(reader.broken());
}

void warn_of_damage(Terminal& terminal, const EvolvingReader& reader,
                    const std::vector<int>& damaged) {
  if (damaged.empty()) return;
  std::string which;
  for (std::size_t i = 0; i < std::min<std::size_t>(damaged.size(), 5); ++i)
    which += fmt::format("{}{}", i == 0 ? "" : ", ", reader.frames()[damaged[i]].number);
  if (damaged.size() > 5) which += fmt::format(" and {} more", damaged.size() - 5);
  terminal.warning(
      fmt::format("{}: bytes were changed after they were written, so it cannot give "
                  "frame {}; copy it again, or use other frames",
                  reader.blocks_file().string(), which));
}

}  // namespace mq::app
