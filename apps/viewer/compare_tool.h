#pragma once
/// Other textures of the same sizes beside those that were opened.

#include <memory>

#include "session.h"
#include "tool.h"

namespace mq::view {

/// Throws `InvalidInput` where the model has no textures.
std::unique_ptr<Tool> make_compare_tool(Session& session);

}  // namespace mq::view
