#pragma once
/// What is known of a vertex's surroundings when vertices are coded in their order.

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "mq/mesh/mesh.h"

namespace mq {

class CodingOrder {
 public:
  CodingOrder() = default;

  enum class Parallelograms { none, found };

  /// Corners of -1 are of no vertex. Parallelograms, which take most of the time, are of use for what is predicted in
  /// space alone.
  CodingOrder(const std::vector<Triangle>& triangles, int vertices,
              Parallelograms parallelograms = Parallelograms::found);

  int vertex_count() const { return int(first_neighbour_.size()) - 1; }

  /// Vertices before v in its triangles, once for each triangle.
  std::span<const int> neighbours(int v) const { return part(neighbours_, first_neighbour_, v); }

  /// Vertices a, b, c before v with triangles of v, a, b and of a, b, c: v may be at a + b - c.
  std::span<const std::array<int, 3>> parallelograms(int v) const {
    return part(parallelograms_, first_parallelogram_, v);
  }

 private:
  template <class Entry>
  static std::span<const Entry> part(const std::vector<Entry>& all, const std::vector<int>& first, int v) {
    return {all.data() + first[std::size_t(v)], all.data() + first[std::size_t(v) + 1]};
  }
  void find_parallelograms(const std::vector<Triangle>& triangles);

  std::vector<int> first_neighbour_ = {0}, neighbours_;
  std::vector<int> first_parallelogram_ = {0};
  std::vector<std::array<int, 3>> parallelograms_;
};

// Sums of what a damaged file says may leave 64 bits: they wrap, alike for writer and reader.
inline std::int64_t plus(std::int64_t a, std::int64_t b) { return std::int64_t(std::uint64_t(a) + std::uint64_t(b)); }
inline std::int64_t minus(std::int64_t a, std::int64_t b) { return std::int64_t(std::uint64_t(a) - std::uint64_t(b)); }
inline std::int64_t times(std::int64_t a, std::int64_t b) { return std::int64_t(std::uint64_t(a) * std::uint64_t(b)); }

/// The nearest whole number to a / b, b > 0.
inline std::int64_t nearest_ratio(std::int64_t a, std::int64_t b) {
  const std::int64_t sum = plus(a, b / 2), ratio = sum / b;
  return ratio * b > sum ? ratio - 1 : ratio;
}

/// The nearest whole number to a / (64 count), count > 0: a quotient of 64 and one of `count`, which is short division
/// nearly always.
inline std::int64_t nearest_64th(std::int64_t a, std::int64_t count) {
  const std::int64_t whole = plus(a, 32 * count) >> 6;
  if (count == 1) return whole;
  if (std::int64_t(std::int32_t(whole)) == whole && count <= 64) {
    const std::int32_t ratio = std::int32_t(whole) / std::int32_t(count);
    return ratio - std::int32_t(ratio * std::int32_t(count) > std::int32_t(whole));
  }
  const std::int64_t ratio = whole / count;
  return ratio * count > whole ? ratio - 1 : ratio;
}

/// What v's `dimension` values may be, from those before it: `values` has as many for each vertex. Between the mean of
/// its neighbours, for weight 0, and the mean of its parallelograms, for weight 64.
template <int dimension>
std::array<std::int64_t, dimension> predicted_in_space(const std::vector<std::int64_t>& values,
                                                       const CodingOrder& order, int v, std::int64_t weight) {
  std::array<std::int64_t, dimension> result{}, around{}, across{};
  const auto at = [&](int n, int k) { return values[std::size_t(n) * dimension + std::size_t(k)]; };
  const auto neighbours = order.neighbours(v);
  const auto parallelograms = order.parallelograms(v);
  if (neighbours.empty()) {
    if (v > 0)
      for (int k = 0; k < dimension; ++k) result[std::size_t(k)] = at(v - 1, k);
    return result;
  }
  for (const int n : neighbours)
    for (int k = 0; k < dimension; ++k) around[std::size_t(k)] = plus(around[std::size_t(k)], at(n, k));
  for (const auto& [a, b, c] : parallelograms)
    for (int k = 0; k < dimension; ++k)
      across[std::size_t(k)] = plus(across[std::size_t(k)], minus(plus(at(a, k), at(b, k)), at(c, k)));
  const std::int64_t near = std::ssize(neighbours), far = std::ssize(parallelograms);
  for (std::size_t k = 0; k < dimension; ++k)
    result[k] = far == 0 ? nearest_ratio(around[k], near)
                         : nearest_ratio(plus(times(around[k], times(minus(64, weight), far)),
                                              times(across[k], times(weight, near))),
                                         64 * near * far);
  return result;
}

/// What a prediction leaves, as it counts for those after it.
inline std::uint64_t bounded_left(std::int64_t left) {
  constexpr std::uint64_t most = 1 << 20;
  return std::min(std::uint64_t(left < 0 ? ~left : left), most);
}

/// Which of so many streams takes what is left of v's values: told by how much was `left` of its neighbours, or where
/// there is none of the vertex before.
inline int left_context(const CodingOrder& order, const std::vector<std::uint32_t>& left, int v, int contexts) {
  const auto neighbours = order.neighbours(v);
  std::uint64_t sum = 0;
  for (const int n : neighbours) sum += left[std::size_t(n)];
  if (!neighbours.empty())
    sum = 4 * sum / neighbours.size();
  else if (v > 0)
    sum = 4 * std::uint64_t(left[std::size_t(v) - 1]);
  return std::min(int(std::bit_width(sum)), contexts - 1);
}

}  // namespace mq
