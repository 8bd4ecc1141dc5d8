#pragma once
/// Times in words.

#include <optional>
#include <string>

namespace mq::app {

/// "3 s", "4 min", "2.1 h".
std::string duration(double seconds);

/// Seconds left of work that took `elapsed` so far, if the rest goes as fast as what is done; nothing where that
/// means nothing.
std::optional<double> seconds_left(double fraction, double elapsed);

/// ", about 12 s left"; empty where it is less than a second, or means nothing.
std::string estimate(double fraction, double elapsed);

}  // namespace mq::app
