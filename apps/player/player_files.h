#pragma once
/// The files of the page that plays an evolving mesh, as they were when the program was built.

#include <optional>
#include <string_view>

namespace mq::app {

struct PlayerFiles {
  std::string_view page, player, three, orbit_controls;
};

/// Nothing where three.js was not found when the program was built.
std::optional<PlayerFiles> player_files();

}  // namespace mq::app
