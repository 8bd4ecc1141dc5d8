#include "mq/filter/detail/heat_sweep.h"

#include <algorithm>
#include <cmath>

#include "mq/base/parallel.h"

namespace mq {
namespace {

/// Undamped, checkerboards would be kept where rows are five-point stencils.
constexpr double damping = 0.8;

/// By what factor a row may call for u to change in one sweep.
constexpr double most_change = 5;

/// Beyond this ratio, e^8, of neighbours u is not believed.
constexpr float most_log_ratio = 8;

/// Where rows that never fit are many the tolerance is out of reach: sweeps that bring down what is
/// missed by less than this share in `recent` of them, after as many to begin with, bring no more. Above
/// so many tolerances that says nothing, as rows count for no more there.
constexpr double least_progress = 0.05, near_tolerance = 10;
constexpr std::size_t recent = 10;

/// What comes over from other processes is carried on while anything of it is more than this share of what rows miss
/// on average: then sweeps are those of one process.
constexpr double least_carried = 1e-6;

}  // namespace

HeatSweep::HeatSweep(const SparseMatrix& A, std::vector<int> met, std::vector<char> fixed, Vector& log_u,
                     const SharedUnknowns& shared)
    : A_(A),
      shared_(shared),
      met_(std::move(met)),
      fixed_(std::move(fixed)),
      log_u_(log_u),
      shares_(std::size_t(A.nonZeros())),
      delta_(Vector::Zero(A.rows())) {
  std::sort(met_.begin(), met_.end());
  shared_.fill_halo(log_u_);
  beside_ = shared_.halo();
  std::erase_if(beside_, [&](int i) { return !std::isfinite(log_u_[i]); });
}

double HeatSweep::find_misses(double most) {
  FallingOrder::Range range = FallingOrder::range(met_, log_u_);
  double ends[] = {range.high, -range.low};
  shared_.largest(ends);
  falling_.sort(met_, beside_, log_u_, {ends[0], -ends[1]});
  parallel_for(std::ssize(met_), [&](std::int64_t k) { find_miss(met_[k]); });
  const double missed = parallel_sum(std::ssize(met_), 0.0, [&](auto begin, auto end) {
    double sum = 0;
    for (auto k = begin; k < end; ++k) sum += std::min(most, std::abs(delta_[met_[k]]));
    return sum;
  });
  double sums[] = {missed, double(met_.size())};
  shared_.sum(sums);
  return missed_ = sums[0] / sums[1];
}

void HeatSweep::carry_own() {
  const int *begin = A_.outerIndexPtr(), *columns = A_.innerIndexPtr();
  for (const int i : falling_.order())
    for (int e = begin[i]; e < begin[i + 1]; ++e)
      if (shares_[e] > 0) delta_[i] += shares_[e] * delta_[columns[e]];
}

/// What is carried is linear in what is missed: of each change that comes over, the change that it makes is added.
void HeatSweep::carry_of_others() {
  Vector all = delta_, heard, known = Vector::Zero(delta_.size());
  delta_.setZero();
  touched_.assign(std::size_t(delta_.size()), 0);
  const double least = least_carried * missed_;
  for (;;) {
    heard = all;
    shared_.fill_halo(heard);
    double largest = 0;
    for (const int i : beside_) {
      const double change = heard[i] - known[i];
      if (!(std::abs(change) > least)) continue;
      known[i] = heard[i];
      delta_[i] = change;
      touch_around(i);
      largest = std::max(largest, std::abs(change));
    }
    if (!(shared_.largest(largest) > 0)) break;
    carry_touched(all);
    for (const int i : beside_) delta_[i] = 0;
  }
  delta_ = std::move(all);
}

/// Of the rows that something came to, in order; what it makes is added to `all`.
void HeatSweep::carry_touched(Vector& all) {
  const int *begin = A_.outerIndexPtr(), *columns = A_.innerIndexPtr();
  std::vector<int> changed;
  for (const int i : falling_.order()) {
    if (!touched_[i]) continue;
    touched_[i] = 0;
    double change = 0;
    for (int e = begin[i]; e < begin[i + 1]; ++e)
      if (shares_[e] > 0) change += shares_[e] * delta_[columns[e]];
    if (change == 0) continue;
    delta_[i] = change;
    changed.push_back(i);
    touch_around(i);
  }
  for (const int i : changed) {
    all[i] += delta_[i];
    delta_[i] = 0;
  }
}

void HeatSweep::touch_around(int i) {
  for (SparseMatrix::InnerIterator it(A_, i); it; ++it) touched_[it.col()] = 1;
}

void HeatSweep::carry() {
  for (const int i : beside_) delta_[i] = 0;
  carry_own();
  if (!shared_.is_alone()) carry_of_others();
  parallel_for(std::ssize(met_),
               [&](std::int64_t k) { log_u_[met_[k]] += damping * delta_[met_[k]]; });
  shared_.fill_halo(log_u_);
}

void HeatSweep::find_miss(int i) {
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

bool HeatSweepEnd::reached(int max_sweeps) const {
  if (sweeps() >= max_sweeps || !(last() > tolerance_)) return true;
  return missed_.size() >= 2 * recent && last() < near_tolerance * tolerance_ &&
         last() > (1 - least_progress) * missed_[missed_.size() - 1 - recent];
}

}  // namespace mq
