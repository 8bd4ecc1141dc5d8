#pragma once
/// Which frames of an evolving mesh are meant.

#include <vector>

#include "mq/base/options.h"
#include "mq/model/stored_frames.h"

namespace mq::app {

/// Adds --frames.
void add_evolving_frames_option(OptionTable& table);

/// Indices of the frames that --frames says, in that order, or of all. Throws `InvalidInput` where
/// there is none of them.
std::vector<int> wanted_frames(const OptionValues& options, const EvolvingReader& reader);

}  // namespace mq::app
