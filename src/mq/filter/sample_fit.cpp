#include "mq/filter/sample_fit.h"

#include <fmt/format.h>

#include <algorithm>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/linear/conjugate_gradients.h"

namespace mq {
namespace {

constexpr double to_the_mean = 1e-3;  // η
constexpr double least_seen = 0.1;
constexpr double fit_tolerance = 1e-4;
constexpr double hardly = 1e-6;  ///< of the mean area of a function

/// Adds to an entry of a symmetric matrix; where the pattern lacks it, which is so of functions
/// that meet in a point alone, to the diagonals, so that the matrix stays definite.
void add_to(SparseMatrix& A, int i, int j, double value) {
  const int* columns = A.innerIndexPtr();
  const int begin = A.outerIndexPtr()[i], end = A.outerIndexPtr()[i + 1];
  const int* at = std::lower_bound(columns + begin, columns + end, j);
  if (at == columns + end || *at != j) at = std::lower_bound(columns + begin, columns + end, i);
  A.valuePtr()[at - columns] += value;
}

}  // namespace

SampleFit::SampleFit(const SignalSpace& space, int channels, const Progress& progress)
    : space_(space),
      normal_(space.system(1, 0, progress)),
      mass_(normal_ * Vector::Ones(space.size())),
      moments_(Signal::Zero(space.size(), channels)),
      seen_(Vector::Zero(space.size())),
      sampled_(Vector::Zero(space.size())) {
  normal_.makeCompressed();
  std::fill_n(normal_.valuePtr(), normal_.nonZeros(), 0.0);
  mass_ = mass_.cwiseMax(hardly * mass_.mean());
}

void SampleFit::add(std::span<const SurfacePoint> points, std::span<const double> areas,
                    const Signal& values, std::span<const char> seen) {
  require(
      points.size() == areas.size() && std::ssize(points) == values.rows() &&
          points.size() == seen.size() && values.cols() == moments_.cols(),
      fmt::format("{} samples with {} areas, {} values of {} channels and {} marks: wanted as many "
                  "of each, and {} channels",
                  points.size(), areas.size(), values.rows(), values.cols(), seen.size(),
                  moments_.cols()));
  std::vector<std::vector<BasisWeight>> bases(points.size());
  parallel_for(
      std::ssize(points),
      [&](std::int64_t s) {
        const SurfacePoint& p = points[std::size_t(s)];
        bases[std::size_t(s)] = space_.basis_at(p.triangle, p.barycentric);
      },
      1024);
  for (std::size_t s = 0; s < points.size(); ++s)
    for (const BasisWeight& i : bases[s]) {
      const double weight = areas[s] * i.weight;
      sampled_[i.unknown] += weight;
      if (!seen[s]) continue;
      seen_[i.unknown] += weight;
      moments_.row(i.unknown) += weight * values.row(Eigen::Index(s));
      for (const BasisWeight& j : bases[s])
        add_to(normal_, i.unknown, j.unknown, weight * j.weight);
    }
}

std::vector<char> SampleFit::known() const {
  std::vector<char> known(std::size_t(space_.size()));
  for (int i = 0; i < space_.size(); ++i)
    known[std::size_t(i)] = seen_[i] > 0 && seen_[i] >= least_seen * sampled_[i];
  return known;
}

std::int64_t SampleFit::unseen() const {
  const std::vector<char> is_known = known();
  const double least = hardly * sampled_.mean();
  std::int64_t count = 0;
  for (int i = 0; i < space_.size(); ++i) count += !is_known[std::size_t(i)] && sampled_[i] > least;
  return count;
}

Signal SampleFit::mean() const {
  const std::vector<char> is_known = known();
  Signal mean = seen_means();
  for (int i = 0; i < space_.size(); ++i)
    if (!is_known[std::size_t(i)]) mean.row(i).setZero();
  return mean;
}

/// φ̄ of all of which anything was seen.
Signal SampleFit::seen_means() const {
  Signal means = Signal::Zero(moments_.rows(), moments_.cols());
  for (int i = 0; i < space_.size(); ++i)
    if (seen_[i] > 0) means.row(i) = moments_.row(i) / seen_[i];
  return means;
}

Filtered SampleFit::least_squares(const Progress& progress) const {
  Filtered fit{.signal = seen_means(), .report = {}};
  const std::vector<char> is_known = known();
  SparseMatrix A = normal_;
  Signal b = moments_;
  // What is not known keeps its mean, and stands alone in the matrix.
  for (int i = 0; i < space_.size(); ++i) {
    const bool is_free = is_known[std::size_t(i)];
    for (SparseMatrix::InnerIterator entry(A, i); entry; ++entry) {
      const int j = int(entry.col());
      if (is_free && !is_known[std::size_t(j)]) b.row(i) -= entry.value() * fit.signal.row(j);
      if (!is_free || !is_known[std::size_t(j)]) entry.valueRef() = 0;
      if (i == j) entry.valueRef() += is_free ? to_the_mean * mass_[i] : 1;
    }
    if (is_free)
      b.row(i) += to_the_mean * mass_[i] * fit.signal.row(i);
    else
      b.row(i) = fit.signal.row(i);
  }
  fit.report = conjugate_gradients(A, b, fit.signal, jacobi_preconditioner(A),
                                   {.tolerance = fit_tolerance}, progress);
  for (int i = 0; i < space_.size(); ++i)
    if (!is_known[std::size_t(i)]) fit.signal.row(i).setZero();
  return fit;
}

}  // namespace mq
