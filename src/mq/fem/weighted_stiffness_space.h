#pragma once
/// A signal space on which gradients count more here and less there.

#include "mq/fem/space.h"

namespace mq {

/// The functions of another space, with S replaced by Σ_e c_e S_e: ∫ c ⟨∇φ_i, ∇φ_j⟩ dA for a
/// conductivity c ≥ 0 per element. M is the same. Whatever is written for signal spaces so learns
/// to stop at edges. Where c is 0 all around an unknown it is a component of its own.
class WeightedStiffnessSpace final : public SignalSpace {
 public:
  /// `space` must outlive it. Throws `InvalidInput` on a conductivity that is negative or not
  /// finite.
  WeightedStiffnessSpace(const SignalSpace& space, std::vector<float> conductivity);

  /// Takes another conductivity, refused as above. What was prepared with the one before has to be
  /// prepared again (`ScreenedPoisson::set_weight`).
  void set_conductivity(std::vector<float> conductivity);

  int size() const override { return space_.size(); }
  SparseMatrix system(double a, double b, const Progress& progress = {}) const override;
  Signal stiffness_times(const Signal& psi, std::span<const double> beta = {}) const override;
  /// Throws `Unsupported`: the space behind integrates it as a whole, without conductivities.
  Signal edge_divergence(const std::vector<std::array<int, 2>>& edges, const Signal& z) const override;
  Vector lumped_mass() const override { return space_.lumped_mass(); }
  SurfaceScale scale() const override { return space_.scale(); }
  std::vector<Vector3> positions() const override { return space_.positions(); }
  std::vector<int> boundary() const override { return space_.boundary(); }
  std::vector<BasisWeight> basis_at(int triangle, const Vector3& barycentric) const override {
    return space_.basis_at(triangle, barycentric);
  }
  double largest_shown(const Vector& values) const override { return space_.largest_shown(values); }
  SolverFactory multigrid(const StoppingRule& stop = {}) const override {
    return space_.multigrid(stop);
  }
  int element_count() const override { return space_.element_count(); }
  std::vector<float> gradient_norms(const Signal& psi) const override;
  Signal weighted_stiffness_times(const Signal& psi,
                                  std::span<const float> conductivity) const override;
  SparseMatrix weighted_system(double a, double b, std::span<const float> conductivity,
                               const Progress& progress = {}) const override;

  /// Throws `Unsupported`: elements are those of the space behind, without conductivities.
  void for_each_mixed_element(std::span<const int> labels,
                              const std::function<void(const Element&)>& visit) const override;

 private:
  std::vector<float> times(std::span<const float> conductivity) const;

  const SignalSpace& space_;
  std::vector<float> conductivity_;
};

}  // namespace mq
