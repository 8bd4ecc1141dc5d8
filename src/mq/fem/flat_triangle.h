#pragma once
/// Triangles laid flat: the metric that every operator on a mesh is built from.

#include <Eigen/Core>

#include <vector>

#include "mq/mesh/surface.h"

namespace mq {

/// The shape of a triangle, in an orthonormal frame whose first axis runs along its first edge:
///
///     corner 0 = (0, 0),   corner 1 = (base, 0),   corner 2 = (foot, height).
///
/// This is the metric of the thesis' canonical parameterization (2.12) as a Cholesky factor,
/// g = (base², base·foot; base·foot, foot² + height²), which keeps the height of a thin triangle
/// that the determinant of g would lose. All zero: the triangle has no area and is left out.
/// Vectors in a triangle are pairs in this frame; J turns them by +90°.
struct FlatTriangle {
  double base = 0;
  double foot = 0;
  double height = 0;

  bool empty() const { return !(height > 0); }
  double area() const { return 0.5 * base * height; }
  Vector2 corner(int k) const {
    return k == 0 ? Vector2(0, 0) : k == 1 ? Vector2(base, 0) : Vector2(foot, height);
  }
  /// From corner k to the next one.
  Vector2 edge(int k) const { return corner((k + 1) % 3) - corner(k); }
  /// ∇ of the hat function of corner k: J·(edge opposite) / (2·area).
  Vector2 gradient(int k) const;
  /// Half the cotangent of the angle at corner k: −∫ ⟨∇φ_i, ∇φ_j⟩ of the two other corners.
  double half_cotangent(int k) const;
};

/// J·v: +90°, counter-clockwise seen from the side the triangle faces.
inline Vector2 turned(const Vector2& v) { return {-v.y(), v.x()}; }

/// From the edges corner 0 → corner 1 and corner 0 → corner 2; empty where they span no area.
FlatTriangle flat_triangle(const Vector3& first, const Vector3& second);

/// From a metric g = (uu, uv; uv, vv) in the canonical parameterization, positive definite.
FlatTriangle flat_triangle(double uu, double uv, double vv);

/// The triangles of a surface; empty where it says degenerate.
std::vector<FlatTriangle> flat_triangles(const Surface& surface);

/// The frame of a triangle in space: two orthonormal columns, 0 where it is degenerate.
Eigen::Matrix<double, 3, 2> frame_in_space(const Surface& surface, int triangle);

/// A vector field constant per triangle: rows 2t and 2t + 1 are its components in triangle t's frame.
/// As vectors in space, and back (the part tangent to each triangle); 0 in degenerate triangles.
std::vector<Vector3> field_in_space(const Surface& surface, const Eigen::VectorXd& field);
Eigen::VectorXd field_in_frames(const Surface& surface, const std::vector<Vector3>& field);

}  // namespace mq
