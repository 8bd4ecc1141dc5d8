// log u_i += 0.8 δ_i,   δ_i = log(Σ_j a_ij u_j / u_i) + Σ_nearer p_ij δ_j,   Σ_nearer p_ij = 1.
//
// A first guess comes from the unknowns in the order in which they are met from the fixed ones,
// step by step along couplings, those met later decaying as in one dimension: Σa·(ρ + 1/ρ)/2 = 1.
// It is good enough to begin with. The order of falling u is found anew for every sweep, by a
// counting sort that tells apart what differs by a few thousandths.

#include "mq/filter/heat_sweeps.h"

#include <algorithm>
#include <cmath>

#include "mq/base/infinity.h"
#include "mq/filter/detail/falling_order.h"
#include "mq/filter/detail/heat_sweep.h"

namespace mq {
namespace {

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

/// Where sweeps lead: in one process as far as couplings do.
std::vector<int> reached(const SparseMatrix& A, const std::vector<std::pair<int, double>>& fixed, const Vector& guess,
                         const SharedUnknowns& shared) {
  if (shared.is_alone()) return by_steps(A, fixed);
  std::vector<int> met;
  for (int i = 0; i < int(A.rows()); ++i)
    if (shared.is_own(i) && std::isfinite(guess[i])) met.push_back(i);
  return met;
}

}  // namespace

HeatSweeps sweep_heat(const SparseMatrix& A, const std::vector<std::pair<int, double>>& fixed,
                      const HeatSweepOptions& options, const Vector& guess,
                      const Progress& progress) {
  return sweep_heat(A, fixed, options, guess, SharedUnknowns::alone(), progress);
}

HeatSweeps sweep_heat(const SparseMatrix& A, const std::vector<std::pair<int, double>>& fixed,
                      const HeatSweepOptions& options, const Vector& guess, const SharedUnknowns& shared,
                      const Progress& progress) {
  HeatSweeps result;
  Vector& log_u = result.log_u;
  log_u = Vector::Constant(A.rows(), -infinity);
  std::vector<char> is_fixed(std::size_t(A.rows()), 0);
  for (const auto& [i, value] : fixed) {
    log_u[i] = value;
    is_fixed[i] = 1;
  }
  std::vector<int> met = reached(A, fixed, guess, shared);
  for (const int i : met)
    if (!is_fixed[i]) log_u[i] = guess.size() > 0 ? guess[i] : first_guess(A, i, log_u);
  progress.at(0.1);

  HeatSweep sweep(A, std::move(met), is_fixed, log_u, shared);
  HeatSweepEnd end(options.tolerance);
  while (!end.reached(options.max_sweeps)) {
    end.add(sweep.find_misses(HeatSweep::most_tolerances * options.tolerance));
    sweep.carry();
    progress.at(1 - 0.9 / (1 + 0.1 * end.sweeps()));
  }
  result.sweeps = end.sweeps();
  result.change = end.last();
  progress.at(1);
  return result;
}

}  // namespace mq
