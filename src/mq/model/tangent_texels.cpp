#include "mq/model/detail/tangent_texels.h"

#include <cmath>
#include <utility>

namespace mq {

bool is_flat(const Vector3& mapped, double half_step) {
  return mapped.z() > 0 && std::abs(mapped.x()) <= half_step && std::abs(mapped.y()) <= half_step;
}

double half_vector_step(Depth depth) {
  // A vector's step is twice its code's.
  constexpr double hair = 1 + 1e-3;
  return depth == Depth::u8 ? hair / 255 : depth == Depth::u16 ? hair / 65535 : 0;
}

TangentTexels::TangentTexels(std::shared_ptr<const ShadingFrames> frames,
                             std::vector<TexelPlace> places)
    : frames_(std::move(frames)), places_(std::move(places)) {}

Vector3 TangentTexels::deviation(int unknown, const Vector3& mapped, double half_step) const {
  if (is_flat(mapped, half_step) || !is_placed(unknown)) return Vector3::Zero();
  const TangentFrame f = frame(unknown);
  return f.to_model(mapped) - f.normal.normalized();
}

Vector3 TangentTexels::mapped(int unknown, const Vector3& deviation) const {
  if (deviation.isZero(0) || !is_placed(unknown)) return Vector3::UnitZ();
  const TangentFrame f = frame(unknown);
  const Vector3 n = f.normal.normalized() + deviation;
  constexpr double least = 1e-9;
  return n.norm() > least ? f.to_map(n) : Vector3(Vector3::UnitZ());
}

Vector3 TangentTexels::shading_normal(int unknown) const {
  return is_placed(unknown) ? Vector3(frame(unknown).normal.normalized())
                            : Vector3(Vector3::Zero());
}

}  // namespace mq
