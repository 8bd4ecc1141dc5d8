#pragma once
/// Points of a texture in exact arithmetic.
///
/// Texel coordinates put texel (column i, row j), row 0 on top, at (i, j): x = u·W − ½ and
/// y = (1 − v)·H − ½. This header is the one place that knows. They are rounded once to multiples
/// of 2⁻³⁶ texel; from then on every question of side (left of, on, right of) is answered exactly.

#include <cmath>
#include <compare>
#include <cstdint>

#include "mq/mesh/mesh.h"

namespace mq {

struct TexelPoint {
  static constexpr int fraction_bits = 36;
  static constexpr std::int64_t one = std::int64_t(1) << fraction_bits;

  std::int64_t x = 0;
  std::int64_t y = 0;

  auto operator<=>(const TexelPoint&) const = default;

  double column() const { return double(x) / double(one); }
  double row() const { return double(y) / double(one); }
};

/// The point of texture coordinate `uv` in a texture of width × height texels.
/// |uv| must be below 2¹² for textures up to 2¹⁴ (the atlas refuses what is farther out).
inline TexelPoint texel_point(const Vector2& uv, int width, int height) {
  const double one = double(TexelPoint::one);
  return {std::llround((uv.x() * width - 0.5) * one),
          std::llround(((1.0 - uv.y()) * height - 0.5) * one)};
}

/// A 128-bit integer: products of two coordinates do not overflow it.
__extension__ using Int128 = __int128;

/// Twice the signed area of (a, b, c) in units of 2⁻⁷² texel²; positive when x turns towards y.
inline Int128 orientation(const TexelPoint& a, const TexelPoint& b, const TexelPoint& c) {
  return Int128(b.x - a.x) * (c.y - a.y) - Int128(b.y - a.y) * (c.x - a.x);
}

/// −1, 0 or 1.
inline int sign(Int128 value) { return (value > 0) - (value < 0); }

/// The largest integer not above a coordinate: the column or row of the cell it lies in.
inline int floor_texel(std::int64_t coordinate) {
  return int(coordinate >> TexelPoint::fraction_bits);
}

}  // namespace mq
