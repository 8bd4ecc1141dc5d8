#include "mq/linear/residual.h"

#include <algorithm>
#include <cmath>

#include "mq/base/parallel.h"

namespace mq {

Signal residual(const SparseMatrix& A, const Signal& X, const Signal& B) {
  Signal R(B.rows(), B.cols());
  parallel_for(A.rows(), [&](std::int64_t row) {
    R.row(row) = B.row(row);
    for (SparseMatrix::InnerIterator entry(A, row); entry; ++entry)
      R.row(row) -= entry.value() * X.row(entry.col());
  });
  return R;
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
