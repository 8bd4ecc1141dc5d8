#pragma once
/// Sliders, boxes and lists for the rows of an option table: the same words, defaults and ranges as
/// on the command line.

#include <string>

#include "mq/base/options.h"

namespace mq::view {

/// Shows one option and takes over what a person does to it; true where that changed it. What
/// cannot be is not taken.
bool edit(OptionValues& values, const std::string& name);

}  // namespace mq::view
