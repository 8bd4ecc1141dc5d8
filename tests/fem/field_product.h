#pragma once
/// ∫ ⟨X, Y⟩ dA of fields with a vector per triangle.

#include "mq/fem/tangent_fields.h"
#include "mq/mesh/geometry.h"

namespace mq::fixtures {

inline double product(const Surface& surface, const TangentField& X, const TangentField& Y) {
  double sum = 0;
  for (int t = 0; t < surface.triangle_count(); ++t) sum += triangle_area(surface.mesh, t) * X[t].dot(Y[t]);
  return sum;
}

}  // namespace mq::fixtures
