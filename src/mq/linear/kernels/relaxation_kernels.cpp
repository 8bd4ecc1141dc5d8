#include "mq/linear/kernels/relaxation_kernels.h"

#include "mq/linear/kernels/real_lanes.h"
#include "mq/linear/kernels/rounded.h"

namespace mq::MARQUETRY_FORM {
namespace {

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
  for (int i = 0; i < s.count; ++i, a += WholeStencils<Real>::stride) {
    const auto rest =
        rounded(without_left<lanes>(a, b, x, s.first + i, s.up + i, s.down + i) * a[9]);
    left = rest - (a[3] * a[9]) * left;
    set_row<lanes>(x, s.first + i, left);
  }
}

template <int lanes, class Real>
inline void residual_of_segment(const Real* a, const StencilRun& s, const Real* b, const Real* x,
                                Real* r) {
  for (int i = 0; i < s.count; ++i, a += WholeStencils<Real>::stride) {
    const int k = s.first + i;
    auto sum = without_left<lanes>(a, b, x, k, s.up + i, s.down + i);
    sum -= a[3] * row_of<lanes>(x, k - 1);
    sum -= a[4] * row_of<lanes>(x, k);
    set_row<lanes>(r, k, sum);
  }
}

template <int lanes, class Real>
inline void relax_row(const WholeStencils<Real>& A, int row, const Real* b, Real* x) {
  for (int s = A.rows[row]; s < A.rows[row + 1]; ++s)
    relax_segment<lanes>(A.values + A.starts[s], A.segments[s], b, x);
}

template <int lanes, class Real>
inline void relax_rows(const WholeStencils<Real>& A, int begin, int end, const Real* b, Real* x,
                       int sweeps) {
  for (int front = begin; front < end + sweeps - 1; ++front)
    for (int sweep = 0; sweep < sweeps; ++sweep)
      if (const int row = front - sweep; row >= begin && row < end) relax_row<lanes>(A, row, b, x);
}

template <class Real>
void relax(int lanes, const WholeStencils<Real>& A, int begin, int end, const Real* b, Real* x,
           int sweeps) {
  if (lanes == 1)
    relax_rows<1>(A, begin, end, b, x, sweeps);
  else
    relax_rows<4>(A, begin, end, b, x, sweeps);
}

template <class Real>
void relax_plainly(int lanes, const WholeStencils<Real>& A, int begin, int end, const Real* b, Real* x,
                   int sweeps) {
  for (int sweep = 0; sweep < sweeps; ++sweep)
    for (int row = begin; row < end; ++row)
      if (lanes == 1)
        relax_row<1>(A, row, b, x);
      else
        relax_row<4>(A, row, b, x);
}

template <class Real>
void residual(int lanes, const WholeStencils<Real>& A, std::int64_t begin, std::int64_t end,
              const Real* b, const Real* x, Real* r) {
  for (std::int64_t s = begin; s < end; ++s)
    if (lanes == 1)
      residual_of_segment<1>(A.values + A.starts[s], A.segments[s], b, x, r);
    else
      residual_of_segment<4>(A.values + A.starts[s], A.segments[s], b, x, r);
}

template <int lanes, class Real>
inline void residual_of_rows(const SparseRows<Real>& A, const Real* b, const Real* x, const int* to,
                             Real* r) {
  for (std::int64_t p = A.begin; p < A.end; ++p) {
    auto sum = row_of<lanes>(b, A.rows[p]);
    for (std::int64_t e = A.starts[p]; e < A.ends[p]; ++e)
      sum -= A.entries[e].value * row_of<lanes>(x, A.entries[e].column);
    set_row<lanes>(r, to ? to[p] : p, sum);
  }
}

template <class Real>
void residual_of_sparse(int lanes, const SparseRows<Real>& A, const Real* b, const Real* x,
                        const int* to, Real* r) {
  if (lanes == 1)
    residual_of_rows<1>(A, b, x, to, r);
  else
    residual_of_rows<4>(A, b, x, to, r);
}

}  // namespace

const RelaxationKernels<float> float_relaxation_kernels = {
    relax<float>, relax_plainly<float>, residual<float>, residual_of_sparse<float>};
const RelaxationKernels<double> double_relaxation_kernels = {
    relax<double>, relax_plainly<double>, residual<double>, residual_of_sparse<double>};

}  // namespace mq::MARQUETRY_FORM
