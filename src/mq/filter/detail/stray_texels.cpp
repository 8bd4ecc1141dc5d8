#include "mq/filter/detail/stray_texels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "mq/base/parallel.h"

namespace mq {

namespace {

/// In the range of values: how far those alone are from all around them, how near to an end noise sets them, and how far
/// those that go are from the median around them.
constexpr double alone = 0.2, at_end = 0.01, apart = 0.1;

/// Of all texels, of either kind, and how many at least.
constexpr double least_share = 3e-4;
constexpr int least_count = 16;

/// Of those alone, that are at their end.
constexpr double most_at_end = 0.75;

/// Of the variance of counts in windows, in that of chance.
constexpr double most_uneven = 3;

/// Of all texels, from where on those at an end are the picture itself.
constexpr double picture_of_dots = 0.9;

/// Texels together, at one end.
constexpr int largest_group = 3;

constexpr int rounds = 2;
constexpr int reach = 1 + largest_group;  ///< of looks, in texels: at a group of one beside, and at what is around that

/// The ends of a channel's values.
struct Ends {
  double least = 0, most = 0;

  double range() const { return most - least; }

  /// 1: at the upper, −1: at the lower, 0: at none.
  int of(double value) const {
    return value >= most - at_end * range() ? 1 : value <= least + at_end * range() ? -1 : 0;
  }
};

/// A channel in a window.
struct WindowChannel {
  const ChartWindow& window;
  const Signal& psi;
  Ends ends;
  int channel;

  bool has(int at) const { return window.unknowns[std::size_t(at)] >= 0; }
  double value(int at) const { return psi(window.unknowns[std::size_t(at)], channel); }
  int end(int at) const { return has(at) ? ends.of(value(at)) : 0; }

  std::array<int, 8> around(int at) const {
    const int w = window.width;
    return {at - w - 1, at - w, at - w + 1, at - 1, at + 1, at + w - 1, at + w, at + w + 1};
  }

  /// Calls it with the place of each texel of the window's own.
  template <class Call>
  void for_own(const Call& call) const {
    for (int y = reach; y < window.height - reach; ++y)
      for (int x = reach; x < window.width - reach; ++x)
        if (window.own[std::size_t(y * window.width + x)] == 1) call(y * window.width + x);
  }
};

/// Of each sign, light first.
struct Found {
  std::array<int, 2> alone{}, alone_at_end{};
  int texels = 0, at_ends = 0;

  void add(const Found& other) {
    for (int k : {0, 1}) alone[k] += other.alone[k], alone_at_end[k] += other.alone_at_end[k];
    texels += other.texels;
    at_ends += other.at_ends;
  }

  int strays() const { return alone[0] + alone[1]; }
};

Found found_in(const WindowChannel& at) {
  Found found;
  at.for_own([&](int own) {
    ++found.texels;
    const int end = at.end(own);
    if (end != 0) ++found.at_ends;
    double least = at.ends.most, most = at.ends.least;
    for (const int other : at.around(own)) {
      if (!at.has(other)) return;
      least = std::min(least, at.value(other));
      most = std::max(most, at.value(other));
    }
    const double far = alone * at.ends.range();
    if (at.value(own) > most + far) ++found.alone[0], found.alone_at_end[0] += end == 1 ? 1 : 0;
    if (at.value(own) < least - far) ++found.alone[1], found.alone_at_end[1] += end == -1 ? 1 : 0;
  });
  return found;
}

/// Whether what stands alone is noise.
bool is_noise(const std::vector<Found>& windows) {
  Found all;
  for (const Found& window : windows) all.add(window);
  for (const int k : {0, 1})
    if (all.alone[k] < least_count || all.alone[k] < least_share * all.texels ||
        all.alone_at_end[k] < most_at_end * all.alone[k])
      return false;
  if (all.at_ends > picture_of_dots * all.texels) return false;
  double squares = 0, count = 0;
  for (const Found& window : windows) {
    if (window.texels == 0) continue;
    const double usual = double(all.strays()) * window.texels / all.texels;
    squares += (window.strays() - usual) * (window.strays() - usual) / usual;
    ++count;
  }
  return squares <= most_uneven * count;
}

/// Whether the texels at the end of this one that it hangs together with are few.
bool is_in_small_group(const WindowChannel& at, int own) {
  const int end = at.end(own);
  std::array<int, largest_group + 1> group{own};
  int size = 1;
  for (int next = 0; next < size; ++next)
    for (const int other : at.around(group[std::size_t(next)])) {
      if (at.end(other) != end || std::find(group.begin(), group.begin() + size, other) != group.begin() + size) continue;
      if (size == largest_group) return false;
      group[std::size_t(size++)] = other;
    }
  return true;
}

using Replaced = std::pair<int, double>;

/// What noise set, and what it becomes.
std::vector<Replaced> replaced_in(const WindowChannel& at) {
  std::vector<Replaced> replaced;
  at.for_own([&](int own) {
    const int end = at.end(own);
    if (end == 0 || !is_in_small_group(at, own)) return;
    std::array<double, 8> others{};
    int count = 0;
    for (const int other : at.around(own))
      if (at.has(other) && (at.end(other) == 0 || !is_in_small_group(at, other)))
        others[std::size_t(count++)] = at.value(other);
    if (count < 2) return;
    std::sort(others.begin(), others.begin() + count);
    const double median = (others[std::size_t(count / 2)] + others[std::size_t((count - 1) / 2)]) / 2;
    if (std::abs(at.value(own) - median) > apart * at.ends.range())
      replaced.emplace_back(at.window.unknowns[std::size_t(own)], median);
  });
  return replaced;
}

/// Of all windows.
template <class Of>
auto of_windows(const ChartWindows& windows, const Signal& psi, int channel, Ends ends, const Of& of) {
  std::vector<decltype(of(std::declval<WindowChannel>()))> all(std::size_t(windows.count()));
  parallel_for(
      windows.count(),
      [&](std::int64_t k) {
        const ChartWindow window = windows.window(int(k), reach);
        all[std::size_t(k)] = of(WindowChannel{window, psi, ends, channel});
      },
      1);
  return all;
}

}  // namespace

WithoutStrays without_stray_texels(const ChartWindows& windows, const Signal& psi) {
  WithoutStrays result;
  std::vector<char> changed(std::size_t(psi.rows()));
  for (int c = 0; c < int(psi.cols()) && psi.rows() > 0; ++c) {
    const Ends ends{psi.col(c).minCoeff(), psi.col(c).maxCoeff()};
    if (!(ends.range() > 0) || !is_noise(of_windows(windows, psi, c, ends, found_in))) continue;
    if (!result.signal) result.signal = psi;
    for (int round = 0; round < rounds; ++round)
      for (const std::vector<Replaced>& of_window : of_windows(windows, *result.signal, c, ends, replaced_in))
        for (const auto& [u, median] : of_window) (*result.signal)(u, c) = median, changed[std::size_t(u)] = 1;
  }
  result.count = int(std::ranges::count(changed, 1));
  return result;
}

}  // namespace mq
