#include "mq/linear/boundary_rows.h"

#include "mq/base/parallel.h"

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
  std::vector<Real> values(boundary_.size() * std::size_t(lanes));
  parallel_blocks(R.rows(), 1024, [&](std::int64_t begin, std::int64_t end) {
    relaxation_kernels<Real>().residual_of_sparse(
        lanes,
        {boundary_.data(), starts_.data(), middles_.data(), entries_.data(), begin, end}, b, x,
        nullptr, values.data());
    for (std::int64_t p = begin; p < end; ++p)
      for (int c = 0; c < channels; ++c) R(p, c) = values[std::size_t(p * lanes + c)];
  });
  return R;
}

template <class Real>
void BoundaryRows<Real>::residual(int lanes, const Real* b, const Real* x, Real* r) const {
  parallel_blocks(
      std::int64_t(boundary_.size()), 1024, [&](std::int64_t begin, std::int64_t end) {
        relaxation_kernels<Real>().residual_of_sparse(
            lanes,
            {boundary_.data(), starts_.data(), starts_.data() + 1, entries_.data(), begin, end}, b,
            x, boundary_.data(), r);
      });
}

template <class Real>
std::int64_t BoundaryRows<Real>::bytes() const {
  return std::int64_t(entries_.size() * sizeof(Entry) + 4 * position_.size() + 16 * starts_.size());
}

template class BoundaryRows<float>;
template class BoundaryRows<double>;

}  // namespace mq
