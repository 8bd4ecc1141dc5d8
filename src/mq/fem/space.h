#pragma once
/// What every application is written against: a basis of functions on a domain with a metric.

#include "mq/base/length.h"
#include "mq/linear/matrix.h"

namespace mq {

/// A signal space {φ_i}: partition of unity (Σφ_i = 1), so constants are reproduced and S·1 = 0.
class SignalSpace {
 public:
  virtual ~SignalSpace() = default;

  /// Number of unknowns.
  virtual int size() const = 0;

  /// M_ij = ∫ φ_i φ_j dA, symmetric positive definite, model units squared. Σ_ij M_ij = area.
  virtual SparseMatrix mass() const = 0;

  /// S_ij = ∫ ⟨∇φ_i, ∇φ_j⟩ dA, symmetric positive semidefinite, no unit. Null space: constants,
  /// per connected component.
  virtual SparseMatrix stiffness() const = 0;

  /// Area and texel spacing, for turning lengths into weights.
  virtual SurfaceScale scale() const = 0;
};

}  // namespace mq
