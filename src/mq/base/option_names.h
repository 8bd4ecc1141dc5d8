#pragma once
/// What messages call an option, so that who reads one knows what to change.

#include <functional>
#include <string>
#include <string_view>

namespace mq {

/// The name of an option in messages, given as the field of the library's option struct that holds
/// it: "longest_edge" itself, or what the program says that its users know it by, such as
/// "--longest-edge". Where one choice is meant it follows: `option_name("weld") + " none"`.
std::string option_name(std::string_view field);

/// Says how the program names its options, for the whole process, as the locale is for a whole
/// process: no result depends on it. While the library is at work in another thread it may not be
/// called. Empty: as the library does.
void set_option_names(std::function<std::string(std::string_view field)> names);

}  // namespace mq
