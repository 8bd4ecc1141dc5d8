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

/// ", about 12 s left"; empty where it is less than a second, or nobody knows.
std::string estimate(std::optional<double> left);

/// Of work of which someone may know better, once it is under way, how long the rest will take.
class TimeLeft {
 public:
  /// At this fraction and time it was foreseen that all the rest takes so many seconds.
  void foresee(double fraction, double elapsed, double seconds) { foreseen_ = {fraction, elapsed, seconds}; }

  /// `seconds_left`; of what was foreseen, the more by what was done since, the more of it was.
  std::optional<double> seconds(double fraction, double elapsed) const;

 private:
  struct Foreseen {
    double fraction, elapsed, seconds;
  };
  std::optional<Foreseen> foreseen_;
};

}  // namespace mq::app
