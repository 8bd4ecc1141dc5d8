#pragma once
/// Unknowns in the order of a value, found fast. Used inside this room.

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "mq/base/infinity.h"
#include "mq/base/parallel.h"
#include "mq/linear/matrix.h"

namespace mq {

/// Places of unknowns in the order of falling values, by a counting sort that tells apart what
/// differs by a 65536th of the range; equal places go by number.
class FallingOrder {
 public:
  struct Range {
    double high = -infinity, low = infinity;
  };

  static Range range(const std::vector<int>& unknowns, const Vector& values) {
    Range all;
    for (const int i : unknowns) {
      all.high = std::max(all.high, values[i]);
      all.low = std::min(all.low, values[i]);
    }
    return all;
  }

  /// Of the unknowns `met`, ascending, whose values must be finite.
  void sort(const std::vector<int>& met, const Vector& values) { sort(met, {}, values, range(met, values)); }

  /// Where all values lie in a range. `beside` are not put in order, but it is known what they come before.
  void sort(const std::vector<int>& met, const std::vector<int>& beside, const Vector& values, const Range& range) {
    const auto [high, low] = range;
    const double scale = high > low ? (places - 1) / (high - low) : 0;
    place_.resize(std::size_t(values.size()));
    const auto place = [&, high = high](int i) { place_[i] = std::uint16_t((high - values[i]) * scale); };
    parallel_for(std::ssize(met), [&](std::int64_t k) { place(met[k]); });
    for (const int i : beside) place(i);
    std::vector<int> next(places + 1, 0);
    for (const int i : met) ++next[place_[i] + 1];
    for (int p = 0; p < places; ++p) next[p + 1] += next[p];
    order_.resize(met.size());
    for (const int i : met) order_[next[place_[i]]++] = i;
  }

  bool before(int i, int j) const { return place_[i] != place_[j] ? place_[i] < place_[j] : i < j; }
  const std::vector<int>& order() const { return order_; }

 private:
  static constexpr int places = 1 << 16;
  std::vector<std::uint16_t> place_;
  std::vector<int> order_;
};

/// Unknowns step by step along couplings from the fixed ones.
std::vector<int> by_steps(const SparseMatrix& A, const std::vector<std::pair<int, double>>& fixed);

}  // namespace mq
