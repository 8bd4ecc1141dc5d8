#pragma once
/// Views of a patch compared at the places of their prints, one by one.

#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "mq/views/detail/readings.h"
#include "mq/views/view_choice.h"

namespace mq {

/// The logarithm of a view's brightness, the mean over the patch.
inline double brightness_of(const Observation& o) {
  constexpr double floor = 0.02;  // differences between dark colours are noise
  return std::log(std::max(0.0, double(o.colour[0] + o.colour[1] + o.colour[2])) / 3 + floor);
}

/// Whether a view differs from `others` in its mean over the patch, but at the places that they show too by less than
/// half as much: it shows other places of the patch, or these better. Brightness alone tells it, and of places those
/// that two of the others show, or the only other.
inline bool shows_other_places(const Observation& one, std::span<const Observation* const> others) {
  std::vector<double> values;
  const auto from_median = [&](double value) { return std::abs(value - median_of(values)); };
  for (const Observation* other : others) values.push_back(brightness_of(*other));
  if (values.empty()) return false;
  const double of_means = from_median(brightness_of(one)), fewest = std::min<double>(2, double(others.size()));
  double sum = 0;
  int count = 0;
  for (int place = 0; place < Print::places; ++place) {
    const std::optional<float> own = one.print.at(place);
    if (!own) continue;
    values.clear();
    for (const Observation* other : others)
      if (const auto at = other->print.at(place)) values.push_back(*at + brightness_of(*other));
    if (double(values.size()) < fewest) continue;
    sum += from_median(*own + brightness_of(one)), ++count;
  }
  return count > 0 && 2 * sum < of_means * count;
}

}  // namespace mq
