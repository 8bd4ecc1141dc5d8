#pragma once
/// A verb run as its options say, for the program and for others that have its verbs.

#include "mq/base/options.h"
#include "shell/run.h"
#include "shell/terminal.h"
#include "shell/verb.h"

namespace mq::app {

struct VerbOutcome {
  Exit exit = Exit::done;
  Json report;
};

/// One run, one for each slot or one for each frame, by as many threads as --threads says. The report of a
/// sequence is that of its last frame with the options of the whole and every frame's own report under
/// "frames", and that of a part of it says which under "shard". The options were checked (`OptionValues::check`).
/// `kept` is what runs before it prepared, where somebody keeps it; slots and frames of one run keep it for each other
/// all the same. Throws what the verb throws.
VerbOutcome run_as_asked(const Verb& verb, const OptionValues& options, Terminal& terminal,
                         const Progress& progress, KeptWork* kept = nullptr);

}  // namespace mq::app
