#pragma once
/// The tools there are.

#include <memory>
#include <string>
#include <vector>

#include "session.h"
#include "tool.h"

namespace mq::view {

/// "none" first.
const std::vector<std::string>& tool_names();

/// Null for "none". Throws `InvalidInput` for other names, or where the model is not one for it.
std::unique_ptr<Tool> make_tool(const std::string& name, Session& session);

}  // namespace mq::view
