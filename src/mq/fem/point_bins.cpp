#include "mq/fem/point_bins.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "mq/base/error.h"

namespace mq {

/// 21 bits for each coordinate: cubes are never negative, see the constructor.
std::uint64_t PointBins::key_of(const Cube& cube) {
  constexpr std::uint64_t mask = (std::uint64_t(1) << 21) - 1;
  std::uint64_t key = 0;
  for (const int c : cube) key = key << 21 | (std::uint64_t(std::uint32_t(c)) & mask);
  return key;
}

double PointBins::distance(const Box& a, const Box& b) {
  double squared = 0;
  for (int i = 0; i < 3; ++i) {
    const double gap = std::max({0.0, double(a.low[i]) - b.high[i], double(b.low[i]) - a.high[i]});
    squared += gap * gap;
  }
  return std::sqrt(squared);
}

PointBins::PointBins(std::span<const std::array<float, 3>> points, double side) : side_(side) {
  require(side > 0 && std::isfinite(side),
          fmt::format("points are sorted into cubes with a side of {}; it must be positive", side));
  const int count = int(points.size());
  std::array<float, 3> low = {0, 0, 0}, high = {0, 0, 0};
  for (int k = 0; k < count; ++k)
    for (int i = 0; i < 3; ++i) {
      const float p = points[k][i];
      low[i] = k == 0 ? p : std::min(low[i], p);
      high[i] = k == 0 ? p : std::max(high[i], p);
    }
  // No more than 2^20 cubes along an axis, for the keys.
  for (int i = 0; i < 3; ++i) side_ = std::max(side_, (double(high[i]) - low[i]) / (1 << 20));

  bin_of_.resize(std::size_t(count));
  for (int k = 0; k < count; ++k) {
    const std::array<float, 3>& p = points[k];
    Cube cube;
    for (int i = 0; i < 3; ++i) cube[i] = int(std::floor((double(p[i]) - low[i]) / side_));
    const auto [at, is_new] = bin_at_.try_emplace(key_of(cube), int(cubes_.size()));
    if (is_new) {
      cubes_.push_back(cube);
      boxes_.push_back({p, p});
    }
    bin_of_[k] = at->second;
    Box& box = boxes_[at->second];
    for (int i = 0; i < 3; ++i) {
      box.low[i] = std::min(box.low[i], p[i]);
      box.high[i] = std::max(box.high[i], p[i]);
    }
  }
  starts_.assign(boxes_.size() + 1, 0);
  for (const int bin : bin_of_) ++starts_[bin + 1];
  for (std::size_t i = 0; i < boxes_.size(); ++i) starts_[i + 1] += starts_[i];
  std::vector<int> at(starts_.begin(), starts_.end() - 1);
  members_.resize(bin_of_.size());
  for (int k = 0; k < count; ++k) members_[at[bin_of_[k]]++] = k;
}

std::vector<int> PointBins::around_bin(int bin, double reach) const {
  const int away = int(std::min(std::ceil(reach / side_), double(bin_count())));
  std::vector<int> found;
  const auto take = [&](int other) {
    if (distance(boxes_[std::size_t(bin)], boxes_[std::size_t(other)]) <= reach) found.push_back(other);
  };
  const Cube& middle = cubes_[std::size_t(bin)];
  if (std::pow(2.0 * away + 1, 3) > bin_count()) {
    for (int other = 0; other < bin_count(); ++other) take(other);
    return found;
  }
  for (int x = -away; x <= away; ++x)
    for (int y = -away; y <= away; ++y)
      for (int z = -away; z <= away; ++z)
        if (const auto at = bin_at_.find(key_of({middle[0] + x, middle[1] + y, middle[2] + z}));
            at != bin_at_.end())
          take(at->second);
  return found;
}

std::vector<int> PointBins::around(std::span<const int> points, double reach) const {
  RowSet holding(bin_count()), near(bin_count());
  for (const int k : points) holding.add(bin_of(k));
  for (const int bin : holding.rows())
    for (const int other : around_bin(bin, reach)) near.add(other);
  return near.rows();
}

void PointBins::add(std::span<const int> bins, RowSet& to) const {
  for (const int bin : bins)
    for (const int k : points_of(bin)) to.add(k);
}

}  // namespace mq
