#pragma once
/// A run as the words that a user would type for it.

#include <string>
#include <vector>

#include "mq/base/options.h"

namespace mq::app {

/// The words after "marquetry" that give these options: the verb, what was given of the named ones,
/// in the order of the table, then the positional ones.
std::vector<std::string> command_words(const OptionValues& options);

/// "marquetry" and these words in one line for a shell, quoted where they have to be.
std::string command_line(const OptionValues& options);

}  // namespace mq::app
