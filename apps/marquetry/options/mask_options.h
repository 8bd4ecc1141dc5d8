#pragma once
/// Where a verb works how strongly: --mask and --spot.

#include <optional>
#include <vector>

#include "options/signal_options.h"

namespace mq::app {

/// Adds --mask and --spot.
void add_mask_options(OptionTable& table, const std::string& group);

/// Refuses files of --mask that cannot be read, before any work. Throws `InvalidInput` or `IoError`.
void check_mask(Run& run, const TexturedModel& scene);

/// The mask that the options describe, one number from −1 to 1 per unknown of the target; nothing
/// where they describe none. Throws `InvalidInput` or `IoError` naming the file and the remedy.
std::optional<std::vector<double>> asked_mask(Run& run, const TexturedModel& scene, const ModelSignal& target,
                                              const Progress& progress);

}  // namespace mq::app
