#pragma once
/// The words in which pages about an option table are written: help, manual pages, completions.

#include <string>

#include "mq/base/options.h"

namespace mq {

/// What help calls an option's value: "N", "FILE", "linear|log"; empty for a flag.
std::string value_name(const Option& option);

/// What its row says beside its words: " [in texels, from 0 to 100, default 1]", or nothing;
/// brief: what nobody can do without, unit and default.
std::string facts(const Option& option, HelpDetail detail = HelpDetail::complete);

}  // namespace mq
