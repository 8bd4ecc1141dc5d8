#include "mq/linear/detail/block_order.h"

#include <algorithm>
#include <utility>

namespace mq {

namespace {

/// Per unknown the blocks that write it, as compressed lists.
struct Writers {
  std::vector<int> starts;
  std::vector<int> blocks;

  Writers(std::int64_t rows, const std::vector<int>& begins, const std::vector<int>& starts_of_items,
          const std::vector<int>& unknowns)
      : starts(rows + 1, 0), blocks(unknowns.size()) {
    for (const int u : unknowns) ++starts[u + 1];
    for (std::int64_t i = 0; i < rows; ++i) starts[i + 1] += starts[i];
    std::vector<int> at(starts.begin(), starts.end() - 1);
    for (int b = 0; b + 1 < int(begins.size()); ++b)
      for (int i = starts_of_items[begins[b]]; i < starts_of_items[begins[b + 1]]; ++i)
        blocks[at[unknowns[i]]++] = b;
  }
};

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

  const Writers writers(A.rows(), order.begins, starts, unknowns);
  std::vector<int> colour(count, -1), taken;
  std::vector<int> seen(A.rows(), -1);  // the last block that asked for a column
  std::vector<int> read(A.rows(), -1);  // and that has the row: items of a block share most of theirs
  int colour_count = 0;
  for (int b = 0; b < count; ++b) {
    taken.assign(colour_count + 1, 0);
    for (int i = starts[order.begins[b]]; i < starts[order.begins[b + 1]]; ++i) {
      if (std::exchange(read[unknowns[i]], b) == b) continue;
      for (SparseMatrix::InnerIterator entry(A, unknowns[i]); entry; ++entry) {
        if (std::exchange(seen[entry.col()], b) == b) continue;
        for (int w = writers.starts[entry.col()]; w < writers.starts[entry.col() + 1]; ++w)
          if (const int c = colour[writers.blocks[w]]; c >= 0) taken[c] = 1;
      }
    }
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
