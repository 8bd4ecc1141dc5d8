#pragma once
/// What a verb of the command line is. A file verbs/NAME.cpp defines `Verb NAME_verb()`, and
/// nothing else has to know of it.

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "mq/base/options.h"

namespace mq::app {

class Run;

/// The exit status of the program.
enum class Exit { done = 0, defects = 1, error = 2, cancelled = 130 };

/// What a verb does, and to which signals: "yes" or how; empty: not at all. A row of a table in
/// docs/.
struct Signals {
  std::string what;
  std::string with = {};  ///< options that ask for it
  std::string textures = "yes", vertices = "yes", pictures = "yes";
};

/// Fields of the library's option structs that a verb takes as options of other names, with these:
/// {{"bad_frames", "skip-bad"}}. Messages of the library call the others by their own names.
using OptionFields = std::map<std::string, std::string, std::less<>>;

/// What a verb does with several slots of a model.
enum class Slots {
  one,      ///< it takes one at a time
  several,  ///< it is run for each by itself, and one model is made of what it gives `Run::receiver`
  its_own   ///< it looks at the words itself
};

struct Verb {
  OptionTable table;  ///< its own options; those every verb has are added by the frame
  Exit (*run)(Run&);  ///< does the work; throws what the library throws
  std::vector<Signals> signals = {};

  OptionFields fields = {};
  Slots slots = Slots::one;
};

/// All verbs of this program, in alphabetical order.
std::vector<Verb> all_verbs();

/// The one of this name, with the options that every verb has. Throws `InvalidInput` with the nearest name
/// when there is none.
Verb find_verb(const std::vector<Verb>& verbs, const std::string& name);

/// From now on messages of the library say "--longest-edge" where this verb has that option.
void name_options_of(const Verb& verb);

}  // namespace mq::app
