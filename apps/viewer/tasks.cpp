#include "tasks.h"

#include <algorithm>
#include <map>

namespace mq::view {

std::string run_words(const std::string& tool) {
  const auto found = std::ranges::find(change_words, tool, &ChangeWords::tool);
  if (tool == "charts") return "even out the charts";
  return found != change_words.end() ? found->run : "begin";
}

std::string tool_words(const std::string& tool) {
  const auto found = std::ranges::find(change_words, tool, &ChangeWords::tool);
  return found != change_words.end() ? found->label : task_words[std::size_t(task_of(tool))].label;
}

Task task_of(const std::string& tool) {
  if (tool == "none") return Task::look;
  if (tool == "compare") return Task::compare;
  if (tool == "filter") return Task::paint;
  if (tool == "stitch" || tool == "texture" || tool == "charts") return Task::photographs;
  if (tool == "geodesic") return Task::measure;
  return Task::change;
}

const std::vector<std::string>& first_options(const std::string& tool) {
  static const std::map<std::string, std::vector<std::string>> options = {
      {"denoise", {"method", "length"}},
      {"seams", {"weight"}},
      {"shock", {"time", "smooth"}},
      {"lic", {"field", "length", "by", "over"}},
      {"react", {"preset", "scale", "time", "ink"}},
      {"interpolate", {"time"}},
      {"geodesic", {"isolines"}},
      {"stitch", {"length"}},
      {"charts", {"length", "exposure"}},
      {"texture", {"images", "blend", "exposure"}},
  };
  static const std::vector<std::string> none;
  const auto found = options.find(tool);
  return found != options.end() ? found->second : none;
}

std::string option_words(const std::string& tool, const std::string& option) {
  static const std::map<std::pair<std::string, std::string>, std::string> words = {
      {{"stitch", "partial"}, "photographs"},
      {{"stitch", "confidence"}, "how well they show"},
      {{"stitch", "labels"}, "saved choice"},
      {{"charts", "labels"}, "parts, as a picture"},
      {{"charts", "unseen"}, "colour of no part"},
      {{"texture", "cameras"}, "cameras' file"},
      {{"texture", "images"}, "their folder"},
      {{"texture", "labels"}, "saved choice"},
      {{"texture", "unseen"}, "where none shows"},
  };
  const auto found = words.find({tool, option});
  return found != words.end() ? found->second : "";
}

}  // namespace mq::view
