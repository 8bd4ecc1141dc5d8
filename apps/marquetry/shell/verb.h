#pragma once
/// What a verb of the command line is. A file verbs/NAME.cpp defines `Verb NAME_verb()`, and
/// nothing else has to know of it.

#include <vector>

#include "mq/base/options.h"

namespace mq::app {

class Run;

/// The exit status of the program.
enum class Exit { done = 0, defects = 1, error = 2, cancelled = 130 };

struct Verb {
  OptionTable table;  ///< its own options; those every verb has are added by the frame
  Exit (*run)(Run&);  ///< does the work; throws what the library throws
};

/// All verbs of this program, in alphabetical order.
std::vector<Verb> all_verbs();

}  // namespace mq::app
