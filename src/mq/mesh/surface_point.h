#pragma once
/// A point on a triangle, and what values at the corners are there.

#include <type_traits>

#include "mq/mesh/mesh.h"

namespace mq {

/// A triangle and the weights of its corners: not negative, of sum 1. A weight of exactly 0 is on
/// the edge opposite that corner, two of them are at a vertex.
struct SurfacePoint {
  int triangle = -1;
  Vector3 barycentric = Vector3::Zero();
};

/// Σ_k b_k·at(k) over the corners k = 0, 1, 2, for anything that can be scaled and added: numbers,
/// vectors, rows of a signal.
template <class At>
auto interpolate(const Vector3& barycentric, const At& at) {
  using Value = std::decay_t<decltype(at(0))>;
  if constexpr (requires { typename Value::PlainObject; }) {
    using Plain = typename Value::PlainObject;
    return Plain(barycentric[0] * at(0) + barycentric[1] * at(1) + barycentric[2] * at(2));
  } else {
    return barycentric[0] * at(0) + barycentric[1] * at(1) + barycentric[2] * at(2);
  }
}

/// Where it lies on the mesh, or on the same triangles elsewhere.
inline Vector3 point_at(const Mesh& mesh, const SurfacePoint& p) {
  return interpolate(p.barycentric, [&](int k) { return mesh.position(p.triangle, k); });
}

/// Values at vertices, such as normals, at a point of the mesh.
template <class Values>
auto value_at(const Mesh& mesh, const Values& values, const SurfacePoint& p) {
  const Triangle& v = mesh.triangles[std::size_t(p.triangle)];
  return interpolate(p.barycentric, [&](int k) { return values[std::size_t(v[k])]; });
}

}  // namespace mq
