#include "mq/linear/kernels/transfer_kernels.h"

#include "mq/linear/kernels/real_lanes.h"
#include "mq/linear/kernels/vector_lanes.h"

namespace mq::MARQUETRY_FORM {
namespace {

template <class Body>
inline void for_each(const TransferRows& rows, const Body& body) {
  for (std::int64_t i = rows.begin; i < rows.end; ++i) body(rows.rows ? rows.rows[i] : i);
}

enum class Start { zero, there };

template <int lanes, Start start, class Real>
inline void sums_of(const int* starts, const WeightedIndex* entries, const TransferRows& rows,
                    const Real* from, Real* to) {
  for_each(rows, [&](std::int64_t row) {
    typename RealLanes<Real, lanes>::Type sum{};
    if constexpr (start == Start::there) sum = row_of<lanes>(to, row);
    for (int e = starts[row]; e < starts[row + 1]; ++e)
      sum += Real(entries[e].weight) * row_of<lanes>(from, entries[e].index);
    set_row<lanes>(to, row, sum);
  });
}

template <Start start, class Real>
void sums(int lanes, const int* starts, const WeightedIndex* entries, const TransferRows& rows,
          const Real* from, Real* to) {
  for_lanes(lanes, [&](auto size) { sums_of<decltype(size)::lanes, start>(starts, entries, rows, from, to); });
}

template <int lanes>
inline void restrict_rows(const GridChildren* children, const TransferRows& rows, const float* r,
                          float* b) {
  for_each(rows, [&](std::int64_t coarse) {
    const GridChildren& c = children[coarse];
    Floats<lanes> lines[3] = {};
    for (int i = 0; i < 3; ++i) {
      const float* at = r + std::int64_t(c.centre[i]) * lanes;
      if (c.flags[i] & 1) lines[i] += 0.5f * load<lanes>(at - lanes);
      if (c.flags[i] & 2) lines[i] += load<lanes>(at);
      if (c.flags[i] & 4) lines[i] += 0.5f * load<lanes>(at + (c.flags[i] & 8 ? lanes : 0));
    }
    store<lanes>(b + coarse * lanes, lines[1] + 0.5f * (lines[0] + lines[2]));
  });
}

template <int lanes>
inline void prolongate_rows(const GridParents* parents, const TransferRows& rows, const float* y,
                            float* x) {
  for_each(rows, [&](std::int64_t fine) {
    const GridParents& p = parents[fine];
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
  });
}

void restrict_grid(int lanes, const GridChildren* children, const TransferRows& rows, const float* r,
                   float* b) {
  for_lanes(lanes, [&](auto size) { restrict_rows<decltype(size)::lanes>(children, rows, r, b); });
}

void prolongate_grid(int lanes, const GridParents* parents, const TransferRows& rows, const float* y,
                     float* x) {
  for_lanes(lanes, [&](auto size) { prolongate_rows<decltype(size)::lanes>(parents, rows, y, x); });
}

}  // namespace

const TransferKernels transfer_kernels = {
    sums<Start::zero, float>,   sums<Start::there, float>, sums<Start::zero, double>,
    sums<Start::there, double>, restrict_grid,             prolongate_grid};

}  // namespace mq::MARQUETRY_FORM
