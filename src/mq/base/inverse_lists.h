#pragma once
/// Who names what, the other way round: for every target those that name it.

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <functional>
#include <vector>

#include "mq/base/parallel.h"

namespace mq {

/// Compressed lists: target t is named by items[starts[t]] … items[starts[t + 1] − 1], which are in order.
template <class Item>
struct InverseLists {
  std::vector<int> starts;
  std::vector<Item> items;
};

/// `names(source, name)` calls name(target, item) for all that one of the sources names, the same whenever it is asked;
/// sources are asked in parallel, twice. Items that come in another order must not be equal to `less`, so that lists are the
/// same for any number of threads.
template <class Item, class Names, class Less = std::less<>>
InverseLists<Item> inverse_lists(std::int64_t sources, std::int64_t targets, const Names& names,
                                 const Less& less = {}) {
  InverseLists<Item> lists;
  std::vector<int>& starts = lists.starts;
  starts.assign(std::size_t(targets) + 1, 0);
  const auto next = [](int& counter) { return std::atomic_ref(counter).fetch_add(1, std::memory_order_relaxed); };
  parallel_for(sources, [&](std::int64_t source) {
    names(source, [&](int target, const Item&) { next(starts[std::size_t(target) + 1]); });
  });
  for (std::int64_t t = 0; t < targets; ++t) starts[t + 1] += starts[t];
  std::vector<int> at(starts.begin(), starts.end() - 1);
  lists.items.resize(std::size_t(starts.back()));
  parallel_for(sources, [&](std::int64_t source) {
    names(source, [&](int target, const Item& item) { lists.items[std::size_t(next(at[target]))] = item; });
  });
  parallel_for(targets, [&](std::int64_t t) {
    std::sort(lists.items.begin() + starts[t], lists.items.begin() + starts[t + 1], less);
  });
  return lists;
}

}  // namespace mq
