#include "mq/filter/seam_agreement.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "mq/base/error.h"
#include "mq/base/parallel.h"

namespace mq {
namespace {

/// ε of texels that a chart covers where κ is 0, and of those that none does.
constexpr double hold = 3e-3, hold_outside = 1e-4;
constexpr double points_per_texel = 2;
constexpr double tolerance = 1e-3;
constexpr int most_iterations = 100;
/// Values that would leave the range stay at its end while the others are solved for again.
constexpr int rounds = 3;

/// The texels that lookups at seams read, and the differences of both sides as a matrix of these.
struct Differences {
  std::vector<int> texels;  ///< ascending
  SparseMatrix D;           ///< √ds · (difference of both sides) at points along seams, a row each; a column per texel

  Vector column_of(const Signal& signal, Eigen::Index channel) const {
    Vector values(std::ssize(texels));
    for (std::size_t k = 0; k < texels.size(); ++k) values[Eigen::Index(k)] = signal(texels[k], channel);
    return values;
  }
};

Differences differences(const TraceAtlas& domain) {
  std::vector<Eigen::Triplet<double, int>> entries;
  int rows = 0;
  domain.for_each_seam([&](double length, const TraceAtlas::SeamPlaces& places) {
    const int count = std::max(1, int(std::ceil(points_per_texel * length)));
    const double root = std::sqrt(length / count);
    for (int n = 0; n < count; ++n, ++rows) {
      const auto [here, there] = places((n + 0.5) / count);
      domain.for_each_corner(here, [&](int i, double w) { entries.emplace_back(rows, i, root * w); });
      domain.for_each_corner(there, [&](int i, double w) { entries.emplace_back(rows, i, -root * w); });
    }
  });
  Differences found;
  std::vector<int>& texels = found.texels;
  for (const auto& entry : entries) texels.push_back(entry.col());
  std::sort(texels.begin(), texels.end());
  texels.erase(std::unique(texels.begin(), texels.end()), texels.end());
  for (auto& entry : entries) {
    const auto column = std::lower_bound(texels.begin(), texels.end(), entry.col()) - texels.begin();
    entry = {entry.row(), int(column), entry.value()};
  }
  found.D.resize(rows, std::ssize(texels));
  found.D.setFromTriplets(entries.begin(), entries.end());
  return found;
}

/// κ at the points: the mean over the texels looked up.
Vector shares_of_points(const SparseMatrix& D, const Vector& kept) {
  Vector share(D.rows());
  for (Eigen::Index r = 0; r < D.rows(); ++r) {
    double sum = 0, weight = 0;
    for (SparseMatrix::InnerIterator it(D, r); it; ++it) {
      sum += std::abs(it.value()) * kept[it.col()];
      weight += std::abs(it.value());
    }
    share[r] = weight > 0 ? sum / weight : 1;
  }
  return share;
}

/// δ of (DᵀD + ε) δ = b where `open` is 1, by conjugate gradients scaled by the diagonal; b is 0 elsewhere.
Vector solve(const SparseMatrix& D, const Vector& weight, const Vector& open, const Vector& diagonal, Vector residual,
             const Progress& progress) {
  Vector delta = Vector::Zero(residual.size()), z = residual.cwiseQuotient(diagonal), p = z;
  double rho = residual.dot(z);
  const double enough = tolerance * tolerance * rho;
  Vector differences(D.rows()), q(residual.size());
  for (int k = 0; k < most_iterations && rho > enough; ++k) {
    progress.check();
    differences.noalias() = D * p;
    q.noalias() = D.transpose() * differences;
    q = q.cwiseProduct(open) + weight.cwiseProduct(p);
    const double step = rho / p.dot(q);
    delta += step * p;
    residual -= step * q;
    z = residual.cwiseQuotient(diagonal);
    const double next = residual.dot(z);
    p = z + next / rho * p;
    rho = next;
  }
  return delta;
}

}  // namespace

Signal agree_at_seams(const TraceAtlas& domain, const Signal& signal, const Signal& before, const Vector& kept,
                      const std::vector<char>& outside, const Progress& progress) {
  require(signal.rows() == domain.space().size() && std::ssize(outside) == domain.space().size() &&
              kept.size() == signal.rows() && before.rows() == signal.rows() && before.cols() == signal.cols(),
          "one row and one mark per texel are needed");
  const Differences seams = differences(domain);
  const std::int64_t count = std::ssize(seams.texels);
  // Where ε is infinite the texel is closed.
  Vector open(count), weight(count), share(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const std::size_t i = std::size_t(seams.texels[std::size_t(k)]);
    share[k] = kept[Eigen::Index(i)];
    open[k] = outside[i] || share[k] < 1 ? 1 : 0;
    weight[k] = outside[i] ? hold_outside : open[k] > 0 ? hold / (1 - share[k]) : 1;
  }
  Vector diagonal = weight;
  for (Eigen::Index r = 0; r < seams.D.outerSize(); ++r)
    for (SparseMatrix::InnerIterator it(seams.D, r); it; ++it) diagonal[it.col()] += it.value() * it.value();
  share = shares_of_points(seams.D, share);
  Signal result = signal;
  const double all = double(signal.cols() * rounds);
  std::atomic<int> done = 0;
  progress.at(0.3);
  parallel_for(
      signal.cols(),
      [&](std::int64_t c) {
        const double low = signal.col(c).minCoeff(), high = signal.col(c).maxCoeff();
        const Vector target = share.cwiseProduct(seams.D * seams.column_of(before, c));
        Vector values = seams.column_of(signal, c), free = open;
        for (int round = 0; round < rounds; ++round) {
          const Vector wrong = seams.D * values - target;
          const Vector delta =
              solve(seams.D, weight, free, diagonal, -Vector(seams.D.transpose() * wrong).cwiseProduct(free), progress);
          progress.at(0.3 + 0.7 * ++done / all);
          for (Eigen::Index k = 0; k < count; ++k) {
            if (delta[k] == 0) continue;
            const double wanted = values[k] + delta[k];
            values[k] = std::clamp(wanted, low, high);
            if (values[k] != wanted) free[k] = 0;
          }
        }
        for (Eigen::Index k = 0; k < count; ++k) result(seams.texels[std::size_t(k)], c) = values[k];
      },
      1);
  return result;
}

}  // namespace mq
