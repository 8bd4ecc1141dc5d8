#include "mq/io/detail/coding_order.h"

#include <algorithm>

namespace mq {
namespace {

/// Where each row of a table begins, of rows that have so many entries.
std::vector<int> row_starts(const std::vector<int>& counts) {
  std::vector<int> first(counts.size() + 1);
  for (std::size_t row = 0; row < counts.size(); ++row) first[row + 1] = first[row] + counts[row];
  return first;
}

}  // namespace

CodingOrder::CodingOrder(const std::vector<Triangle>& triangles, int vertices, Parallelograms parallelograms) {
  std::vector<int> counts(std::size_t(vertices), 0);
  const auto each = [&](const auto& found) {
    for (const Triangle& t : triangles)
      for (int k = 0; k < 3; ++k)
        for (const int n : {t[std::size_t(k + 1) % 3], t[std::size_t(k + 2) % 3]})
          if (n >= 0 && n < t[std::size_t(k)]) found(t[std::size_t(k)], n);
  };
  each([&](int v, int) { ++counts[std::size_t(v)]; });
  first_neighbour_ = row_starts(counts);
  neighbours_.resize(std::size_t(first_neighbour_.back()));
  std::vector<int> next(first_neighbour_.begin(), first_neighbour_.end() - 1);
  each([&](int v, int n) { neighbours_[std::size_t(next[std::size_t(v)]++)] = n; });
  if (parallelograms == Parallelograms::found)
    find_parallelograms(triangles);
  else
    first_parallelogram_.assign(std::size_t(vertices) + 1, 0);
}

void CodingOrder::find_parallelograms(const std::vector<Triangle>& triangles) {
  const std::size_t vertices = first_neighbour_.size() - 1;
  // Of each edge, at its lower vertex: the higher one, and what lies across in one of its triangles.
  struct Side {
    int high, apex;
  };
  std::vector<int> counts(vertices, 0);
  const auto each = [&](const auto& found) {
    for (const Triangle& t : triangles)
      if (t[0] >= 0 && t[1] >= 0 && t[2] >= 0)
        for (std::size_t k = 0; k < 3; ++k) {
          const auto [low, high] = std::minmax(t[(k + 1) % 3], t[(k + 2) % 3]);
          if (low != high) found(low, Side{high, t[k]});
        }
  };
  each([&](int low, Side) { ++counts[std::size_t(low)]; });
  const std::vector<int> first = row_starts(counts);
  std::vector<Side> sides(std::size_t(first.back()));
  std::vector<int> next(first.begin(), first.end() - 1);
  each([&](int low, Side side) { sides[std::size_t(next[std::size_t(low)]++)] = side; });
  // Pairs of two triangles at an edge, the higher apex across from the lower; no more than two are paired, so that
  // there are no more than edges.
  std::vector<std::pair<int, std::array<int, 3>>> found;
  for (int low = 0; low < int(vertices); ++low) {
    const auto row = std::span(sides).subspan(std::size_t(first[std::size_t(low)]),
                                              std::size_t(counts[std::size_t(low)]));
    std::ranges::stable_sort(row, {}, &Side::high);
    for (std::size_t i = 0; i + 1 < row.size(); ++i) {
      if (row[i].high != row[i + 1].high) continue;
      const auto [c, v] = std::minmax(row[i].apex, row[i + 1].apex);
      if (v > row[i].high && v != c) found.push_back({v, {low, row[i].high, c}});
      ++i;
    }
  }
  counts.assign(vertices, 0);
  for (const auto& pair : found) ++counts[std::size_t(pair.first)];
  first_parallelogram_ = row_starts(counts);
  parallelograms_.resize(found.size());
  next.assign(first_parallelogram_.begin(), first_parallelogram_.end() - 1);
  for (const auto& [v, corners] : found) parallelograms_[std::size_t(next[std::size_t(v)]++)] = corners;
}

}  // namespace mq
