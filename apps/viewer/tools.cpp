#include "tools.h"

#include <fmt/format.h>

#include <algorithm>

#include "compare_tool.h"
#include "filter_tool.h"
#include "mq/base/error.h"
#include "mq/base/options.h"
#include "verb_tool.h"

namespace mq::view {

const std::vector<std::string>& tool_names() {
  static const std::vector<std::string> names = {
      "none",    "filter", "detail", "geodesic", "lic",   "shock",       "denoise", "stitch",
      "texture", "charts", "react",    "seams", "interpolate", "compare"};
  return names;
}

std::unique_ptr<Tool> make_tool(const std::string& name, Session& session) {
  if (name == "none") return nullptr;
  if (name == "filter" && can_be_painted(session)) return std::make_unique<FilterTool>(session, FilterTool::Begins::nowhere);
  if (name == "detail" && can_be_painted(session))
    return std::make_unique<FilterTool>(session, FilterTool::Begins::everywhere);
  if (name == "detail") return std::make_unique<VerbTool>("filter", session);  // which says why not
  if (name == "compare") return make_compare_tool(session);
  if (name == "geodesic") return make_geodesic_tool(session);
  if (name == "lic") return make_comb_tool(session);
  if (name == "shock") return make_shock_tool(session);
  if (name == "stitch" || name == "texture") return make_stitch_tool(name, session);
  if (name == "charts") return make_charts_tool(session);
  if (name == "interpolate") return make_interpolate_tool(session);
  if (std::ranges::count(tool_names(), name) > 0) return std::make_unique<VerbTool>(name, session);
  throw InvalidInput(
      fmt::format("there is no tool '{}'{}", name, did_you_mean(name, tool_names())));
}

}  // namespace mq::view
