#pragma once
/// What shells need to complete verbs, options and their choices, made from the option tables.

#include <string>
#include <vector>

#include "shell/verb.h"

namespace mq::app {

/// The script for a shell: bash, zsh or fish. Throws `InvalidInput` on another name.
std::string completion_script(const std::string& shell, const std::vector<Verb>& verbs);

}  // namespace mq::app
