#include "mq/io/detail/animation_found.h"

#include <fmt/format.h>

#include <algorithm>
#include <climits>
#include <cmath>

namespace mq {
namespace {

constexpr double off_by = 0.01;        // of a step: still at a multiple of it
constexpr int finest_fraction = 1000;  // of a step

/// The number of each time, `first` and on by a step; empty where one is farther than `tolerance` from a whole one,
/// or two have one number.
std::vector<int> whole_numbers(const std::vector<double>& times, double step, double first, double tolerance) {
  std::vector<int> numbers;
  for (const double time : times) {
    const double place = first + (time - times.front()) / step;
    if (!(place > -0.5 && place < INT_MAX)) return {};
    const int number = int(std::lround(place));
    if (std::abs(place - number) > tolerance || (!numbers.empty() && number <= numbers.back())) return {};
    numbers.push_back(number);
  }
  return numbers;
}

/// By the largest fraction of the step that all are multiples of, or by the smallest, rounded.
void number_by_fraction(FoundAnimation& found, const FrameTimes& when) {
  for (int parts = 2; found.numbers.empty() && parts <= finest_fraction + 1; ++parts) {
    const bool rounds = parts > finest_fraction;
    const int count = std::min(parts, finest_fraction);
    found.numbers =
        whole_numbers(when.times, when.step / count, std::max(0.0, when.first * count), rounds ? 0.5 : off_by);
    if (found.numbers.empty()) continue;
    found.numbers_per_second = when.unit / when.step * count;
    found.add_remark(
        fmt::format("its frames are not at whole {}: they are numbered by 1/{} of one{}, and stay as "
                    "far apart in seconds as they are",
                    when.word, count, rounds ? ", rounded" : ""));
  }
}

}  // namespace

void FoundAnimation::add(std::vector<std::string>& all, const std::string& text) {
  if (std::ranges::count(all, text) == 0) all.push_back(text);
}

std::string unseen_frames(std::size_t count, std::size_t all, const std::string& word, double first, double last) {
  const std::string when = first == last
                               ? fmt::format("{} {:.6g}", word, first)
                               : fmt::format("the first at {} {:.6g}, the last at {:.6g}", word, first, last);
  return fmt::format("{} of {} frames show nothing, as all is invisible, and are left out ({})", count, all, when);
}

void set_frame_times(FoundAnimation& found, const FrameTimes& when) {
  const std::vector<double>& times = when.times;
  const double span = times.back() - times.front();
  const double mean = times.size() > 1 ? span / double(times.size() - 1) : when.step;
  found.frames_per_second = when.unit / mean;
  bool even = true;
  for (std::size_t i = 0; i < times.size(); ++i)
    even = even && std::abs(times[i] - times.front() - double(i) * mean) < off_by * mean;
  const double first = std::max(0.0, when.first);
  found.numbers = whole_numbers(times, when.step, first, off_by);
  found.numbers_per_second = when.unit / when.step;
  if (!found.numbers.empty() && when.first < 0)
    found.add_remark(fmt::format("its {} begin at {:.6g}: its frames are numbered from 0", when.word, when.first));
  if (found.numbers.empty() && !even) number_by_fraction(found, when);
  if (found.numbers.empty()) {
    for (std::size_t i = 0; i < times.size(); ++i) found.numbers.push_back(int(i));
    found.numbers_per_second = found.frames_per_second;
    if (even)
      found.add_remark(
          fmt::format("its frames are not at whole {}: they are numbered 0, 1, 2, ..., {:.6g} a second, "
                      "and stay as far apart in seconds as they are",
                      when.word, found.frames_per_second));
    else
      found.add_note(
          fmt::format("some of its {} are too close to each other to be told apart: frames are as far "
                      "apart as they are on average",
                      when.word));
  }
  if (!even)
    found.add_note(fmt::format("its frames are not equally far apart in time: {:.6g} a second are their mean",
                               found.frames_per_second));
}

}  // namespace mq
