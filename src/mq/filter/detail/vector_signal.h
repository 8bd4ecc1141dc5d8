#pragma once
/// Vectors at vertices as a signal of three channels.

#include <span>

#include "mq/linear/matrix.h"
#include "mq/mesh/mesh.h"

namespace mq {

inline Signal as_signal(std::span<const Vector3> vectors) {
  Signal signal(Eigen::Index(vectors.size()), 3);
  for (std::size_t v = 0; v < vectors.size(); ++v)
    signal.row(Eigen::Index(v)) = vectors[v].transpose();
  return signal;
}

}  // namespace mq
