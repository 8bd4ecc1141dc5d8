/// (M + w·S)·δ = w·(b − S·ψ),  φ = ψ + δ,  with b = S_β·ψ or the moments of any target gradient.
///
/// The thesis solves for φ. Solving for the change δ costs the same, and whatever asks for no
/// change gets none: the right-hand side is 0 exactly, and the solver is not called.

#include "mq/filter/screened_poisson.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/filter/vanishing_screen.h"
#include "mq/linear/connected_components.h"
#include "mq/linear/signal_values.h"

namespace mq {

namespace {

/// In areas: from here on an error of the solver in the constants of a component, which the
/// residual shows little of, could be one that 16 bits show.
constexpr double large_weight = 0.01;

/// The least that a screen given per unknown counts as.
constexpr double least_screen = 1e-8;

/// What is added to the diagonal of A so that constants are not quite in its null space; shares are
/// of the areas of components.
Vector vanishing(const SparseMatrix& A, const std::vector<int>& component, Vector share) {
  const Signal trace = component_sums(component, Vector(A.diagonal()));
  for (Eigen::Index i = 0; i < share.size(); ++i) share[i] = vanishing_screen(share[i], trace(component[i], 0));
  return share;
}

void require_finite(const Signal& signal, int rows, const char* what) {
  require(signal.rows() == rows,
          fmt::format("{} has {} rows, and the space has {} unknowns", what, signal.rows(), rows));
  if (is_finite(signal)) return;
  for (Eigen::Index i = 0; i < signal.rows(); ++i)
    for (Eigen::Index c = 0; c < signal.cols(); ++c)
      require(std::isfinite(signal(i, c)),
              fmt::format("{} holds {} at unknown {}, channel {}; values must be finite", what,
                          signal(i, c), i, c));
}

}  // namespace

Signal gradient_change(const SignalSpace& space, const Signal& psi, std::span<const double> beta) {
  require_finite(psi, space.size(), "the signal");
  require(beta.size() == 1 || beta.size() == std::size_t(space.size()),
          fmt::format("a modulation of {} values was given for {} unknowns", beta.size(), space.size()));
  for (std::size_t i = 0; i < beta.size(); ++i)
    if (!std::isfinite(beta[i]))
      throw InvalidInput(beta.size() == 1
                             ? fmt::format("beta is {}; it must be finite", beta[i])
                             : fmt::format("the modulation is {} at unknown {}; it must be finite", beta[i], i));
  if (beta.empty()) return zero_signal(psi.rows(), psi.cols());
  std::vector<double> change;
  if (std::ranges::any_of(beta, [&](double b) { return b != beta.front(); }))
    for (const double b : beta) change.push_back(b - 1);
  else if (beta.front() == 1)
    return zero_signal(psi.rows(), psi.cols());
  Signal moments = space.stiffness_times(psi, change);
  if (change.empty()) scale(beta.front() - 1, moments);
  return moments;
}

ScreenedPoisson::Components::Components(const SparseMatrix& A, const Vector& mass)
    : number(connected_components(A)), share(mass) {
  const Signal area = component_sums(number, mass);
  for (Eigen::Index i = 0; i < share.size(); ++i) share[i] /= area(number[i], 0);
  count = int(area.rows());
}

void ScreenedPoisson::Components::remove_means(Signal& values) const {
  if (count == 0) return;
  const Signal mean = component_sums(number, share.asDiagonal() * values);
  for (Eigen::Index i = 0; i < values.rows(); ++i) values.row(i) -= mean.row(number[i]);
}

ScreenedPoisson::ScreenedPoisson(const SignalSpace& space, double weight,
                                 const SolverFactory& factory,
                                 const Progress& progress)
    : space_(space), factory_(solver_or_own(factory, space)) {
  set_weight(weight, progress);
}

ScreenedPoisson::ScreenedPoisson(const SignalSpace& space, double weight,
                                 std::vector<double> screen,
                                 const SolverFactory& factory,
                                 const Progress& progress)
    : space_(space), screen_(std::move(screen)), factory_(solver_or_own(factory, space)) {
  require(
      screen_.size() == std::size_t(space.size()),
      fmt::format("a screen of {} values was given for {} unknowns", screen_.size(), space.size()));
  for (double& s : screen_) {
    if (!(s >= 0 && std::isfinite(s)))
      throw InvalidInput(fmt::format("a screen holds {}; it must be 0 or more, and finite", s));
    s = std::max(s, least_screen);
  }
  set_weight(weight, progress);
}

/// s_i m_i, or the lumped mass. A function that hardly meets the surface, next to a seam, may have
/// an integral a little below 0.
Vector ScreenedPoisson::screened_mass() const {
  Vector mass = space_.lumped_mass();
  if (!screen_.empty()) mass = mass.cwiseMax(1e-12 * mass.mean());
  for (std::size_t i = 0; i < screen_.size(); ++i) mass[Eigen::Index(i)] *= screen_[i];
  return mass;
}

void ScreenedPoisson::set_weight(double weight, const Progress& progress) {
  require(weight >= 0, fmt::format("the weight of a screened Poisson equation is {}; it must be 0 "
                                   "or more, or infinite",
                                   weight));
  const Progress assembling = progress.step("assemble", 0.2);
  // Beyond, the matrix would hold nothing of M but rounding.
  if (screen_.empty() && weight * vanishing_weight >= space_.scale().area) weight = infinite_weight;
  const bool finite = std::isfinite(weight), screened = !screen_.empty();
  require(finite || !screened, "a screened Poisson equation with a screen needs a finite weight");
  const bool keeps_means = finite && !screened && weight <= large_weight * space_.scale().area;
  if (keeps_means && prepare_stencils(weight, assembling, progress)) return;
  SparseMatrix A =
      space_.regularised_system(finite && !screened ? 1 : 0, finite ? weight : 1, assembling);
  if (screened) A.diagonal() += screened_mass();
  Components components;
  if (!finite) {
    components = Components(A, screened_mass());
    A.diagonal() += vanishing(A, components.number, components.share);
  } else if (screened || weight > large_weight * space_.scale().area) {
    // A·1 = M·1, of which a large weight leaves nothing.
    const bool lost = weight > 10 * space_.scale().area;
    components = Components(A, lost ? screened_mass() : Vector(A * Vector::Ones(space_.size())));
  }
  const double shift = prepare(A, progress.step("prepare", 0.8));
  if (shift > 0 && components.count == 0) components = Components(A, screened_mass());
  weight_ = weight;
  shift_ = shift;
  components_ = std::move(components);
}

/// Whether it could be done without compressed rows.
bool ScreenedPoisson::prepare_stencils(double weight, const Progress& assembling, const Progress& progress) {
  if (!factory_.takes_stencils()) return false;
  std::optional<StencilSystem> A = space_.stencil_system(1, weight, assembling);
  if (!A) return false;
  const Progress preparing = progress.step("prepare", 0.8);
  try {
    if (solver_)
      solver_->take(std::move(*A), preparing);
    else
      solver_ = factory_(std::move(*A), preparing);
  } catch (const NotPositiveDefinite&) {
    return false;
  }
  weight_ = weight, shift_ = 0, components_ = {};
  return true;
}

double ScreenedPoisson::prepare(SparseMatrix& A, const Progress& progress) {
  double shift = 0;
  for (const double next : {1e-12, 1e-11, 1e-10, 1e-9, 0.0}) {
    try {
      if (solver_)
        solver_->update(A, progress);
      else
        solver_ = factory_(A, progress);
      break;
    } catch (const NotPositiveDefinite&) {
      if (next == 0) throw;
      A.diagonal() *= (1 + next) / (1 + shift);
      shift = next;
    }
  }
  return shift;
}

Filtered ScreenedPoisson::correction(Signal gradient_change, const Progress& progress) const {
  Signal correction = zero_signal(gradient_change.rows(), gradient_change.cols());
  if (is_zero(gradient_change) || weight_ == 0) return {std::move(correction), nothing_to_solve()};
  if (std::isfinite(weight_)) scale(weight_, gradient_change);
  SolveReport report = solver_->solve(gradient_change, correction, progress);
  components_.remove_means(correction);
  if (shift_ > 0) report.method += fmt::format(", diagonal raised by {:g} of itself", shift_);
  return {std::move(correction), std::move(report)};
}

/// ψ itself, bit for bit, where nothing is to change.
Filtered ScreenedPoisson::correct(const Signal& psi, Signal gradient_change,
                                  const Progress& progress) const {
  if (is_zero(gradient_change) || weight_ == 0) return {psi, nothing_to_solve()};
  Filtered found = correction(std::move(gradient_change), progress);
  add(psi, found.signal);
  return found;
}

Filtered ScreenedPoisson::solve(const Signal& psi, double beta, const Progress& progress) const {
  return solve(psi, std::span(&beta, 1), progress);
}

Filtered ScreenedPoisson::solve(const Signal& psi, std::span<const double> beta,
                                const Progress& progress) const {
  return correct(psi, gradient_change(space_, psi, beta), progress);
}

Filtered ScreenedPoisson::solve_towards(const Signal& psi, const Signal& gradient_moments,
                                        const Progress& progress) const {
  require_finite(psi, space_.size(), "the signal");
  require_finite(gradient_moments, space_.size(), "the target gradient");
  require(gradient_moments.cols() == psi.cols(),
          fmt::format("the target gradient has {} channels, and the signal {}",
                      gradient_moments.cols(), psi.cols()));
  return correct(psi, gradient_moments - space_.stiffness_times(psi), progress);
}

Filtered ScreenedPoisson::solve_change(const Signal& psi, const Signal& gradient_change,
                                       const Progress& progress) const {
  require_finite(psi, space_.size(), "the signal");
  require_finite(gradient_change, space_.size(), "the change of the gradient");
  require(gradient_change.cols() == psi.cols(),
          fmt::format("the change of the gradient has {} channels, and the signal {}",
                      gradient_change.cols(), psi.cols()));
  return correct(psi, gradient_change, progress);
}

Filtered smooth(const SignalSpace& space, const Signal& signal, const Length& length,
                const SolverFactory& factory, const Progress& progress) {
  return sharpen(space, signal, length, 0, factory, progress);
}

Filtered sharpen(const SignalSpace& space, const Signal& signal, const Length& length, double beta,
                 const SolverFactory& factory, const Progress& progress) {
  const double weight = weight_from_length(length, space.scale());
  const ScreenedPoisson equation(space, weight, factory, progress.step("prepare", 0.8));
  return equation.solve(signal, beta, progress.step("solve", 0.2));
}

}  // namespace mq
