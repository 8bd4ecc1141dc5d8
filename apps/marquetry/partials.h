#pragma once
/// Photographs given as textures of their own: --partial and --confidence.

#include <vector>

#include "mq/filter/stitch.h"
#include "signal_target.h"

namespace mq::app {

/// Adds --partial and --confidence.
void add_partial_options(OptionTable& table);

/// Whether the options name any.
bool has_partials(const OptionValues& options);

/// The partial signals that the options name. Throws `InvalidInput` or `IoError` naming the file.
std::vector<Partial> read_partials(Run& run, const Scene& scene, const TextureTarget& target);

}  // namespace mq::app
