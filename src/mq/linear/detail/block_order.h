#pragma once
/// An order in which coupled local updates may run in parallel and still give the same bits.

#include <vector>

#include "mq/base/parallel.h"
#include "mq/linear/matrix.h"
#include "mq/linear/stencil_matrix.h"

namespace mq {

/// Items (rows, patches) in blocks of consecutive ones; blocks of one colour neither write the same
/// unknown nor read what another of them writes.
struct BlockOrder {
  std::vector<int> begins;   ///< block k has items begins[k] … begins[k + 1] − 1
  std::vector<int> blocks;   ///< blocks, colour after colour
  std::vector<int> colours;  ///< colour c has blocks[colours[c]] … blocks[colours[c + 1] − 1]
  std::vector<int> items;    ///< what is in the place of each item; empty: itself

  /// The order of some of the items, given in increasing order.
  BlockOrder part(const std::vector<int>& some) const;

  /// Calls update(begin, end) for every block, whose items (see there) it updates in order: colours
  /// one after another, blocks of a colour in parallel; or, backward, all of that and each block's
  /// items reversed.
  template <class Update>
  void run(Order order, const Update& update) const {
    const int count = int(colours.size()) - 1;
    for (int i = 0; i < count; ++i) {
      const int c = order == Order::forward ? i : count - 1 - i;
      const auto update_block = [&](std::int64_t b) {
        const int block = blocks[colours[c] + b];
        update(begins[block], begins[block + 1]);
      };
      // A single block needs no threads: to call them takes longer than the few updates of some rows.
      if (colours[c + 1] - colours[c] == 1)
        update_block(0);
      else
        parallel_for(colours[c + 1] - colours[c], update_block, 1);
    }
  }
};

/// Cuts items into blocks of at most `block_size` and colours them greedily, in order. Item i writes
/// unknowns[starts[i]] … unknowns[starts[i + 1] − 1] and reads their neighbours in A.
BlockOrder order_blocks(const SparseMatrix& A, const std::vector<int>& starts,
                        const std::vector<int>& unknowns, int block_size);

}  // namespace mq
