#include "shell/frame_numbers.h"

#include <fmt/format.h>

#include <charconv>

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

Option shard_option() {
  return {.name = "shard",
          .type = Option::Type::text,
          .accepts = [](const std::string& text) { return parse_shard(text).has_value(); },
          .wanted = "the number of the part and how many there are, such as 3/16",
          .metavar = "I/N"};
}

std::optional<Shard> parse_shard(const std::string& text) {
  const std::size_t slash = text.find('/');
  if (slash == std::string::npos) return {};
  const auto number = [](const char* begin, const char* end) {
    int value = 0;
    const auto [stopped, error] = std::from_chars(begin, end, value);
    return error == std::errc() && stopped == end ? value : 0;
  };
  const Shard shard{number(text.data(), text.data() + slash),
                    number(text.data() + slash + 1, text.data() + text.size())};
  if (shard.number < 1 || shard.number > shard.count) return {};
  return shard;
}

int first_of(const Shard& shard, int frames) {
  return int(std::int64_t(frames) * (shard.number - 1) / shard.count);
}

std::vector<int> frames_of(const Shard& shard, const std::vector<int>& frames) {
  const int count = int(frames.size());
  return {frames.begin() + first_of(shard, count), frames.begin() + first_of({shard.number + 1, shard.count}, count)};
}

void require_no_frame_place(const std::string& output) {
  require(
      !has_frame_place(output),
      fmt::format("--output: found '{}' with a place for a frame's number, but without --frames "
                  "there is none: give --frames, such as 0-24, or another name",
                  output));
}

}  // namespace mq::app
