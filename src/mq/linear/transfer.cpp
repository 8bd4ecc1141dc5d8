#include "mq/linear/transfer.h"

#include <algorithm>

#include "mq/base/parallel.h"
#include "mq/linear/vector_lanes.h"

namespace mq {

namespace {

/// Calls body with the lane count as a compile-time constant.
template <class Body>
void with_lanes(int lanes, const Body& body) {
  if (lanes == 1)
    body.template operator()<1>();
  else
    body.template operator()<4>();
}

}  // namespace

SparseTransfer::SparseTransfer(std::vector<int> starts, std::vector<WeightedIndex> entries,
                               int coarse_rows)
    : starts_(std::move(starts)), child_starts_(coarse_rows + 1, 0), entries_(std::move(entries)),
      child_entries_(entries_.size()) {
  for (const WeightedIndex& e : entries_) ++child_starts_[e.index + 1];
  for (int i = 0; i < coarse_rows; ++i) child_starts_[i + 1] += child_starts_[i];
  std::vector<int> at(child_starts_.begin(), child_starts_.end() - 1);
  for (int i = 0; i < fine_rows(); ++i)
    for (int e = starts_[i]; e < starts_[i + 1]; ++e)
      child_entries_[at[entries_[e].index]++] = {i, entries_[e].weight};
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

template <int lanes>
void SparseTransfer::restrict_row(std::int64_t coarse, const float* r, float* b) const {
  Floats<lanes> sum{};
  for (int e = child_starts_[coarse]; e < child_starts_[coarse + 1]; ++e)
    sum += child_entries_[e].weight * load<lanes>(r + std::int64_t(child_entries_[e].index) * lanes);
  store<lanes>(b + coarse * lanes, sum);
}

template <int lanes>
void SparseTransfer::prolongate_row(std::int64_t fine, const float* y, float* x) const {
  Floats<lanes> sum = load<lanes>(x + fine * lanes);
  for (int e = starts_[fine]; e < starts_[fine + 1]; ++e)
    sum += entries_[e].weight * load<lanes>(y + std::int64_t(entries_[e].index) * lanes);
  store<lanes>(x + fine * lanes, sum);
}

void SparseTransfer::restrict_to(int lanes, const float* r, float* b) const {
  with_lanes(lanes, [&]<int L>() {
    parallel_for(coarse_rows(), [&](std::int64_t coarse) { restrict_row<L>(coarse, r, b); });
  });
}

void SparseTransfer::restrict_to(std::span<const int> rows, int lanes, const float* r,
                                 float* b) const {
  with_lanes(lanes, [&]<int L>() {
    parallel_for(std::ssize(rows), [&](std::int64_t i) { restrict_row<L>(rows[i], r, b); });
  });
}

void SparseTransfer::prolongate_add(int lanes, const float* y, float* x) const {
  with_lanes(lanes, [&]<int L>() {
    parallel_for(fine_rows(), [&](std::int64_t fine) { prolongate_row<L>(fine, y, x); });
  });
}

void SparseTransfer::prolongate_add(std::span<const int> rows, int lanes, const float* y,
                                    float* x) const {
  with_lanes(lanes, [&]<int L>() {
    parallel_for(std::ssize(rows), [&](std::int64_t i) { prolongate_row<L>(rows[i], y, x); });
  });
}

std::int64_t SparseTransfer::bytes() const {
  return std::int64_t(4 * (starts_.size() + child_starts_.size()) + 16 * entries_.size());
}

void GridTransfer::move(std::vector<Move> moves, int extra) {
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

/// As if nothing were moved.
template <int lanes>
void GridTransfer::restrict_row(std::int64_t coarse, const float* r, float* b) const {
  const Children& c = children_[coarse];
  Floats<lanes> rows[3] = {};
  for (int i = 0; i < 3; ++i) {
    const float* at = r + std::int64_t(c.centre[i]) * lanes;
    if (c.flags[i] & 1) rows[i] += 0.5f * load<lanes>(at - lanes);
    if (c.flags[i] & 2) rows[i] += load<lanes>(at);
    if (c.flags[i] & 4) rows[i] += 0.5f * load<lanes>(at + (c.flags[i] & 8 ? lanes : 0));
  }
  store<lanes>(b + coarse * lanes, rows[1] + 0.5f * (rows[0] + rows[2]));
}

/// As if nothing were moved.
template <int lanes>
void GridTransfer::prolongate_row(std::int64_t fine, const float* y, float* x) const {
  const Parents p = parents_[fine];
  const float* upper = y + std::int64_t(p.upper) * lanes;
  const float* lower = y + std::int64_t(p.lower) * lanes;
  Floats<lanes> sum = load<lanes>(upper);
  if (p.between_columns) sum = 0.5f * (sum + load<lanes>(upper + lanes));
  if (p.between_rows) {
    Floats<lanes> below = load<lanes>(lower);
    if (p.between_columns) below = 0.5f * (below + load<lanes>(lower + lanes));
    sum = 0.5f * (sum + below);
  }
  store<lanes>(x + fine * lanes, load<lanes>(x + fine * lanes) + sum);
}

void GridTransfer::restrict_to(int lanes, const float* r, float* b) const {
  with_lanes(lanes, [&]<int L>() {
    parallel_for(coarse_rows(), [&](std::int64_t coarse) { restrict_row<L>(coarse, r, b); });
    for (const Move& m : by_fine_) {
      const Floats<L> moved = m.weight * load<L>(r + std::int64_t(m.fine) * L);
      float *from = b + std::int64_t(m.from) * L, *to = b + std::int64_t(m.to) * L;
      store<L>(from, load<L>(from) - moved);
      store<L>(to, load<L>(to) + moved);
    }
  });
}

void GridTransfer::restrict_to(std::span<const int> rows, int lanes, const float* r,
                               float* b) const {
  with_lanes(lanes, [&]<int L>() {
    const auto sum_of_moved = [&](std::int64_t coarse) {
      std::vector<WeightedIndex> of;
      children(int(coarse), of);
      Floats<L> sum{};
      for (const WeightedIndex& child : of)
        sum += child.weight * load<L>(r + std::int64_t(child.index) * L);
      store<L>(b + coarse * L, sum);
    };
    parallel_for(std::ssize(rows), [&](std::int64_t i) {
      if (children_[rows[i]].flags[0] & Children::some_moved)
        sum_of_moved(rows[i]);
      else
        restrict_row<L>(rows[i], r, b);
    });
  });
}

void GridTransfer::prolongate_add(int lanes, const float* y, float* x) const {
  with_lanes(lanes, [&]<int L>() {
    parallel_for(fine_rows(), [&](std::int64_t fine) { prolongate_row<L>(fine, y, x); });
    for (const Move& m : by_fine_) {
      float* at = x + std::int64_t(m.fine) * L;
      const float *from = y + std::int64_t(m.from) * L, *to = y + std::int64_t(m.to) * L;
      store<L>(at, load<L>(at) + m.weight * (load<L>(to) - load<L>(from)));
    }
  });
}

void GridTransfer::prolongate_add(std::span<const int> rows, int lanes, const float* y,
                                  float* x) const {
  with_lanes(lanes, [&]<int L>() {
    const auto add_moved = [&](int fine) {
      std::array<WeightedIndex, 4> of;
      const int count = parents(fine, of);
      Floats<L> sum = load<L>(x + std::int64_t(fine) * L);
      for (int i = 0; i < count; ++i)
        sum += of[i].weight * load<L>(y + std::int64_t(of[i].index) * L);
      store<L>(x + std::int64_t(fine) * L, sum);
    };
    parallel_for(std::ssize(rows), [&](std::int64_t i) {
      if (parents_[rows[i]].moved)
        add_moved(rows[i]);
      else
        prolongate_row<L>(rows[i], y, x);
    });
  });
}

std::int64_t GridTransfer::bytes() const {
  return std::int64_t(parents_.size() * sizeof(Parents) + children_.size() * sizeof(Children) +
                      3 * by_fine_.size() * sizeof(Move));
}

}  // namespace mq
