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
#include "mq/linear/error_estimate.h"
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

/// Sums over the rows of all processes.
Row summed_dots(const SharedSystem& system, const Signal& X, const Signal& Y) {
  Row dots = channel_dots(X, Y);
  if (system.sum) system.sum(std::span(dots.data(), std::size_t(dots.size())));
  return dots;
}

/// Per channel how far X is from its limit, by the steps it takes.
class Errors {
 public:
  explicit Errors(Eigen::Index channels) : of_channel_(std::size_t(channels)) {}

  /// After X += α·P.
  void add_step(const SharedSystem& system, const Signal& P, const Row& alpha, const Signal& X) {
    Row found(2 * alpha.size());
    for (Eigen::Index c = 0; c < alpha.size(); ++c) {
      found[c] = P.rows() > 0 ? std::abs(alpha[c]) * P.col(c).cwiseAbs().maxCoeff() : 0;
      found[alpha.size() + c] = X.rows() > 0 ? X.col(c).cwiseAbs().maxCoeff() : 0;
    }
    if (system.largest) system.largest(std::span(found.data(), std::size_t(found.size())));
    for (Eigen::Index c = 0; c < alpha.size(); ++c)
      if (alpha[c] != 0) of_channel_[std::size_t(c)].add_step(found[c], found[alpha.size() + c]);
  }

  bool within(Eigen::Index channel, double tolerance) const {
    return of_channel_[std::size_t(channel)].within(tolerance);
  }

  double largest() const {
    double worst = 0;
    for (const ErrorEstimate& one : of_channel_) worst = std::max(worst, one.relative());
    return worst;
  }

 private:
  std::vector<ErrorEstimate> of_channel_;
};

/// The channels above the tolerance.
std::vector<bool> active_channels(const Row& squared, const Row& start, const Errors& errors,
                                  const ConjugateGradientOptions& options) {
  std::vector<bool> active(squared.size());
  for (Eigen::Index c = 0; c < squared.size(); ++c)
    active[c] = squared[c] > options.tolerance * options.tolerance * start[c] ||
                (options.stop == ConjugateGradientOptions::Stop::residual_error && squared[c] > 0 &&
                 !errors.within(c, options.tolerance));
  return active;
}

bool any(const std::vector<bool>& v) { return std::find(v.begin(), v.end(), true) != v.end(); }

/// How far a residual that falls geometrically has come towards the tolerance.
double fraction_done(double ratio, double tolerance) {
  return ratio > 0 && tolerance > 0 ? std::log(ratio) / std::log(tolerance) : 1;
}

void check_shapes(std::int64_t rows, std::int64_t columns, const Signal& B, const Signal& X) {
  require(rows == columns && B.rows() == rows && X.rows() == B.rows() && X.cols() == B.cols(),
          fmt::format("a system of {} × {} was given a right-hand side of {} × {} and a first "
                      "guess of {} × {}", rows, columns, B.rows(), B.cols(), X.rows(), X.cols()));
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

namespace {

/// B − A·X.
Signal residual_of(const SharedSystem& system, const Signal& X, const Signal& B) {
  Signal R;
  system.multiply(X, R);
  parallel_for(R.rows(), [&](std::int64_t i) { R.row(i) = B.row(i) - R.row(i); });
  return R;
}

}  // namespace

SolveReport conjugate_gradients(const SparseMatrix& A, const Signal& B, Signal& X,
                                const Preconditioner& precondition,
                                const ConjugateGradientOptions& options,
                                const Progress& progress) {
  check_shapes(A.rows(), A.cols(), B, X);
  return conjugate_gradients(
      SharedSystem{.multiply = [&](const Signal& of, Signal& product) { multiply(A, of, product); }}, B, X,
      precondition, options, progress);
}

SolveReport conjugate_gradients(const SharedSystem& system, const Signal& B, Signal& X,
                                const Preconditioner& precondition,
                                const ConjugateGradientOptions& options,
                                const Progress& progress) {
  const auto clock_start = Clock::now();
  check_shapes(B.rows(), B.rows(), B, X);
  require(options.components.empty() || !system.sum, "components of a system that processes share are not known");
  const Constants constants(options.components, B.rows());
  const Signal kept = constants.means(X);

  Signal R = residual_of(system, X, B);
  constants.remove(R);
  Errors errors(B.cols());
  const Row start = summed_dots(system, R, R);
  if (!start.allFinite())
    throw SolverError("the right-hand side or the first guess holds a value that is not finite");

  SolveReport report;
  report.method = "conjugate gradients";
  std::vector<bool> active = active_channels(start, start, errors, options);
  if (any(active)) report.residuals.push_back(1);
  Signal Z, AP, P = Signal::Zero(B.rows(), B.cols());
  Row rho_before = Row::Ones(B.cols());
  while (any(active) && report.cycles < options.max_cycles) {
    precondition(R, Z);
    const Row rho = summed_dots(system, R, Z);
    require_positive(rho, active, "the preconditioner", report.cycles);
    const Row beta =
        report.cycles == 0 ? Row::Zero(B.cols()).eval() : quotient(rho, rho_before, active);
    add_scaled(Z, P, beta);
    P.swap(Z);
    system.multiply(P, AP);
    const Row form = summed_dots(system, P, AP);
    require_positive(form, active, "the matrix", report.cycles);
    const Row alpha = quotient(rho, form, active);
    add_scaled(X, P, alpha);
    if (options.stop == ConjugateGradientOptions::Stop::residual_error) errors.add_step(system, P, alpha, X);
    add_scaled(R, AP, -alpha);
    constants.remove(R);
    const Row squared = summed_dots(system, R, R);
    if (!squared.allFinite()) throw SolverError("conjugate gradients met a value that is not finite");
    active = active_channels(squared, start, errors, options);
    rho_before = rho;
    report.cycles += 1;
    report.residuals.push_back(worst_ratio(squared, start));
    progress.at(fraction_done(report.residuals.back(), options.tolerance));
  }

  report.converged = !any(active);
  report.error = errors.largest();
  if (report.cycles > 0) {
    if (constants.any()) constants.subtract(X, constants.means(X) - kept);
    Signal last = residual_of(system, X, B);
    constants.remove(last);
    report.residuals.back() = worst_ratio(summed_dots(system, last, last), start);
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
