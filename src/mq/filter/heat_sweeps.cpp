// log u_i += 0.8 δ_i,   δ_i = log(Σ_j a_ij u_j / u_i) + Σ_nearer p_ij δ_j,   Σ_nearer p_ij = 1.
//
// A first guess comes from the unknowns in the order in which they are met from the fixed ones,
// step by step along couplings, those met later decaying as in one dimension: Σa·(ρ + 1/ρ)/2 = 1.
// It is good enough to begin with. The order of falling u is found anew for every sweep, by a
// counting sort that tells apart what differs by a few thousandths.

#include "mq/filter/heat_sweeps.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "mq/base/infinity.h"
#include "mq/base/parallel.h"
#include "mq/filter/detail/falling_order.h"

namespace mq {
namespace {


/// Undamped, checkerboards would be kept where rows are five-point stencils.
constexpr double damping = 0.8;

/// By what factor a row may call for u to change in one sweep.
constexpr double most_change = 5;

/// A row that never fits, as where the solution is not positive, counts for no more than so many
/// tolerances.
constexpr double most_tolerances = 100;

/// Where rows that never fit are many the tolerance is out of reach: sweeps that bring down what is
/// missed by less than this share in `recent` of them, after as many to begin with, bring no more. Above
/// so many tolerances that says nothing, as rows count for no more there.
constexpr double least_progress = 0.05, near_tolerance = 10;
constexpr std::size_t recent = 10;

/// Beyond this ratio, e^8, of neighbours u is not believed.
constexpr float most_log_ratio = 8;

/// What a row says of log u where some neighbours in `log_u` are known, the others −∞. Couplings of
/// the wrong sign are left out.
double first_guess(const SparseMatrix& A, int i, const Vector& log_u) {
  double largest = -infinity, diagonal = 1;
  for (SparseMatrix::InnerIterator it(A, i); it; ++it) {
    if (it.col() == i)
      diagonal = it.value();
    else if (it.value() != 0)
      largest = std::max(largest, log_u[it.col()]);
  }
  double nearer = 0, farther = 0;
  for (SparseMatrix::InnerIterator it(A, i); it; ++it) {
    if (it.col() == i || it.value() > 0) continue;
    const double coupling = -it.value() / diagonal, value = log_u[it.col()];
    (value == -infinity ? farther : nearer) +=
        value == -infinity ? coupling : coupling * std::exp(value - largest);
  }
  const double all = std::clamp(nearer + farther, 1e-6, 1 - 1e-12);
  const double decay = (1 - std::sqrt(1 - all * all)) / all;
  return largest + std::clamp(std::log(nearer / std::max(0.05, 1 - decay * farther)), -3.0, 0.0);
}

class Sweep {
 public:
  Sweep(const SparseMatrix& A, std::vector<int> met, const std::vector<char>& fixed, Vector& log_u)
      : A_(A),
        met_(std::move(met)),
        fixed_(fixed),
        log_u_(log_u),
        shares_(std::size_t(A.nonZeros())),
        delta_(std::size_t(A.rows())) {
    std::sort(met_.begin(), met_.end());
  }

  /// Returns the mean of |c_i|, each at most `most`.
  double run(double most) {
    falling_.sort(met_, log_u_);
    parallel_for(std::ssize(met_), [&](std::int64_t k) { find_miss(met_[k]); });
    const double missed = parallel_sum(std::ssize(met_), 0.0, [&](auto begin, auto end) {
      double sum = 0;
      for (auto k = begin; k < end; ++k) sum += std::min(most, std::abs(delta_[met_[k]]));
      return sum;
    });
    const int *begin = A_.outerIndexPtr(), *columns = A_.innerIndexPtr();
    for (const int i : falling_.order())
      for (int e = begin[i]; e < begin[i + 1]; ++e)
        if (shares_[e] > 0) delta_[i] += shares_[e] * delta_[columns[e]];
    parallel_for(std::ssize(met_),
                 [&](std::int64_t k) { log_u_[met_[k]] += damping * delta_[met_[k]]; });
    return missed / double(met_.size());
  }

 private:
  /// c_i, and in what shares its nearer neighbours carry theirs to it.
  void find_miss(int i) {
    const int *begin = A_.outerIndexPtr(), *columns = A_.innerIndexPtr();
    const double* values = A_.valuePtr();
    delta_[i] = 0;
    double sum = 0, nearer = 0, diagonal = 1;
    for (int e = begin[i]; e < begin[i + 1]; ++e) {
      const int j = columns[e];
      shares_[e] = 0;
      if (j == i) diagonal = values[e];
      if (j == i || values[e] == 0 || fixed_[i]) continue;
      const float ratio =
          std::exp(std::clamp(float(log_u_[j] - log_u_[i]), -most_log_ratio, most_log_ratio));
      const double term = -values[e] * ratio;
      sum += term;
      if (term <= 0 || !falling_.before(j, i)) continue;
      shares_[e] = float(term);
      nearer += term;
    }
    if (fixed_[i]) return;
    if (nearer > 0)
      for (int e = begin[i]; e < begin[i + 1]; ++e) shares_[e] /= float(nearer);
    delta_[i] = std::log(std::clamp(sum / diagonal, 1 / most_change, most_change));
  }

  const SparseMatrix& A_;
  std::vector<int> met_;  ///< what is swept, ascending
  const std::vector<char>& fixed_;
  Vector& log_u_;
  std::vector<float> shares_;  ///< per entry of A
  std::vector<double> delta_;
  FallingOrder falling_;
};

}  // namespace

HeatSweeps sweep_heat(const SparseMatrix& A, const std::vector<std::pair<int, double>>& fixed,
                      const HeatSweepOptions& options, const Vector& guess,
                      const Progress& progress) {
  HeatSweeps result;
  Vector& log_u = result.log_u;
  log_u = Vector::Constant(A.rows(), -infinity);
  std::vector<char> is_fixed(std::size_t(A.rows()), 0);
  for (const auto& [i, value] : fixed) {
    log_u[i] = value;
    is_fixed[i] = 1;
  }
  std::vector<int> met = by_steps(A, fixed);
  for (const int i : met)
    if (!is_fixed[i]) log_u[i] = guess.size() > 0 ? guess[i] : first_guess(A, i, log_u);
  progress.at(0.1);

  Sweep sweep(A, std::move(met), is_fixed, log_u);
  result.change = infinity;
  std::vector<double> missed;
  const auto stands_still = [&] {
    return missed.size() >= 2 * recent && missed.back() < near_tolerance * options.tolerance &&
           missed.back() > (1 - least_progress) * missed[missed.size() - 1 - recent];
  };
  while (result.sweeps < options.max_sweeps && result.change > options.tolerance &&
         !stands_still()) {
    result.change = sweep.run(most_tolerances * options.tolerance);
    missed.push_back(result.change);
    ++result.sweeps;
    progress.at(1 - 0.9 / (1 + 0.1 * result.sweeps));
  }
  progress.at(1);
  return result;
}

}  // namespace mq
