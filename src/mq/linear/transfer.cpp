#include "mq/linear/transfer.h"

#include <algorithm>
#include <utility>

#include "mq/base/inverse_lists.h"
#include "mq/base/parallel.h"

namespace mq {

namespace {

constexpr std::int64_t block = 1024;  // rows handed to a thread at once

/// Calls kernel(rows) for all of `count` rows, in parallel.
template <class Kernel>
void in_blocks(std::int64_t count, const int* rows, const Kernel& kernel) {
  parallel_blocks(count, block, [&](std::int64_t begin, std::int64_t end) {
    kernel(TransferRows{rows, begin, end});
  });
}

/// Calls kernel(rows) for the stretches of rows begin … end − 1 that are not moved, moved(row) for the
/// others.
template <class IsMoved, class Kernel, class Moved>
void around_moved(std::span<const int> rows, std::int64_t begin, std::int64_t end,
                  const IsMoved& is_moved, const Kernel& kernel, const Moved& moved) {
  while (begin < end) {
    std::int64_t stop = begin;
    while (stop < end && !is_moved(rows[stop])) ++stop;
    if (stop > begin) kernel(TransferRows{rows.data(), begin, stop});
    if (stop < end) moved(rows[stop]);
    begin = stop + 1;
  }
}

}  // namespace

SparseTransfer::SparseTransfer(std::vector<int> starts, std::vector<WeightedIndex> entries,
                               int coarse_rows)
    : starts_(std::move(starts)), entries_(std::move(entries)) {
  InverseLists<WeightedIndex> children = inverse_lists<WeightedIndex>(
      fine_rows(), coarse_rows,
      [&](std::int64_t fine, const auto& name) {
        for (int e = starts_[fine]; e < starts_[fine + 1]; ++e)
          name(entries_[e].index, WeightedIndex{int(fine), entries_[e].weight});
      },
      [](const WeightedIndex& a, const WeightedIndex& b) {
        return std::pair(a.index, a.weight) < std::pair(b.index, b.weight);
      });
  child_starts_ = std::move(children.starts);
  child_entries_ = std::move(children.items);
}

int SparseTransfer::parents(int fine, std::array<WeightedIndex, 4>& out) const {
  const int begin = starts_[fine], count = starts_[fine + 1] - begin;
  for (int i = 0; i < count; ++i) out[i] = entries_[begin + i];
  return count;
}

void SparseTransfer::children(int coarse, std::vector<WeightedIndex>& out) const {
  out.insert(out.end(), child_entries_.begin() + child_starts_[coarse],
             child_entries_.begin() + child_starts_[coarse + 1]);
}

void SparseTransfer::restrict_to(int lanes, const float* r, float* b) const {
  in_blocks(coarse_rows(), nullptr, [&](const TransferRows& rows) {
    transfer_kernels().sums(lanes, child_starts_.data(), child_entries_.data(), rows, r, b);
  });
}

void SparseTransfer::restrict_to(std::span<const int> rows, int lanes, const float* r,
                                 float* b) const {
  in_blocks(std::ssize(rows), rows.data(), [&](const TransferRows& some) {
    transfer_kernels().sums(lanes, child_starts_.data(), child_entries_.data(), some, r, b);
  });
}

void SparseTransfer::prolongate_add(int lanes, const float* y, float* x) const {
  in_blocks(fine_rows(), nullptr, [&](const TransferRows& rows) {
    transfer_kernels().add_sums(lanes, starts_.data(), entries_.data(), rows, y, x);
  });
}

void SparseTransfer::prolongate_add(std::span<const int> rows, int lanes, const float* y,
                                    float* x) const {
  in_blocks(std::ssize(rows), rows.data(), [&](const TransferRows& some) {
    transfer_kernels().add_sums(lanes, starts_.data(), entries_.data(), some, y, x);
  });
}

std::int64_t SparseTransfer::bytes() const {
  return std::int64_t(4 * (starts_.size() + child_starts_.size()) + 16 * entries_.size());
}

void GridTransfer::move(std::vector<Move> moves, int extra) {
  children_.reserve(children_.size() + std::size_t(extra));
  children_.resize(children_.size() + std::size_t(extra));
  std::array<WeightedIndex, 4> read;
  for (Move& m : moves) {
    const int count = parents(m.fine, read);
    const auto* from = std::ranges::find(read.data(), read.data() + count, m.from, &WeightedIndex::index);
    m.weight = from->weight;
    children_[m.from].flags[0] |= Children::some_moved;
    children_[m.to].flags[0] |= Children::some_moved;
  }
  for (const Move& m : moves) parents_[m.fine].moved = 1;
  const auto sorted = [&](int Move::* key) {
    std::ranges::stable_sort(moves, {}, key);
    return moves;
  };
  by_fine_ = sorted(&Move::fine);
  by_from_ = sorted(&Move::from);
  by_to_ = sorted(&Move::to);
}

int GridTransfer::parents(int fine, std::array<WeightedIndex, 4>& out) const {
  const Parents& p = parents_[fine];
  const float weight = (p.between_columns ? 0.5f : 1.0f) * (p.between_rows ? 0.5f : 1.0f);
  int count = 0;
  out[count++] = {int(p.upper), weight};
  if (p.between_columns) out[count++] = {int(p.upper) + 1, weight};
  if (p.between_rows) {
    out[count++] = {p.lower, weight};
    if (p.between_columns) out[count++] = {p.lower + 1, weight};
  }
  if (p.moved)
    for (const Move& move : std::ranges::equal_range(by_fine_, fine, {}, &Move::fine))
      for (int i = 0; i < count; ++i)
        if (out[i].index == move.from) out[i].index = move.to;
  return count;
}

void GridTransfer::children(int coarse, std::vector<WeightedIndex>& out) const {
  const Children& c = children_[coarse];
  const auto first = std::ptrdiff_t(out.size());
  for (int i = 0; i < 3; ++i) {
    const float weight = i == 1 ? 1.0f : 0.5f;
    if (c.flags[i] & 1) out.push_back({c.centre[i] - 1, 0.5f * weight});
    if (c.flags[i] & 2) out.push_back({c.centre[i], weight});
    if (c.flags[i] & 4) out.push_back({c.centre[i] + (c.flags[i] & 8 ? 1 : 0), 0.5f * weight});
  }
  if (!(c.flags[0] & Children::some_moved)) return;
  for (const Move& m : std::ranges::equal_range(by_from_, coarse, {}, &Move::from))
    out.erase(std::find_if(out.begin() + first, out.end(),
                           [&](const WeightedIndex& child) { return child.index == m.fine; }));
  for (const Move& m : std::ranges::equal_range(by_to_, coarse, {}, &Move::to))
    out.push_back({m.fine, m.weight});
}

void GridTransfer::restrict_to(int lanes, const float* r, float* b) const {
  in_blocks(coarse_rows(), nullptr, [&](const TransferRows& rows) {
    transfer_kernels().restrict_grid(lanes, children_.data(), rows, r, b);
  });
  for (const Move& m : by_fine_) {
    const float* of = r + std::int64_t(m.fine) * lanes;
    float *from = b + std::int64_t(m.from) * lanes, *to = b + std::int64_t(m.to) * lanes;
    for (int lane = 0; lane < lanes; ++lane) {
      const float moved = m.weight * of[lane];
      from[lane] -= moved;
      to[lane] += moved;
    }
  }
}

void GridTransfer::restrict_to(std::span<const int> rows, int lanes, const float* r,
                               float* b) const {
  const auto sum_of_moved = [&](int coarse) {
    std::vector<WeightedIndex> of;
    children(coarse, of);
    for (int lane = 0; lane < lanes; ++lane) {
      float sum = 0;
      for (const WeightedIndex& child : of)
        sum += child.weight * r[std::int64_t(child.index) * lanes + lane];
      b[std::int64_t(coarse) * lanes + lane] = sum;
    }
  };
  parallel_blocks(std::ssize(rows), block, [&](std::int64_t begin, std::int64_t end) {
    around_moved(
        rows, begin, end,
        [&](int coarse) { return (children_[coarse].flags[0] & Children::some_moved) != 0; },
        [&](const TransferRows& some) {
          transfer_kernels().restrict_grid(lanes, children_.data(), some, r, b);
        },
        sum_of_moved);
  });
}

void GridTransfer::prolongate_add(int lanes, const float* y, float* x) const {
  in_blocks(fine_rows(), nullptr, [&](const TransferRows& rows) {
    transfer_kernels().prolongate_grid(lanes, parents_.data(), rows, y, x);
  });
  for (const Move& m : by_fine_) {
    float* at = x + std::int64_t(m.fine) * lanes;
    const float *from = y + std::int64_t(m.from) * lanes, *to = y + std::int64_t(m.to) * lanes;
    for (int lane = 0; lane < lanes; ++lane) at[lane] += m.weight * (to[lane] - from[lane]);
  }
}

void GridTransfer::prolongate_add(std::span<const int> rows, int lanes, const float* y,
                                  float* x) const {
  const auto add_moved = [&](int fine) {
    std::array<WeightedIndex, 4> of;
    const int count = parents(fine, of);
    for (int lane = 0; lane < lanes; ++lane) {
      float sum = x[std::int64_t(fine) * lanes + lane];
      for (int i = 0; i < count; ++i)
        sum += of[i].weight * y[std::int64_t(of[i].index) * lanes + lane];
      x[std::int64_t(fine) * lanes + lane] = sum;
    }
  };
  parallel_blocks(std::ssize(rows), block, [&](std::int64_t begin, std::int64_t end) {
    around_moved(
        rows, begin, end, [&](int fine) { return parents_[fine].moved != 0; },
        [&](const TransferRows& some) {
          transfer_kernels().prolongate_grid(lanes, parents_.data(), some, y, x);
        },
        add_moved);
  });
}

std::int64_t GridTransfer::bytes() const {
  return std::int64_t(parents_.size() * sizeof(Parents) + children_.size() * sizeof(Children) +
                      3 * by_fine_.size() * sizeof(Move));
}

}  // namespace mq
