#include "mq/filter/weak_unknowns.h"

#include <algorithm>
#include <limits>

#include "mq/base/parallel.h"
#include "mq/filter/region_levels.h"

namespace mq {

WeakUnknowns::WeakUnknowns(const SparseMatrix& stiffness, const Vector& diagonal, std::span<const int> labels,
                           std::span<const int> rows) {
  constexpr double times = 5;
  std::vector<char> is_weak(rows.size(), 0);
  const auto bounds = [&](int i, int j) { return labels[j] == labels[i] && diagonal[j] >= times * diagonal[i]; };
  parallel_for(std::ssize(rows), [&](std::int64_t k) {
    const int i = rows[k];
    if (labels[i] == unseen || !(diagonal[i] > 0)) return;
    for (SparseMatrix::InnerIterator it(stiffness, i); it && !is_weak[k]; ++it) is_weak[k] = bounds(i, int(it.col()));
  });
  for (std::size_t k = 0; k < is_weak.size(); ++k)
    if (is_weak[k]) rows_.push_back(rows[k]);
  // Those that meet it more come first, since they bound the others.
  std::ranges::stable_sort(rows_, [&](int a, int b) { return diagonal[a] > diagonal[b]; });
  for (const int i : rows_) {
    std::vector<int>& beside = beside_.emplace_back();
    for (SparseMatrix::InnerIterator it(stiffness, i); it; ++it)
      if (bounds(i, int(it.col()))) beside.push_back(int(it.col()));
  }
}

bool WeakUnknowns::bound(const Signal& asked, Signal& delta) const {
  bool changed = false;
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    Eigen::RowVectorXd low = Eigen::RowVectorXd::Constant(delta.cols(), std::numeric_limits<double>::infinity());
    Eigen::RowVectorXd high = -low;
    for (const int j : beside_[k]) {
      low = low.cwiseMin(delta.row(j));
      high = high.cwiseMax(delta.row(j));
    }
    const Eigen::RowVectorXd bounded = asked.row(rows_[k]).cwiseMax(low).cwiseMin(high);
    changed = changed || bounded != delta.row(rows_[k]);
    delta.row(rows_[k]) = bounded;
  }
  return changed;
}

}  // namespace mq
