#include "mq/linear/residual.h"

#include <algorithm>
#include <cmath>

#include "mq/base/parallel.h"

namespace mq {

namespace {

/// The channels from `first` on of the product, `count` of them: few enough for registers.
template <int count>
void multiply_channels(const SparseMatrix& A, const Signal& X, Signal& Y, Eigen::Index first) {
  const Eigen::Index channels = X.cols();
  const int* row_begin = A.outerIndexPtr();
  const int* column = A.innerIndexPtr();
  const double* value = A.valuePtr();
  parallel_for(A.rows(), [&](std::int64_t row) {
    double sum[count] = {};
    for (int e = row_begin[row]; e < row_begin[row + 1]; ++e) {
      const double* x = X.data() + column[e] * channels + first;
      for (int c = 0; c < count; ++c) sum[c] += value[e] * x[c];
    }
    std::copy(sum, sum + count, Y.data() + row * channels + first);
  });
}

}  // namespace

void multiply(const SparseMatrix& A, const Signal& X, Signal& Y) {
  if (!A.isCompressed()) {
    SparseMatrix compressed = A;
    compressed.makeCompressed();
    return multiply(compressed, X, Y);
  }
  Y.resize(A.rows(), X.cols());
  Eigen::Index first = 0;
  for (; first + 3 < X.cols(); first += 4) multiply_channels<4>(A, X, Y, first);
  switch (X.cols() - first) {
    case 1: return multiply_channels<1>(A, X, Y, first);
    case 2: return multiply_channels<2>(A, X, Y, first);
    case 3: return multiply_channels<3>(A, X, Y, first);
  }
}

Signal residual(const SparseMatrix& A, const Signal& X, const Signal& B) {
  Signal R;
  multiply(A, X, R);
  parallel_blocks(R.size(), 16384, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) R.data()[i] = B.data()[i] - R.data()[i];
  });
  return R;
}

void add_scaled(Signal& Y, const Signal& X, const Eigen::RowVectorXd& a) {
  const Eigen::Index channels = Y.cols();
  parallel_blocks(Y.rows(), 16384, [&](std::int64_t begin, std::int64_t end) {
    const double* x = X.data() + begin * channels;
    double* y = Y.data() + begin * channels;
    for (std::int64_t row = begin; row < end; ++row)
      for (Eigen::Index c = 0; c < channels; ++c) *y++ += a[c] * *x++;
  });
}

Eigen::RowVectorXd channel_dots(const Signal& X, const Signal& Y) {
  // Loops, not Eigen's sums: those may depend on where the data lie in memory.
  const Eigen::Index channels = X.cols();
  const Eigen::RowVectorXd zero = Eigen::RowVectorXd::Zero(channels);
  return parallel_sum(X.rows(), zero, [&](std::int64_t begin, std::int64_t end) {
    Eigen::RowVectorXd sum = zero;
    const double* x = X.data() + begin * channels;
    const double* y = Y.data() + begin * channels;
    for (std::int64_t row = begin; row < end; ++row)
      for (Eigen::Index c = 0; c < channels; ++c) sum[c] += *x++ * *y++;
    return sum;
  });
}

double worst_ratio(const Eigen::RowVectorXd& squared, const Eigen::RowVectorXd& squared_at_start) {
  double worst = 0;
  for (Eigen::Index c = 0; c < squared.size(); ++c)
    if (squared_at_start[c] > 0) worst = std::max(worst, squared[c] / squared_at_start[c]);
  return std::sqrt(worst);
}

}  // namespace mq
