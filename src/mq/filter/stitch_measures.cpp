// How well a stitched signal keeps means and meets at borders.
#include "mq/filter/stitch.h"

#include <fmt/format.h>

#include <cmath>

#include "mq/base/error.h"
#include "mq/base/parallel.h"

namespace mq {

double mean_drift(const SignalSpace& space, const Signal& before, const Signal& after,
                  std::span<const int> labels) {
  require(
      before.rows() == space.size() && after.rows() == space.size() &&
          before.cols() == after.cols() && std::ssize(labels) == space.size(),
      fmt::format(
          "signals of {} × {} and {} × {} and {} labels: wanted {} rows, the same channels and "
          "one label for each row",
          before.rows(), before.cols(), after.rows(), after.cols(), labels.size(), space.size()));
  Vector mass = space.lumped_mass();
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (labels[i] == unseen) mass[Eigen::Index(i)] = 0;
  if (!(mass.sum() > 0)) return 0;
  return (mass.transpose() * (after - before) / mass.sum()).cwiseAbs().maxCoeff();
}

BorderJump border_jump(const SparseMatrix& stiffness, const Signal& psi,
                       std::span<const int> labels) {
  require(stiffness.rows() == psi.rows() && std::ssize(labels) == psi.rows(),
          fmt::format("a stiffness of {} rows, a signal of {} and {} labels do not fit",
                      stiffness.rows(), psi.rows(), labels.size()));
  struct Sums {
    double across = 0, within = 0, across_weight = 0, within_weight = 0;
    std::int64_t pairs = 0;
    Sums operator+(const Sums& o) const {
      return {across + o.across, within + o.within, across_weight + o.across_weight,
              within_weight + o.within_weight, pairs + o.pairs};
    }
  };
  const Sums all = parallel_sum(psi.rows(), Sums(), [&](std::int64_t begin, std::int64_t end) {
    Sums part;
    for (int i = int(begin); i < int(end); ++i)
      for (SparseMatrix::InnerIterator it(stiffness, i); it; ++it) {
        const int j = int(it.col());
        if (j <= i || !(it.value() < 0) || labels[i] == unseen || labels[j] == unseen) continue;
        const double square = (psi.row(j) - psi.row(i)).squaredNorm() / double(psi.cols());
        const bool across = labels[i] != labels[j];
        (across ? part.across : part.within) -= it.value() * square;
        (across ? part.across_weight : part.within_weight) -= it.value();
        part.pairs += across;
      }
    return part;
  });
  const auto root = [](double sum, double weight) {
    return weight > 0 ? std::sqrt(sum / weight) : 0;
  };
  return {root(all.across, all.across_weight), root(all.within, all.within_weight), all.pairs};
}

}  // namespace mq
