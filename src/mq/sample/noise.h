#pragma once
/// Smooth noise in space: the material that samples are painted with.

#include <array>
#include <cstdint>

#include "mq/mesh/mesh.h"

namespace mq {

/// Gradient noise (Perlin, Improving noise, 2002): twice continuously differentiable, 0 at integer
/// points, features about 1 wide, range about [-1, 1]. Repeats after 256.
class Noise {
 public:
  explicit Noise(std::uint64_t seed);

  double operator()(const Vector3& point) const;

  /// Σ 2^-k noise(2^k · point) over the octaves k, each turned against the last so that lattices do
  /// not line up. Range about [-1, 1].
  double octaves(const Vector3& point, int count) const;

 private:
  std::array<std::uint8_t, 512> shuffled_;  // 0 to 255 in random order, twice
};

/// 0 below `low`, 1 above `high`, 3t² − 2t³ between.
double smooth_step(double low, double high, double x);

}  // namespace mq
