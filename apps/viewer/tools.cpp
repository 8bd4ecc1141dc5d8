#include "tools.h"

#include <fmt/format.h>

#include "filter_tool.h"
#include "mq/base/error.h"
#include "mq/base/options.h"

namespace mq::view {

const std::vector<std::string>& tool_names() {
  static const std::vector<std::string> names = {"none", "filter"};
  return names;
}

std::unique_ptr<Tool> make_tool(const std::string& name, Session& session) {
  if (name == "none") return nullptr;
  if (name == "filter") return std::make_unique<FilterTool>(session);
  throw InvalidInput(fmt::format("there is no tool '{}'{}", name, did_you_mean(name, tool_names())));
}

}  // namespace mq::view
