#include "mq/model/stored_frames.h"

#include <fmt/format.h>

#include <algorithm>

#include "mq/base/error.h"
#include "mq/io/file_names.h"

namespace mq {

namespace {

/// "0-2, 4, 6-9": the numbers of all frames; of many runs of them the first ones.
std::string numbers_in_words(const std::vector<StoredFrame>& frames) {
  constexpr int most_runs = 8;
  std::string text;
  int runs = 0;
  for (std::size_t f = 0; f < frames.size();) {
    std::size_t end = f + 1;
    while (end < frames.size() && frames[end].number == frames[end - 1].number + 1) ++end;
    if (++runs > most_runs) return text + fmt::format(", ... {}", frames.back().number);
    text += fmt::format("{}{}", text.empty() ? "" : ", ", frames[f].number);
    if (end > f + 1) text += fmt::format("-{}", frames[end - 1].number);
    f = end;
  }
  return text;
}

}  // namespace

std::vector<int> frames_with(const EvolvingReader& reader, const std::vector<int>& numbers,
                             const std::string& prefix) {
  const auto& stored = reader.frames();
  std::vector<int> frames;
  if (numbers.empty())
    for (int f = 0; f < int(stored.size()); ++f) frames.push_back(f);
  for (const int number : numbers) {
    const auto found = std::ranges::find(stored, number, &StoredFrame::number);
    require(found != stored.end(),
            fmt::format("{}{} has no frame {}; it has {}", prefix, reader.manifest().string(), number,
                        stored.empty() ? "none" : numbers_in_words(stored)));
    frames.push_back(int(found - stored.begin()));
  }
  require(!frames.empty(), reader.manifest().string() + ": it holds no frame");
  return frames;
}

std::vector<int> numbers_of(const EvolvingReader& reader, const std::vector<int>& frames) {
  std::vector<int> numbers;
  for (const int f : frames) {
    require(f >= 0 && f < std::ssize(reader.frames()),
            fmt::format("{}: frame {} of {} was asked for, counted from 0",
                        reader.manifest().string(), f, reader.frames().size()));
    numbers.push_back(reader.frames()[std::size_t(f)].number);
  }
  return numbers;
}

std::vector<FollowedFrame> followed_frames(const EvolvingReader& reader) {
  std::vector<FollowedFrame> frames;
  for (const StoredFrame& stored : reader.frames())
    frames.push_back(followed_frame(stored.number, stored.measured));
  return frames;
}

bool has_atlas(const EvolvingReader& reader) {
  return !reader.frames().empty() && !reader.segment(reader.frames().front().segment).uvs.empty();
}

double unit_in(const std::filesystem::path& file, const EvolvingReader& reader) {
  return names_gltf(file) ? reader.metres_per_unit() : 1;
}

void require_atlas(const EvolvingReader& reader) {
  require(has_atlas(reader), fmt::format("{}: it has no texture coordinates: unwrap it first",
                                         reader.manifest().string()));
}

void warn_of_broken(Messages& messages, const EvolvingReader& reader) {
  if (!reader.broken().empty()) messages.warning(reader.broken());
}

void warn_of_damage(Messages& messages, const EvolvingReader& reader,
                    const std::vector<int>& damaged) {
  if (damaged.empty()) return;
  std::string which;
  for (std::size_t i = 0; i < std::min<std::size_t>(damaged.size(), 5); ++i)
    which += fmt::format("{}{}", i == 0 ? "" : ", ", reader.frames()[damaged[i]].number);
  if (damaged.size() > 5) which += fmt::format(" and {} more", damaged.size() - 5);
  messages.warning(
      fmt::format("{}: bytes were changed after they were written, so it cannot give "
                  "frame {}; copy it again, or use other frames",
                  reader.blocks_file().string(), which));
}

}  // namespace mq
