#include "mq/views/agreement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "mq/views/detail/readings.h"

namespace mq {
namespace {

using ChannelLogarithms = std::array<double, 3>;

ChannelLogarithms channel_logarithms(const LightColour& light) {
  constexpr float black = 0.01F;
  ChannelLogarithms result{};
  for (std::size_t c = 0; c < 3; ++c) result[c] = std::log(std::max(light[c], black));
  return result;
}

/// The median of the views of a patch but one (−1: of all), per channel.
ChannelLogarithms median_without(std::span<const Observation> views, std::ptrdiff_t left_out) {
  ChannelLogarithms result{};
  std::vector<double> values;
  for (std::size_t c = 0; c < 3; ++c) {
    values.clear();
    for (std::ptrdiff_t k = 0; k < std::ssize(views); ++k)
      if (k != left_out) values.push_back(channel_logarithms(views[std::size_t(k)].colour)[c]);
    result[c] = median_of(values);
  }
  return result;
}

double mean_distance(const ChannelLogarithms& a, const ChannelLogarithms& b) {
  double sum = 0;
  for (std::size_t c = 0; c < 3; ++c) sum += std::abs(a[c] - b[c]) / 3;
  return sum;
}

}  // namespace

Agreement agreement(const Observations& observations) {
  constexpr std::size_t fewest = 3;
  constexpr std::uint64_t step = 2654435761;  // a prime: from one patch to one that has nothing to do with it
  std::vector<int> shown;
  for (int p = 0; p < observations.patches(); ++p)
    if (observations.of(p).size() >= fewest) shown.push_back(p);
  std::vector<double> here, elsewhere;
  for (std::size_t n = 0; n < shown.size(); ++n) {
    const std::span<const Observation> views = observations.of(shown[n]);
    const ChannelLogarithms other =
        median_without(observations.of(shown[(step * (n + 1) + n) % shown.size()]), -1);
    for (std::size_t k = 0; k < views.size(); ++k) {
      const ChannelLogarithms own = channel_logarithms(views[k].colour);
      here.push_back(mean_distance(own, median_without(views, std::ptrdiff_t(k))));
      elsewhere.push_back(mean_distance(own, other));
    }
  }
  if (here.empty()) return {};
  return {median_of(here), median_of(elsewhere), double(here.size()) / double(observations.all.size())};
}

}  // namespace mq
