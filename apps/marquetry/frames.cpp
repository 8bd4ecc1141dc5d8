#include "frames.h"

#include <fmt/format.h>

#include <regex>

namespace mq::app {
namespace {

const char* const place_pattern = "%(0?)([1-9]?)d";

}  // namespace

std::vector<int> parse_frames(const std::string& text) {
  std::smatch part;
  static const std::regex pattern("([0-9]{1,7})(?:-([0-9]{1,7})(?:x([1-9][0-9]{0,5}))?)?");
  if (!std::regex_match(text, part, pattern)) return {};
  const int first = std::stoi(part[1]);
  const int last = part[2].matched ? std::stoi(part[2]) : first;
  const int step = part[3].matched ? std::stoi(part[3]) : 1;
  std::vector<int> frames;
  if ((last - first) / step >= 1'000'000) return {};
  for (int frame = first; frame <= last; frame += step) frames.push_back(frame);
  return frames;
}

bool has_frame_place(const std::string& name) {
  return std::regex_search(name, std::regex(place_pattern));
}

std::string frame_name(const std::string& name, int frame) {
  std::smatch place;
  if (!std::regex_search(name, place, std::regex(place_pattern))) return name;
  const int width = place[2].length() ? std::stoi(place[2]) : 1;
  const std::string number =
      place[1].length() ? fmt::format("{:0{}}", frame, width) : fmt::format("{:{}}", frame, width);
  return place.prefix().str() + number + place.suffix().str();
}

}  // namespace mq::app
