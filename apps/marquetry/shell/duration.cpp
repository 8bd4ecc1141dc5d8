#include "shell/duration.h"

#include <fmt/format.h>

#include <algorithm>

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

std::optional<double> TimeLeft::seconds(double fraction, double elapsed) const {
  if (!foreseen_ || foreseen_->fraction >= 1) return seconds_left(fraction, elapsed);
  const double rest = 1 - foreseen_->fraction, done = std::clamp((fraction - foreseen_->fraction) / rest, 0.0, 1.0);
  const double spent = std::max(0.0, elapsed - foreseen_->elapsed);
  // All the rest takes (1 − done) of what was foreseen and done of what it would by its pace, spent / done.
  const double all = (1 - done) * std::max(foreseen_->seconds, spent) + spent;
  return all * (1 - done);
}

std::string estimate(std::optional<double> left) {
  return !left || *left < 1 ? "" : fmt::format(", about {} left", duration(*left));
}

}  // namespace mq::app
