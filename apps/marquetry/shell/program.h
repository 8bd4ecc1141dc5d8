#pragma once
/// The frame around every verb, for the program and for those it starts.

#include <string>
#include <vector>

#include "shell/verb.h"

namespace mq::app {

/// Does what the words of a command line ask of these verbs and returns the exit status.
int run_program(const std::vector<Verb>& verbs, const std::vector<std::string>& words);

}  // namespace mq::app
