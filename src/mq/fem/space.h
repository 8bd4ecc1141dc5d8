#pragma once
/// What every application is written against: a basis of functions on a domain with a metric.

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "mq/base/length.h"
#include "mq/base/progress.h"
#include "mq/linear/matrix.h"
#include "mq/linear/solver.h"
#include "mq/mesh/mesh.h"

namespace mq {

/// A part of the domain on which the stiffness is integrated by itself: a triangle, or the part of a
/// cell between texels that lies inside charts or near a seam.
struct Element {
  std::span<const int> own;       ///< unknowns at its corners; none: a piece of a soft seam
  std::span<const int> unknowns;  ///< all it couples: its own and, at seams, those opposite
  std::span<const double>
      stiffness;  ///< ∫ ⟨∇φ_i, ∇φ_j⟩ over it, row by row; positive semidefinite,
                  ///< vanishing on constants; S is the sum over all elements
};

/// An unknown and the value of its basis function somewhere.
struct BasisWeight {
  int unknown;
  double weight;
};

/// Up to so many unknowns a factorisation is faster than multigrid and needs no more memory than
/// there is; what `SignalSpace::solver` goes by.
inline constexpr int most_for_factorisation = 30'000;

/// A signal space {φ_i}: partition of unity (Σφ_i = 1), so constants are reproduced and S·1 = 0.
///
///     M_ij = ∫ φ_i φ_j dA          symmetric positive definite, model units squared; ΣM_ij = area
///     S_ij = ∫ ⟨∇φ_i, ∇φ_j⟩ dA     symmetric positive semidefinite, no unit;
///                                  null space: constants, per connected component
class SignalSpace {
 public:
  virtual ~SignalSpace() = default;

  /// Number of unknowns.
  virtual int size() const = 0;

  /// a·M + b·S, assembled in one pass; the pattern is that of M and S whatever a and b are.
  virtual SparseMatrix system(double a, double b, const Progress& progress = {}) const = 0;

  /// What to solve with in place of a·M + b·S: the same, plus a trace of smoothness that determines
  /// what no point of the domain shows and the equations would leave arbitrary. Constants stay in
  /// the null space of the addition.
  virtual SparseMatrix regularised_system(double a, double b, const Progress& progress = {}) const {
    return system(a, b, progress);
  }

  /// `regularised_system(a, b)` without a compressed row for each unknown, where most rows are 3 × 3 stencils; else
  /// nothing. Half the memory, for a solver that `takes_stencils`.
  virtual std::optional<StencilSystem> stencil_system(double, double, const Progress& = {}) const { return {}; }

  /// S·ψ, or with a modulation β (one value per unknown, constant on each cell or triangle: the
  /// mean over its unknowns) the vector ∫ β ⟨∇ψ, ∇φ_i⟩ dA. Sums to 0 per channel. No matrix is
  /// built.
  virtual Signal stiffness_times(const Signal& psi, std::span<const double> beta = {}) const = 0;

  /// b_t = ∫ ⟨ω, ∇φ_t⟩ dA of the field of least order that changes by z_ij from unknown i to unknown j,
  /// ω = Σ z_ij (φ_i ∇φ_j − φ_j ∇φ_i) over pairs (i, j), i < j, sorted, that S couples; the z of others is 0
  /// (thesis 5.6 and (5.14), with the sign of z_ij = ψ_j − ψ_i, for which b = S·ψ where all pairs are
  /// given). One row of z per pair, one column per channel. Sums to 0 per channel. A look at every element.
  virtual Signal edge_divergence(const std::vector<std::array<int, 2>>& edges, const Signal& z) const = 0;

  /// Area and texel spacing, for turning lengths into weights.
  virtual SurfaceScale scale() const = 0;

  /// Where the unknowns lie, one position each, model units.
  virtual std::vector<Vector3> positions() const = 0;

  /// Ascending: the unknowns whose functions do not vanish on the boundary of the domain.
  virtual std::vector<int> boundary() const = 0;

  /// Basis functions that do not vanish at a point of a triangle of the surface, which must take part
  /// in the space. On an edge both triangles give the same.
  virtual std::vector<BasisWeight> basis_at(int triangle, const Vector3& barycentric) const = 0;

  /// The largest value ≥ 0 that the domain shows of a signal of one channel; unknowns that are not
  /// finite do not count. An unknown beside the domain may be larger.
  virtual double largest_shown(const Vector& values) const = 0;

  /// The elements e that the domain is cut into for what is not linear in a signal: triangles, or
  /// cells of a texture and strips along its seams. S = Σ_e S_e with S_e·1 = 0.
  virtual int element_count() const = 0;

  /// Per element √(Σ ψᵀS_eψ / area_e), summed over channels: the root mean square of |∇ψ| on it; 0
  /// where it has no area.
  virtual std::vector<float> gradient_norms(const Signal& psi) const = 0;

  /// Σ_e c_e·S_e·ψ for a conductivity per element: ∫ c ⟨∇ψ, ∇φ_i⟩ dA. Sums to 0 per channel.
  virtual Signal weighted_stiffness_times(const Signal& psi,
                                          std::span<const float> conductivity) const = 0;

  /// a·M + b·Σ_e c_e·S_e, c_e ≥ 0, with what `regularised_system` adds.
  virtual SparseMatrix weighted_system(double a, double b, std::span<const float> conductivity,
                                       const Progress& progress = {}) const = 0;

  /// Calls visit(element) for those elements whose unknowns do not all have the same label (one per
  /// unknown), in a fixed order, on the calling thread. One look at every element.
  virtual void for_each_mixed_element(std::span<const int> labels,
                                      const std::function<void(const Element&)>& visit) const = 0;

  /// Conjugate gradients around a multigrid cycle made for this space, which must outlive the
  /// factory; solves a·M + b·S and `weighted_system`.
  virtual SolverFactory multigrid(const StoppingRule& stop = {}) const = 0;

  /// The solver to take where nothing speaks for another: a factorisation up to
  /// `most_for_factorisation` unknowns, `multigrid` above and where factors would fill up.
  SolverFactory solver(const StoppingRule& stop = {}) const;

  /// M·1 = ∫ φ_i dA, which sums to the area. Next to seams a value may be a little below 0.
  virtual Vector lumped_mass() const { return mass() * Vector::Ones(size()); }

  SparseMatrix mass() const { return system(1, 0); }
  SparseMatrix stiffness() const { return system(0, 1); }
};

/// The one that was given, or the space's own where that is empty.
SolverFactory solver_or_own(const SolverFactory& given, const SignalSpace& space);

}  // namespace mq
