#pragma once
/// The files of the page that plays an evolving mesh, as they were when the program was built.

#include <optional>
#include <string_view>
#include <utility>
#include <vector>

namespace mq::app {

struct PlayerFiles {
  std::string_view page;
  std::vector<std::pair<std::string_view, std::string_view>> scripts;  ///< the page's name for each, and what it says
};

/// Nothing where three.js was not found when the program was built.
std::optional<PlayerFiles> player_files();

}  // namespace mq::app
