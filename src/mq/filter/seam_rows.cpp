#include "mq/filter/seam_rows.h"

namespace mq {
namespace {

constexpr double part_beyond = 0.25;  // of the range

}  // namespace

Signal seam_imbalance(const TexelSpace& space, const SparseMatrix& A, const Signal& psi, const std::vector<int>& rows,
                      Smooth what) {
  Signal result = Signal::Zero(psi.rows(), psi.cols());
  if (what == Smooth::values) {
    for (const int i : rows)
      for (SparseMatrix::InnerIterator it(A, i); it; ++it)
        result.row(i) -= it.value() * (psi.row(it.col()) - psi.row(i));
    return result;
  }
  std::vector<int> labels(std::size_t(psi.rows()), -1);
  for (const int i : rows) labels[std::size_t(i)] = i;
  space.for_each_mixed_element(labels, [&](const Element& element) {
    if (!element.own.empty()) return;
    const std::size_t count = element.unknowns.size();
    for (std::size_t k = 0; k < count; ++k)
      for (std::size_t m = 0; m < count; ++m)
        result.row(element.unknowns[k]) -=
            element.stiffness[k * count + m] *
            (psi.row(element.unknowns[m]) - psi.row(element.unknowns[k]));
  });
  return result;
}

void ValueRange::extend(const Eigen::RowVectorXd& values) {
  if (!any()) low = high = values;
  low = low.cwiseMin(values);
  high = high.cwiseMax(values);
}

void ValueRange::extend(const ValueRange& other) {
  if (!other.any()) return;
  extend(other.low);
  extend(other.high);
}

void ValueRange::extend(const SparseMatrix& A, const Signal& psi, const std::vector<char>& counts, int i) {
  for (SparseMatrix::InnerIterator it(A, i); it; ++it)
    if (counts[std::size_t(it.col())]) extend(psi.row(it.col()));
}

bool ValueRange::bring_back(Signal& phi, int i) const {
  if (!any()) return false;
  const Eigen::RowVectorXd more = part_beyond * (high - low);
  const Eigen::RowVectorXd within = phi.row(i).cwiseMax(low - more).cwiseMin(high + more);
  if (within == phi.row(i)) return false;
  phi.row(i) = within;
  return true;
}

}  // namespace mq
