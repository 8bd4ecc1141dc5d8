#pragma once
/// Lengths that neither overflow nor underflow, and that are a function of the vector alone:
/// Eigen's `stableNorm` sums in an order that depends on where the vector lies in memory.

#include "mq/mesh/mesh.h"

namespace mq {

/// |v|, for any finite v.
inline double safe_norm(const Vector3& v) {
  const double scale = v.cwiseAbs().maxCoeff();
  return scale > 0 ? scale * (v / scale).norm() : 0;
}

/// v / |v|; 0 for 0.
inline Vector3 safe_unit(const Vector3& v) {
  const double scale = v.cwiseAbs().maxCoeff();
  return scale > 0 ? Vector3((v / scale).normalized()) : Vector3(Vector3::Zero());
}

}  // namespace mq
