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
  const Eigen::RowVectorXd zero = Eigen::RowVectorXd::Zero(X.cols());
  return parallel_sum(X.rows(), zero, [&](std::int64_t begin, std::int64_t end) {
    return Eigen::RowVectorXd(X.middleRows(begin, end - begin)
                                  .cwiseProduct(Y.middleRows(begin, end - begin))
                                  .colwise()
                                  .sum());
  });
}

double worst_ratio(const Eigen::RowVectorXd& squared, const Eigen::RowVectorXd& squared_at_start) {
  double worst = 0;
  for (Eigen::Index c = 0; c < squared.size(); ++c)
    if (squared_at_start[c] > 0) worst = std::max(worst, squared[c] / squared_at_start[c]);
  return std::sqrt(worst);
}

}  // namespace mq
