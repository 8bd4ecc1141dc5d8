#pragma once
/// Manual pages in the language of man(7), made from the option tables.

#include <string>
#include <vector>

#include "shell/verb.h"

namespace mq::app {

/// marquetry.1: what the program is, its verbs, its exit status and its environment.
std::string manual_page(const std::vector<Verb>& verbs);

/// marquetry-VERB.1: a verb and all of its options, those of every verb included.
std::string manual_page(const OptionTable& table);

}  // namespace mq::app
