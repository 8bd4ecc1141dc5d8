/// Per channel, with ρ = ⟨r, z⟩:
///
///     z = C⁻¹r,  β = ρ/ρ_before,  p = z + β·p,  α = ρ/⟨p, A·p⟩,  x += α·p,  r −= α·A·p
///
/// α and β are rows with one value per channel. A channel that has reached the tolerance rests
/// (α = β = 0) while the others go on, which keeps its quotients away from 0/0.

#include "mq/linear/conjugate_gradients.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/linear/residual.h"

namespace mq {

namespace {

using Row = Eigen::RowVectorXd;
using Clock = std::chrono::steady_clock;

/// The functions constant on each component, to be taken out of a residual.
class Constants {
 public:
  Constants(const std::vector<int>& component, std::int64_t size) : component_(component) {
    require(component.empty() || std::int64_t(component.size()) == size,
            fmt::format("{} components were given for {} unknowns", component.size(), size));
    for (const int c : component_) {
      if (c >= int(count_.size())) count_.resize(c + 1, 0);
      count_[c] += 1;
    }
  }

  bool any() const { return !component_.empty(); }

  /// Per component the mean over its unknowns, components × channels.
  Signal means(const Signal& X) const {
    Signal mean = Signal::Zero(Eigen::Index(count_.size()), X.cols());
    for (std::size_t i = 0; i < component_.size(); ++i) mean.row(component_[i]) += X.row(i);
    for (std::size_t c = 0; c < count_.size(); ++c) mean.row(c) /= std::max(count_[c], 1.0);
    return mean;
  }

  void subtract(Signal& X, const Signal& mean) const {
    if (!any()) return;
    parallel_for(X.rows(), [&](std::int64_t i) { X.row(i) -= mean.row(component_[i]); });
  }

  void remove(Signal& X) const {
    if (any()) subtract(X, means(X));
  }

 private:
  const std::vector<int>& component_;
  std::vector<double> count_;
};

/// numerator / denominator in the channels still active, 0 in those at rest.
Row quotient(const Row& numerator, const Row& denominator, const std::vector<bool>& active) {
  Row q = Row::Zero(numerator.size());
  for (Eigen::Index c = 0; c < q.size(); ++c)
    if (active[c]) q[c] = numerator[c] / denominator[c];
  return q;
}

void require_positive(const Row& form, const std::vector<bool>& active, const char* what,
                      int cycle) {
  for (Eigen::Index c = 0; c < form.size(); ++c)
    if (active[c] && !(form[c] > 0))
      throw NotPositiveDefinite(fmt::format(
          "{} is not positive definite: in cycle {} of conjugate gradients its quadratic form is "
          "{} in channel {}", what, cycle, form[c], c));
}

/// The channels above the tolerance.
std::vector<bool> active_channels(const Row& squared, const Row& start, double tolerance) {
  std::vector<bool> active(squared.size());
  for (Eigen::Index c = 0; c < squared.size(); ++c)
    active[c] = squared[c] > tolerance * tolerance * start[c];
  return active;
}

bool any(const std::vector<bool>& v) { return std::find(v.begin(), v.end(), true) != v.end(); }

/// How far a residual that falls geometrically has come towards the tolerance.
double fraction_done(double ratio, double tolerance) {
  return ratio > 0 && tolerance > 0 ? std::log(ratio) / std::log(tolerance) : 1;
}

void check_shapes(const SparseMatrix& A, const Signal& B, const Signal& X) {
  require(A.rows() == A.cols() && B.rows() == A.rows() && X.rows() == B.rows() &&
              X.cols() == B.cols(),
          fmt::format("a system of {} × {} was given a right-hand side of {} × {} and a first "
                      "guess of {} × {}", A.rows(), A.cols(), B.rows(), B.cols(), X.rows(),
                      X.cols()));
}

}  // namespace

Preconditioner jacobi_preconditioner(const SparseMatrix& A) {
  const Vector diagonal = A.diagonal();
  for (Eigen::Index i = 0; i < diagonal.size(); ++i)
    if (!(diagonal[i] > 0))
      throw NotPositiveDefinite(fmt::format("the matrix is not positive definite: its diagonal "
                                            "is {} in row {}", diagonal[i], i));
  return [inverse = Vector(diagonal.cwiseInverse())](const Signal& R, Signal& Z) {
    Z.resize(R.rows(), R.cols());
    parallel_for(R.rows(), [&](std::int64_t i) { Z.row(i) = inverse[i] * R.row(i); });
  };
}

SolveReport conjugate_gradients(const SparseMatrix& A, const Signal& B, Signal& X,
                                const Preconditioner& precondition,
                                const ConjugateGradientOptions& options,
                                const Progress& progress) {
  const auto clock_start = Clock::now();
  check_shapes(A, B, X);
  const Constants constants(options.components, A.rows());
  const Signal kept = constants.means(X);

  Signal R = residual(A, X, B);
  constants.remove(R);
  const Row start = channel_dots(R, R);
  if (!start.allFinite())
    throw SolverError("the right-hand side or the first guess holds a value that is not finite");

  SolveReport report;
  report.method = "conjugate gradients";
  std::vector<bool> active = active_channels(start, start, options.tolerance);
  if (any(active)) report.residuals.push_back(1);
  Signal Z, AP, P = Signal::Zero(B.rows(), B.cols());
  Row rho_before = Row::Ones(B.cols());
  while (any(active) && report.cycles < options.max_cycles) {
    precondition(R, Z);
    const Row rho = channel_dots(R, Z);
    require_positive(rho, active, "the preconditioner", report.cycles);
    const Row beta =
        report.cycles == 0 ? Row::Zero(B.cols()).eval() : quotient(rho, rho_before, active);
    add_scaled(Z, P, beta);
    P.swap(Z);
    multiply(A, P, AP);
    const Row form = channel_dots(P, AP);
    require_positive(form, active, "the matrix", report.cycles);
    const Row alpha = quotient(rho, form, active);
    add_scaled(X, P, alpha);
    add_scaled(R, AP, -alpha);
    constants.remove(R);
    const Row squared = channel_dots(R, R);
    if (!squared.allFinite()) throw SolverError("conjugate gradients met a value that is not finite");
    active = active_channels(squared, start, options.tolerance);
    rho_before = rho;
    report.cycles += 1;
    report.residuals.push_back(worst_ratio(squared, start));
    progress.at(fraction_done(report.residuals.back(), options.tolerance));
  }

  report.converged = !any(active);
  if (report.cycles > 0) {
    if (constants.any()) constants.subtract(X, constants.means(X) - kept);
    Signal last = residual(A, X, B);
    constants.remove(last);
    report.residuals.back() = worst_ratio(channel_dots(last, last), start);
  }
  report.solve_seconds = std::chrono::duration<double>(Clock::now() - clock_start).count();
  return report;
}

namespace {

class JacobiConjugateGradients final : public LinearSolver {
 public:
  JacobiConjugateGradients(const SparseMatrix& A, ConjugateGradientOptions options)
      : options_(std::move(options)) {
    update(A, {});
  }

  SolveReport solve(const Signal& B, Signal& X, const Progress& progress) const override {
    return conjugate_gradients(A_, B, X, precondition_, options_, progress);
  }

  void update(const SparseMatrix& A, const Progress&) override {
    precondition_ = jacobi_preconditioner(A);
    A_ = A;
  }

 private:
  ConjugateGradientOptions options_;
  SparseMatrix A_;
  Preconditioner precondition_;
};

}  // namespace

SolverFactory conjugate_gradient_solver(ConjugateGradientOptions options) {
  return [options](const SparseMatrix& A, const Progress&) -> std::unique_ptr<LinearSolver> {
    return std::make_unique<JacobiConjugateGradients>(A, options);
  };
}

}  // namespace mq
