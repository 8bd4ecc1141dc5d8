#pragma once
/// Times in words.

#include <string>

namespace mq::app {

/// "3 s", "4 min", "2.1 h".
std::string duration(double seconds);

}  // namespace mq::app
