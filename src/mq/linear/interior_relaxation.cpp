/// In row k, with the neighbours numbered as one reads,
///
///     x_4 ← (b − Σ_{j≠4} a_j x_j) / a_4.
///
/// Temporal blocking (thesis 5.8.5): a row needs the row above after the same sweep, and the row below
/// after the sweep before. Walking r + s = 0, 1, 2, ... over rows r and sweeps s, and at each the sweeps
/// in turn, keeps to that: every number is what plain sweeps make of it, while a row is used for all
/// sweeps within a few rows.

#include "mq/linear/interior_relaxation.h"

#include <fmt/format.h>

#include "mq/base/parallel.h"
#include "mq/linear/real_lanes.h"
#include "mq/linear/solver.h"

namespace mq {

namespace {

/// The nine values of a row, then 1/a_4.
constexpr int stride = 10;

/// b − (what the rows above and below and the right neighbour take of it).
template <int lanes, class Real>
inline auto without_left(const Real* a, const Real* b, const Real* x, int k, int u, int d) {
  auto sum = row_of<lanes>(b, k);
  sum -= a[0] * row_of<lanes>(x, u - 1);
  sum -= a[1] * row_of<lanes>(x, u);
  sum -= a[2] * row_of<lanes>(x, u + 1);
  sum -= a[6] * row_of<lanes>(x, d - 1);
  sum -= a[7] * row_of<lanes>(x, d);
  sum -= a[8] * row_of<lanes>(x, d + 1);
  sum -= a[5] * row_of<lanes>(x, k + 1);
  return sum;
}

/// The left neighbour, just relaxed, comes in last: all else is ready before it is.
template <int lanes, class Real>
inline void relax_segment(const Real* a, const StencilRun& s, const Real* b, Real* x) {
  auto left = row_of<lanes>(x, s.first - 1);
  for (int i = 0; i < s.count; ++i, a += stride) {
    const auto rest = without_left<lanes>(a, b, x, s.first + i, s.up + i, s.down + i) * a[9];
    left = rest - (a[3] * a[9]) * left;
    set_row<lanes>(x, s.first + i, left);
  }
}

template <int lanes, class Real>
inline void residual_of_segment(const Real* a, const StencilRun& s, const Real* b, const Real* x,
                                Real* r) {
  for (int i = 0; i < s.count; ++i, a += stride) {
    const int k = s.first + i;
    auto sum = without_left<lanes>(a, b, x, k, s.up + i, s.down + i);
    sum -= a[3] * row_of<lanes>(x, k - 1);
    sum -= a[4] * row_of<lanes>(x, k);
    set_row<lanes>(r, k, sum);
  }
}

}  // namespace

template <class Real>
InteriorRelaxation<Real>::InteriorRelaxation(StencilBlocks blocks) : blocks_(std::move(blocks)) {
  starts_.reserve(blocks_.segments.size() + 1);
  starts_.push_back(0);
  for (const StencilRun& s : blocks_.segments)
    starts_.push_back(starts_.back() + std::int64_t(stride) * s.count);
  coefficients_.resize(starts_.back());
}

template <class Real>
void InteriorRelaxation<Real>::set_values(const SparseMatrix& A) {
  parallel_for(
      std::int64_t(blocks_.segments.size()),
      [&](std::int64_t i) {
        const StencilRun& s = blocks_.segments[i];
        Real* a = coefficients_.data() + starts_[i];
        for (int k = s.first; k < s.first + s.count; ++k, a += stride) {
          const double* row = A.valuePtr() + A.outerIndexPtr()[k];
          if (!(row[4] > 0))
            throw NotPositiveDefinite(fmt::format(
                "the matrix is not positive definite: its diagonal is {} in row {}", row[4], k));
          for (int j = 0; j < 9; ++j) a[j] = Real(row[j]);
          a[9] = Real(1 / row[4]);
        }
      },
      64);
}

template <class Real>
template <int lanes>
void InteriorRelaxation<Real>::relax_row(int row, const Real* b, Real* x) const {
  for (int s = blocks_.rows[row]; s < blocks_.rows[row + 1]; ++s)
    relax_segment<lanes>(coefficients_.data() + starts_[s], blocks_.segments[s], b, x);
}

template <class Real>
template <int lanes>
void InteriorRelaxation<Real>::relax_block(int block, const Real* b, Real* x, int sweeps,
                                           SweepOrder order) const {
  const int begin = blocks_.blocks[block], end = blocks_.blocks[block + 1];
  if (order == SweepOrder::plain) {
    for (int sweep = 0; sweep < sweeps; ++sweep)
      for (int row = begin; row < end; ++row) relax_row<lanes>(row, b, x);
    return;
  }
  for (int front = begin; front < end + sweeps - 1; ++front)
    for (int sweep = 0; sweep < sweeps; ++sweep)
      if (const int row = front - sweep; row >= begin && row < end) relax_row<lanes>(row, b, x);
}

template <class Real>
void InteriorRelaxation<Real>::relax(int lanes, const Real* b, Real* x, int sweeps,
                                     SweepOrder order) const {
  const int line_count = int(blocks_.lines.size()) - 1;
  const auto relax_lines = [&](int begin, int end) {
    parallel_for(
        end - begin,
        [&](std::int64_t i) {
          const int line = begin + int(i);
          for (int block = blocks_.lines[line]; block < blocks_.lines[line + 1]; ++block)
            with_constant_lanes(lanes,
                                [&]<int L>() { relax_block<L>(block, b, x, sweeps, order); });
        },
        1);
  };
  relax_lines(0, blocks_.even_lines);
  relax_lines(blocks_.even_lines, line_count);
}

template <class Real>
void InteriorRelaxation<Real>::residual(int lanes, const Real* b, const Real* x, Real* r) const {
  parallel_for(
      std::int64_t(blocks_.segments.size()),
      [&](std::int64_t s) {
        with_constant_lanes(lanes, [&]<int L>() {
          residual_of_segment<L>(coefficients_.data() + starts_[s], blocks_.segments[s], b, x, r);
        });
      },
      64);
}

template <class Real>
std::int64_t InteriorRelaxation<Real>::bytes() const {
  return std::int64_t(coefficients_.size() * sizeof(Real) + starts_.size() * sizeof(starts_[0]) +
                      blocks_.segments.size() * sizeof(StencilRun));
}

template class InteriorRelaxation<float>;
template class InteriorRelaxation<double>;

}  // namespace mq
