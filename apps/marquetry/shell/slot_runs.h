#pragma once
/// A verb run for several slots of one model.

#include "shell/run.h"
#include "shell/verb.h"

namespace mq::app {

/// Whether the options ask for several slots: "all", or names between commas. Throws `InvalidInput` for
/// a verb that has no such runs, and where colours at vertices are asked for beside them.
bool asks_for_slots(const Verb& verb, const OptionValues& options);

/// Runs the verb for each of them, then writes one model, or the pictures of all. Returns its report:
/// that of the last, with the options of the whole and every slot's own report under "slots". Slots on the same
/// charts keep what was prepared for each other.
struct SlotsOutcome {
  Exit exit = Exit::done;
  Json report;
};
SlotsOutcome run_slots(const Verb& verb, const OptionValues& options, Terminal& terminal,
                       const Progress& progress, KeptWork& kept);

}  // namespace mq::app
