#pragma once
/// Parallel loops whose results do not depend on the number of threads: work is cut into blocks of a
/// fixed size, and reductions add the blocks' results in the order of the blocks.
///
/// How many threads run is the application's affair (`tbb::global_control`), never the library's.

#include <cstdint>
#include <vector>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace mq {

/// Calls body(begin, end) for consecutive blocks of at most `block` items that cover [0, count).
/// The blocks may run at the same time, in any order.
template <class Body>
void parallel_blocks(std::int64_t count, std::int64_t block, const Body& body) {
  const std::int64_t blocks = (count + block - 1) / block;
  tbb::parallel_for(tbb::blocked_range<std::int64_t>(0, blocks, 1), [&](const auto& range) {
    for (std::int64_t b = range.begin(); b != range.end(); ++b)
      body(b * block, b * block + block < count ? b * block + block : count);
  });
}

/// Calls body(i) for every i in [0, count), in parallel blocks of `block` items.
template <class Body>
void parallel_for(std::int64_t count, const Body& body, std::int64_t block = 1024) {
  parallel_blocks(count, block, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i != end; ++i) body(i);
  });
}

/// zero + body(block 0) + body(block 1) + ..., added in this order whatever the threads do.
/// body(begin, end) returns the T of one block.
template <class T, class Body>
T parallel_sum(std::int64_t count, T zero, const Body& body, std::int64_t block = 16384) {
  const std::int64_t blocks = (count + block - 1) / block;
  std::vector<T> parts(static_cast<std::size_t>(blocks), zero);
  parallel_blocks(count, block, [&](std::int64_t begin, std::int64_t end) {
    parts[static_cast<std::size_t>(begin / block)] = body(begin, end);
  });
  T sum = zero;
  for (const T& part : parts) sum = sum + part;
  return sum;
}

}  // namespace mq
