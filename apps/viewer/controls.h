#pragma once
/// Sliders, boxes and lists for the rows of an option table: the same words, defaults and ranges as
/// on the command line.

#include <string>

#include "mq/base/options.h"

namespace mq::view {

/// Shows one option and takes over what a person does to it; true where that changed it. What
/// cannot be is not taken. `in_force` is the value that holds where the option has none; empty: it says
/// so.
bool edit(OptionValues& values, const std::string& name, const std::string& in_force = {});

}  // namespace mq::view
