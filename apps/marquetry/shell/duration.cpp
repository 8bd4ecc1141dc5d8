#include "shell/duration.h"

#include <fmt/format.h>

namespace mq::app {

std::string duration(double seconds) {
  if (seconds < 90) return fmt::format("{:.0f} s", seconds);
  if (seconds < 5400) return fmt::format("{:.0f} min", seconds / 60);
  return fmt::format("{:.1f} h", seconds / 3600);
}

std::optional<double> seconds_left(double fraction, double elapsed) {
  if (fraction < 0.02) return {};
  return elapsed * (1 - fraction) / fraction;
}

std::string estimate(double fraction, double elapsed) {
  const std::optional<double> left = seconds_left(fraction, elapsed);
  return !left || *left < 1 ? "" : fmt::format(", about {} left", duration(*left));
}

}  // namespace mq::app
