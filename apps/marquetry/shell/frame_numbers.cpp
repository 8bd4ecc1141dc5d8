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

FrameRange range_of(const Shard& shard, int frames) {
  const auto begin = [&](int parts) { return int(std::int64_t(frames) * parts / shard.count); };
  return {begin(shard.number - 1), begin(shard.number)};
}

FrameRange asked_range(const OptionValues& options, int frames) {
  const std::string text = options.text("shard");
  const FrameRange range = range_of(*parse_shard(text), frames);
  require(range.first < range.end,
          fmt::format("--shard: found {}, wanted no more parts than there are frames, {}", text, frames));
  return range;
}

std::vector<int> frames_of(const Shard& shard, const std::vector<int>& frames) {
  const FrameRange range = range_of(shard, int(frames.size()));
  return {frames.begin() + range.first, frames.begin() + range.end};
}

void require_no_frame_place(const std::string& output) {
  require(
      !has_frame_place(output),
      fmt::format("--output: found '{}' with a place for a frame's number, but without --frames "
                  "there is none: give --frames, such as 0-24, or another name",
                  output));
}

}  // namespace mq::app
