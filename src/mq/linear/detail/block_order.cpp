#include "mq/linear/detail/block_order.h"

#include <algorithm>
#include <span>
#include <utility>

#include "mq/base/inverse_lists.h"
#include "mq/base/parallel.h"

namespace mq {

namespace {

constexpr int blocks_at_once = 64;

/// Of every block those that write what it reads, each once.
std::vector<std::vector<int>> writers_around(const SparseMatrix& A, const std::vector<int>& begins,
                                             const std::vector<int>& starts, const std::vector<int>& unknowns) {
  const int count = int(begins.size()) - 1;
  const auto written_by = [&](std::int64_t b) {
    return std::span(unknowns).subspan(starts[begins[b]], starts[begins[b + 1]] - starts[begins[b]]);
  };
  const InverseLists<int> writers = inverse_lists<int>(count, A.rows(), [&](std::int64_t b, const auto& name) {
    for (const int u : written_by(b)) name(u, int(b));
  });
  std::vector<std::vector<int>> around(count);
  parallel_blocks(count, blocks_at_once, [&](std::int64_t begin, std::int64_t end) {
    std::vector<int> rows, asked_by(count, -1);
    for (std::int64_t b = begin; b < end; ++b) {
      rows.assign(written_by(b).begin(), written_by(b).end());
      std::ranges::sort(rows);
      rows.erase(std::unique(rows.begin(), rows.end()), rows.end());  // items of a block share most of theirs
      for (const int row : rows)
        for (SparseMatrix::InnerIterator entry(A, row); entry; ++entry)
          for (int w = writers.starts[entry.col()]; w < writers.starts[entry.col() + 1]; ++w)
            if (const int other = writers.items[w]; std::exchange(asked_by[other], int(b)) != b)
              around[b].push_back(other);
    }
  });
  return around;
}

}  // namespace

BlockOrder BlockOrder::part(const std::vector<int>& some) const {
  struct Block {
    int colour, number, begin, end;  ///< items `begin` … `end` − 1 of `some`
  };
  std::vector<Block> found;
  const auto number_of = [&](int item) {
    return int(std::upper_bound(begins.begin(), begins.end(), item) - begins.begin()) - 1;
  };
  for (int i = 0; i < int(some.size());) {
    const int number = number_of(some[i]);
    Block block{0, number, i, i};
    while (block.end < int(some.size()) && some[block.end] < begins[number + 1]) ++block.end;
    // Blocks of a colour come in increasing order.
    while (!std::binary_search(blocks.begin() + colours[block.colour],
                               blocks.begin() + colours[block.colour + 1], number))
      ++block.colour;
    found.push_back(block);
    i = block.end;
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Block& a, const Block& b) { return a.colour < b.colour; });
  BlockOrder order{{0}, {}, {0}, {}};
  for (const Block& block : found) {
    if (&block != &found.front() && block.colour != (&block - 1)->colour)
      order.colours.push_back(int(order.blocks.size()));
    order.blocks.push_back(int(order.blocks.size()));
    order.items.insert(order.items.end(), some.begin() + block.begin, some.begin() + block.end);
    order.begins.push_back(int(order.items.size()));
  }
  order.colours.push_back(int(order.blocks.size()));
  return order;
}

BlockOrder order_blocks(const SparseMatrix& A, const std::vector<int>& starts,
                        const std::vector<int>& unknowns, int block_size) {
  const int items = int(starts.size()) - 1;
  BlockOrder order;
  for (int i = 0; i < items; i += block_size) order.begins.push_back(i);
  order.begins.push_back(items);
  const int count = int(order.begins.size()) - 1;

  const std::vector<std::vector<int>> around = writers_around(A, order.begins, starts, unknowns);
  std::vector<int> colour(count, -1), taken;
  int colour_count = 0;
  for (int b = 0; b < count; ++b) {
    taken.assign(colour_count + 1, 0);
    for (const int other : around[b])
      if (colour[other] >= 0) taken[colour[other]] = 1;
    colour[b] = int(std::find(taken.begin(), taken.end(), 0) - taken.begin());
    colour_count = std::max(colour_count, colour[b] + 1);
  }

  order.colours.assign(1, 0);
  for (int c = 0; c < colour_count; ++c) {
    for (int b = 0; b < count; ++b)
      if (colour[b] == c) order.blocks.push_back(b);
    order.colours.push_back(int(order.blocks.size()));
  }
  return order;
}

}  // namespace mq
