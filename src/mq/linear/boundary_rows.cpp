#include "mq/linear/boundary_rows.h"

#include "mq/base/parallel.h"
#include "mq/linear/real_lanes.h"

namespace mq {

template <class Real>
BoundaryRows<Real>::BoundaryRows(const SparseMatrix& A, std::vector<int> boundary)
    : boundary_(std::move(boundary)), position_(A.rows(), -1) {
  for (std::size_t p = 0; p < boundary_.size(); ++p) position_[boundary_[p]] = int(p);
  starts_.push_back(0);
  for (const int k : boundary_) {
    std::int64_t interior = 0, all = 0;
    for (SparseMatrix::InnerIterator entry(A, k); entry; ++entry) {
      interior += position_[entry.col()] < 0;
      ++all;
    }
    middles_.push_back(starts_.back() + interior);
    starts_.push_back(starts_.back() + all);
  }
  entries_.resize(starts_.back());
}

template <class Real>
void BoundaryRows<Real>::set_values(const SparseMatrix& A) {
  parallel_for(std::int64_t(boundary_.size()), [&](std::int64_t p) {
    std::int64_t interior = starts_[p], other = middles_[p];
    for (SparseMatrix::InnerIterator entry(A, boundary_[p]); entry; ++entry)
      entries_[position_[entry.col()] < 0 ? interior++ : other++] = {int(entry.col()),
                                                                     Real(entry.value())};
  });
}

template <class Real>
SparseMatrix BoundaryRows<Real>::block(const SparseMatrix& A) const {
  const int count = int(boundary_.size());
  SparseMatrix B(count, count);
  int* outer = B.outerIndexPtr();
  outer[0] = 0;
  for (int p = 0; p < count; ++p) outer[p + 1] = outer[p] + int(starts_[p + 1] - middles_[p]);
  B.resizeNonZeros(outer[count]);
  parallel_for(count, [&](std::int64_t p) {
    int at = outer[p];
    for (SparseMatrix::InnerIterator entry(A, boundary_[p]); entry; ++entry)
      if (const int column = position_[entry.col()]; column >= 0) {
        B.innerIndexPtr()[at] = column;
        B.valuePtr()[at++] = entry.value();
      }
  });
  return B;
}

template <class Real>
Signal BoundaryRows<Real>::interior_relative_residual(int lanes, int channels, const Real* b,
                                                      const Real* x) const {
  Signal R(boundary_.size(), channels);
  parallel_for(R.rows(), [&](std::int64_t p) {
    with_constant_lanes(lanes, [&]<int L>() {
      auto sum = row_of<L>(b, boundary_[p]);
      for (std::int64_t e = starts_[p]; e < middles_[p]; ++e)
        sum -= entries_[e].value * row_of<L>(x, entries_[e].column);
      Real values[L];
      set_row<L>(values, 0, sum);
      for (int c = 0; c < channels; ++c) R(p, c) = values[c];
    });
  });
  return R;
}

template <class Real>
void BoundaryRows<Real>::residual(int lanes, const Real* b, const Real* x, Real* r) const {
  parallel_for(std::int64_t(boundary_.size()), [&](std::int64_t p) {
    with_constant_lanes(lanes, [&]<int L>() {
      auto sum = row_of<L>(b, boundary_[p]);
      for (std::int64_t e = starts_[p]; e < starts_[p + 1]; ++e)
        sum -= entries_[e].value * row_of<L>(x, entries_[e].column);
      set_row<L>(r, boundary_[p], sum);
    });
  });
}

template <class Real>
std::int64_t BoundaryRows<Real>::bytes() const {
  return std::int64_t(entries_.size() * sizeof(Entry) + 4 * position_.size() + 16 * starts_.size());
}

template class BoundaryRows<float>;
template class BoundaryRows<double>;

}  // namespace mq
