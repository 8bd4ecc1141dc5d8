/// Per channel, with C the cycle:
///
///     z = C·r,   ρ = ⟨z, r⟩,   β = ρ/ρ_before,   p = z + β·p,   q = A·p,   α = ⟨p, r⟩/⟨p, q⟩,
///     X += α·p,   r −= α·q
///
/// q lies where z was: three vectors of the finest level and the one of the cycle are all there are. A channel that has
/// reached the tolerance rests with α = 0, and so does one whose step is lost in rounding; β = 0 begins anew after
/// either. X is in double from the first step on: where A is mostly stiffness, rounding of its slow waves would be a
/// residual as large as the one that three digits are to be gained on. The four lanes of a single channel are partial sums
/// of that channel; vectors are then walked in the same way in either case.

#include "mq/linear/mixed_cg.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include <fmt/format.h>

#include "mq/linear/detail/scaled_vectors.h"
#include "mq/linear/detail/true_residual.h"
#include "mq/base/parallel_values.h"
#include "mq/linear/error_estimate.h"

namespace mq {

namespace {

using Clock = std::chrono::steady_clock;

constexpr int max_lost = 2;           // directions in a row that rounding may spoil
constexpr int max_idle = 3;           // renewals in a row that find the residual where it was
constexpr double diverged = 100;      // times the first residual; a little more than 1 may pass
constexpr double renew_below = 1e-3;  // digits a residual in single precision may lose, see above

/// Whether columns first … first + channels − 1 of X are all 0.
bool is_zero(const Signal& X, int first, int channels) {
  return parallel_all(X.rows(), [&](std::int64_t begin, std::int64_t end) {
    return X.block(begin, first, end - begin, channels).isZero(0);
  });
}

/// What columns of X and B are multiplied by so that squares of what is left of them stay in single precision: a power of
/// two, 1 where they do anyway.
double unit_of(const Signal& B, const Signal& X, int first, int channels, double common) {
  constexpr double small = 1e-8, large = 1e8;
  const double size = parallel_sum(B.rows(), LargestValues{}, [&](std::int64_t begin, std::int64_t end) {
    const auto largest = [&](const Signal& of) {
      return of.block(begin, first, end - begin, channels).cwiseAbs().maxCoeff();
    };
    return LargestValues{.change = {}, .value = Double4{} + std::max(common * largest(B), largest(X))};
  }).value[0];
  const bool ordinary = !(size > 0) || !std::isfinite(size) || (size > small && size < large);
  return ordinary ? 1 : std::exp2(-std::ilogb(size));
}

void multiply_columns(double factor, int first, int channels, Signal& X) {
  if (factor == 1) return;
  parallel_for(X.rows(), [&](std::int64_t k) { X.row(k).segment(first, channels) *= factor; });
}

/// The conjugate gradients of up to four channels.
class Group {
 public:
  /// X is that of the scaled system, in the unit of `unit_of`.
  Group(const StencilMatrix& high, const StencilMatrix& low, const Scaling& scaling,
        const Multigrid& multigrid, const Components& components, const Signal& B, Signal& X,
        int first, double unit, const MixedCgOptions& options)
      : high_(high), low_(low), scaling_(scaling), multigrid_(multigrid),
        constants_(components, scaling), X_(X), first_(first), channels_(std::min(4, int(B.cols()) - first)),
        B_(B, first, channels_, scaling, constants_, unit),
        lanes_(lanes_for(channels_)), workspace_(multigrid, lanes_), options_(options) {
    for (LaneVector* v : {&r_, &z_, &p_}) *v = LaneVector(B.rows(), lanes_);
    if (is_zero(X, first, channels_))
      take_right_hand_side(B_, channels_, r_);
    else
      take_true_residual();
    constants_.remove(r_);
    squared_ = renewed_ = squared_norm(scaling_, r_);
    start_ = squared_;
    wanted_ = B_.squared_norm();
    for (int c = 0; c < 4; ++c) {
      if (!std::isfinite(start_[c]) || !std::isfinite(wanted_[c]))
        throw SolverError("the right-hand side or the first guess holds a value that is not finite");
      // A guess that is better than the tolerance asks for nothing more.
      wanted_[c] = options.tolerance * options.tolerance * (wanted_[c] > 0 ? wanted_[c] : start_[c]);
    }
  }

  bool converged(int c) const {
    return c >= channels_ || squared_[c] == 0 ||
           (cycles_ >= options_.least_cycles && !(squared_[c] > wanted_[c]) &&
            error_[c].within(options_.tolerance));
  }
  bool converged() const {
    return converged(0) && converged(1) && converged(2) && converged(3);
  }
  bool active(int c) const {
    return !converged(c) && lost_[c] < max_lost && idle_[c] < max_idle;
  }
  bool active() const { return active(0) || active(1) || active(2) || active(3); }

  /// Of the worst channel.
  double error() const {
    double worst = 0;
    for (int c = 0; c < channels_; ++c) worst = std::max(worst, error_[c].relative());
    return worst;
  }

  /// ‖r‖² / ‖r₀‖² of the worst channel.
  double ratio() const {
    double worst = 0;
    for (int c = 0; c < channels_; ++c)
      if (start_[c] > 0) worst = std::max(worst, squared_[c] / start_[c]);
    return worst;
  }

  void iterate() {
    multigrid_.cycle(r_.data(), z_.data(), workspace_);
    constants_.remove(z_);
    const Double4 descent = dot(z_, r_);
    Double4 beta{}, alpha{};
    for (int c = 0; c < 4; ++c) beta[c] = descent_[c] > 0 ? descent[c] / descent_[c] : 0;
    next_direction(z_, beta, p_);
    LaneVector& q = z_;
    const StencilMatrix::Products of_p = high_.multiply(lanes_, p_.data(), r_.data(), q.data());
    for (int c = 0; c < lanes_; ++c) alpha[c] = active(c) ? step(c, of_p.with_r[c], of_p.with_product[c]) : 0;
    if (lanes_ == 1) alpha = Double4{} + alpha[0];
    const LargestValues found = add_to_solution(scaling_, p_, alpha, first_, channels_, X_);
    for (int c = 0; c < channels_; ++c)
      if (alpha[c] != 0) error_[c].add_step(found.change[c], found.value[c]);
    for (int c = 0; c < 4; ++c) descent_[c] = alpha[c] != 0 ? descent[c] : 0;
    squared_ = reduce_residual(scaling_, q, alpha, r_);
    ++cycles_;
    if (needs_renewal()) renew();
  }

 private:
  /// ⟨p, r⟩/⟨p, A·p⟩; 0 where the quadratic form is lost in rounding (a direction along which the
  /// matrix nearly vanishes). The next direction is a new one; a channel that finds none rests.
  double step(int c, double descent, double form) {
    lost_[c] = form > 0 ? 0 : lost_[c] + 1;
    return form > 0 ? descent / form : 0;
  }

  bool needs_renewal() const {
    if (!active()) return true;
    for (int c = 0; c < channels_; ++c)
      if (!(squared_[c] > renew_below * renew_below * renewed_[c])) return true;
    return false;
  }

  /// r = B − A·X in double.
  void renew() {
    take_true_residual();
    constants_.remove(r_);
    squared_ = squared_norm(scaling_, r_);
    // Where rounding of X is what is left, the residual in single precision falls and the true one
    // does not.
    for (int c = 0; c < 4; ++c) idle_[c] = squared_[c] > renewed_[c] / 4 ? idle_[c] + 1 : 0;
    renewed_ = squared_;
  }

  void take_true_residual() {
    true_residual(high_, low_, B_, X_, first_, channels_, r_);
  }

  const StencilMatrix& high_;
  const StencilMatrix& low_;
  const Scaling& scaling_;
  const Multigrid& multigrid_;
  ComponentConstants constants_;
  Signal& X_;
  int first_, channels_;
  ScaledRightHandSide B_;
  int lanes_;
  Multigrid::Workspace workspace_;
  const MixedCgOptions& options_;
  LaneVector r_, z_, p_;
  Double4 squared_{}, renewed_{}, start_{}, wanted_{};
  Double4 descent_{};  ///< ⟨z, r⟩ of the last step, 0 where there was none
  std::array<int, 4> lost_ = {0, 0, 0, 0};
  std::array<ErrorEstimate, 4> error_;
  std::array<int, 4> idle_ = {0, 0, 0, 0};
  int cycles_ = 0;
};

}  // namespace

bool Components::any_singular() const {
  return std::find(singular.begin(), singular.end(), char(1)) != singular.end();
}

SolveReport mixed_conjugate_gradients(const StencilMatrix& high, const StencilMatrix& low,
                                      const Scaling& scaling, const Multigrid& multigrid,
                                      const Components& components, const Signal& B, Signal& X,
                                      const MixedCgOptions& options, const Progress& progress) {
  const auto start = Clock::now();
  SolveReport report;
  report.method = "multigrid";
  // x̂ = D⁻¹·x for the time of the solve; powers of two, so that nothing is lost on the way back.
  for (const WeightedIndex& row : scaling.special) X.row(row.index) *= double(row.weight);
  for (int first = 0; first < B.cols(); first += 4) {
    const int channels = std::min(4, int(B.cols()) - first);
    const double unit = unit_of(B, X, first, channels, scaling.common);
    multiply_columns(unit, first, channels, X);
    Group group(high, low, scaling, multigrid, components, B, X, first, unit, options);
    if (group.active() && report.residuals.empty()) report.residuals.push_back(1);
    int cycle = 0;
    while (group.active() && cycle < options.max_cycles) {
      group.iterate();
      ++cycle;
      const double ratio = std::sqrt(group.ratio());
      if (!std::isfinite(ratio)) throw SolverError("the multigrid cycle met a value that is not finite");
      if (ratio > diverged)
        throw SolverError(fmt::format(
            "multigrid diverges: after {} cycles the residual is {:.1e} times what it was", cycle, ratio));
      // Groups of channels run one after another; the worst of them counts.
      if (int(report.residuals.size()) <= cycle) report.residuals.push_back(0);
      report.residuals[cycle] = std::max(report.residuals[cycle], ratio);
      const double done =
          std::min(1.0, std::log(std::max(ratio, 1e-300)) / std::log(options.tolerance));
      progress.at((first + done * std::min(4.0, double(B.cols()) - first)) / double(B.cols()),
                  fmt::format("residual {:.0e}", ratio));
    }
    report.cycles = std::max(report.cycles, cycle);
    report.converged = report.converged && group.converged();
    report.error = std::max(report.error, group.error());
    multiply_columns(1 / unit, first, channels, X);
  }
  for (const WeightedIndex& row : scaling.special) X.row(row.index) /= double(row.weight);
  report.solve_seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return report;
}

}  // namespace mq
