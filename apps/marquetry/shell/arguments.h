#pragma once
/// Texts that verbs take as arguments, and numbers as such texts.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "mq/base/length.h"
#include "mq/draw/samples.h"

namespace mq::app {

/// "3,4.5" as `count` finite numbers; nothing where it is not.
std::optional<std::vector<double>> parse_numbers(const std::string& text, std::size_t count);

/// A number as a user would type it, such as a default of the library's: 100, 0.02, 1e-4.
std::string as_typed(double value);
std::string as_typed(const Length& length);

/// "1024" or "1920x1080": pixels, 1 to 16384 a side.
std::optional<std::array<int, 2>> parse_size(std::string text);

/// gradient, transparent, white, black or #rrggbb.
std::optional<Backdrop> parse_backdrop(const std::string& text);

}  // namespace mq::app
