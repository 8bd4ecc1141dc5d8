#pragma once
/// Models that were opened in the window, the last one first, in a file of the person's own:
/// $XDG_STATE_HOME/marquetry/recent, or ~/.local/state/marquetry/recent.

#include <string>
#include <vector>

namespace mq::view {

/// At most eight, of files that are there still. None where the file cannot be read.
std::vector<std::string> recent_files();

/// Puts this one first. Throws `IoError` where the file cannot be written.
void remember(const std::string& file);

}  // namespace mq::view
