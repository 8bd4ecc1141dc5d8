#pragma once
/// The screened Poisson equation: keep the values, change the gradients.

#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "mq/base/length.h"
#include "mq/base/progress.h"
#include "mq/fem/space.h"
#include "mq/linear/solver.h"

namespace mq {

/// The moments ∫ (β − 1) ⟨∇ψ, ∇φ_i⟩ dA, size() × channels: how (5.1) wants ψ's gradient changed. One β for all unknowns, or
/// one per unknown (constant on each triangle or cell: the mean over its unknowns); one that is equal everywhere gives the
/// same bits either way. Throws `InvalidInput` naming the first value that is not finite.
Signal gradient_change(const SignalSpace& space, const Signal& psi, std::span<const double> beta);

/// A filtered signal and how its solve went.
struct Filtered {
  Signal signal;
  SolveReport report;
};

/// Minimises, over the signals φ of a space and for each channel alone,
///
///     E(φ) = ∫ (φ − ψ)² dA + w ∫ |∇φ − β∇ψ|² dA,          (M + w·S)·φ = M·ψ + w·S_β·ψ,
///
/// with S_β·ψ = ∫ β ⟨∇ψ, ∇φ_i⟩ dA. The weight w is a length squared in model units: alpha · area
/// for the thesis' alpha, see `weight_from_length`. An eigenfunction of the Laplacian with
/// eigenvalue λ (wave length 2π/√λ) comes out times the
///
///     gain  (1 + β·w·λ) / (1 + w·λ):
///
/// from 1 for slow changes to β for fast ones, half-way at wave length 2π·√w. β = 0 smooths,
/// β > 1 sharpens, β = 1 changes nothing.
///
/// What is solved is the correction, φ = ψ + (M + w·S)⁻¹ w·S_{β−1}·ψ. So β = 1 gives ψ back bit for
/// bit, ψ is the first guess of an iterative solver, and, as the right-hand side sums to 0, the mean
/// ∫φ dA of each connected component is that of ψ to the accuracy of the solve, and to rounding where
/// w is more than a hundredth of the area, as then a small residual would allow a large error in it.
///
/// w = ∞ is allowed: only gradients count, S·φ = S_β·ψ, each component keeping its mean. It is
/// solved as S·δ + D·δ = S_{β−1}·ψ with D = 10⁻⁸/(area of the component) · (lumped mass), a weight
/// of 10⁸ areas of the component, and the mean of δ taken out. That changes an eigenfunction by
/// 10⁻⁸/(λ · area): 4·10⁻¹⁰ of the slowest one on a sphere, 10⁻⁷ on a tube 100 times as long as wide.
/// A weight of 10⁸ areas or more is solved in the same way.
///
/// Where a factorisation finds the matrix not positive definite, which rounding brings about on
/// surfaces with triangles of nearly no area, the diagonal is raised by 10⁻¹², then up to 10⁻⁹, of
/// itself, and the report's `method` says so; means are then kept as for w = ∞.
///
/// With a screen s_i ≥ 0 per unknown, values are kept where it is positive and filled in, as the
/// gradients ask, where it is 0: M is replaced by the diagonal s_i·m_i, m the lumped mass (s_i below
/// 10⁻⁸ counts as 10⁻⁸), and what is kept of a component is Σ s_i m_i φ_i. w must be finite.
///
/// [bhat2010gradientshop] on images; thesis 5.2, equations (5.1), (5.8), (5.11), and 5.9.1;
/// [prada2018gradient]. There the surface is scaled to unit area, and the sign of ∇·X in (5.5) is
/// wrong.
class ScreenedPoisson {
 public:
  static constexpr double infinite_weight = std::numeric_limits<double>::infinity();

  /// Assembles and prepares the solver: the space's own (`SignalSpace::solver`) where the factory is
  /// empty. `space` must outlive the object. Throws `InvalidInput` on a
  /// weight that is negative or NaN, and what the factory throws.
  ScreenedPoisson(const SignalSpace& space, double weight, const SolverFactory& factory = {},
                  const Progress& progress = {});

  /// The same with a screen, one value per unknown; negative, infinite and NaN ones are refused.
  ScreenedPoisson(const SignalSpace& space, double weight, std::vector<double> screen,
                  const SolverFactory& factory = {}, const Progress& progress = {});

  /// Prepares for another weight, keeping what the solver can (the analysis of the pattern). When it
  /// throws, only another `set_weight` that succeeds makes the object usable again.
  void set_weight(double weight, const Progress& progress = {});

  double weight() const { return weight_; }

  /// φ for one β everywhere. ψ is size() × channels; throws `InvalidInput` naming the first value
  /// that is not finite.
  Filtered solve(const Signal& psi, double beta, const Progress& progress = {}) const;

  /// φ for `gradient_change` by these β.
  Filtered solve(const Signal& psi, std::span<const double> beta,
                 const Progress& progress = {}) const;

  /// φ − ψ for the moments of any change of ψ's gradient, as `gradient_change` has them: what only those need, the space
  /// among it, may be gone by then. Where the change is 0 altogether so is φ − ψ.
  Filtered correction(Signal gradient_change, const Progress& progress = {}) const;

  /// φ for any target gradient X, given by its moments ∫ ⟨X, ∇φ_i⟩ dA, size() × channels.
  Filtered solve_towards(const Signal& psi, const Signal& gradient_moments,
                         const Progress& progress = {}) const;

  /// φ for a change of ψ's gradient, by its moments: `solve_towards` with these added to S·ψ. Where
  /// they are 0 altogether ψ comes back bit for bit.
  Filtered solve_change(const Signal& psi, const Signal& gradient_change,
                        const Progress& progress = {}) const;

 private:
  /// The connected components of the system, where means must be kept by hand; else none.
  struct Components {
    int count = 0;
    std::vector<int> number;  ///< per unknown
    Vector share;             ///< per unknown its lumped mass over that of its component
    Components() = default;
    Components(const SparseMatrix& A, const Vector& mass);
    void remove_means(Signal& values) const;
  };

  Vector screened_mass() const;
  double prepare(SparseMatrix& A, const Progress& progress);
  bool prepare_stencils(double weight, const Progress& assembling, const Progress& progress);
  Filtered correct(const Signal& psi, Signal gradient_change, const Progress& progress) const;

  const SignalSpace& space_;
  double weight_ = 0;
  std::vector<double> screen_;  ///< empty: the mass itself
  SolverFactory factory_;
  std::unique_ptr<LinearSolver> solver_;
  double shift_ = 0;  ///< of the diagonal, relative
  Components components_;
};

/// β = 0 with w = length²: details smaller than about 2π·length fade.
Filtered smooth(const SignalSpace& space, const Signal& signal, const Length& length,
                const SolverFactory& factory = {}, const Progress& progress = {});

/// β > 1 with w = length²: details smaller than about 2π·length are amplified by up to β.
Filtered sharpen(const SignalSpace& space, const Signal& signal, const Length& length, double beta,
                 const SolverFactory& factory = {}, const Progress& progress = {});

}  // namespace mq
