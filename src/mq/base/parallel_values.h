#pragma once
/// Many values at once, by all threads: memory is touched first by the thread that fills it.

#include <algorithm>
#include <cstdint>

#include "mq/base/parallel.h"

namespace mq {

inline constexpr std::int64_t values_at_once = 1 << 17;

template <class T>
void parallel_fill(T* values, std::int64_t count, T value) {
  parallel_blocks(count, values_at_once,
                  [&](std::int64_t begin, std::int64_t end) { std::fill(values + begin, values + end, value); });
}

/// Whether `holds(begin, end)` of all blocks.
template <class Holds>
bool parallel_all(std::int64_t count, const Holds& holds) {
  return parallel_sum(count, 0, [&](std::int64_t begin, std::int64_t end) { return int(!holds(begin, end)); },
                      values_at_once) == 0;
}

}  // namespace mq
