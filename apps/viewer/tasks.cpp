#include "tasks.h"

#include <algorithm>
#include <map>

namespace mq::view {

std::string run_words(const std::string& tool) {
  const auto found = std::ranges::find(change_words, tool, &ChangeWords::tool);
  return found != change_words.end() ? found->run : "begin";
}

Task task_of(const std::string& tool) {
  if (tool == "none") return Task::look;
  if (tool == "compare") return Task::compare;
  if (tool == "filter") return Task::paint;
  if (tool == "stitch" || tool == "texture") return Task::photographs;
  if (tool == "geodesic") return Task::measure;
  return Task::change;
}

const std::vector<std::string>& first_options(const std::string& verb) {
  static const std::map<std::string, std::vector<std::string>> options = {
      {"denoise", {"method", "length"}},
      {"seams", {"weight"}},
      {"shock", {"time", "smooth"}},
      {"lic", {"field", "length", "by", "over"}},
      {"react", {"preset", "scale", "time", "ink"}},
      {"interpolate", {"time"}},
      {"geodesic", {"isolines"}},
      {"stitch", {"partial", "length"}},
      {"texture", {"cameras", "images", "blend", "exposure"}},
  };
  static const std::vector<std::string> none;
  const auto found = options.find(verb);
  return found != options.end() ? found->second : none;
}

}  // namespace mq::view
