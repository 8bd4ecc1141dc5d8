#pragma once
/// A triangle on the surface and in its texture.

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "mq/atlas/atlas.h"
#include "mq/linear/matrix.h"
#include "mq/mesh/surface.h"

namespace mq {

/// Of a triangle in its texture: from ways on the surface to ways in texels and back.
struct TriangleMap {
  Eigen::Matrix<double, 3, 2> edges;  ///< on the surface
  Eigen::Matrix2d in_texels, gram_inverse;

  TriangleMap(const Surface& surface, const Atlas& atlas, int t) {
    const auto& p = atlas.corners[t];
    in_texels << p[1].column() - p[0].column(), p[2].column() - p[0].column(), p[1].row() - p[0].row(),
        p[2].row() - p[0].row();
    edges.col(0) = surface.mesh.position(t, 1) - surface.mesh.position(t, 0);
    edges.col(1) = surface.mesh.position(t, 2) - surface.mesh.position(t, 0);
    gram_inverse = (edges.transpose() * edges).inverse();
  }
  Vector3 normal() const { return edges.col(0).cross(edges.col(1)); }
  /// The way on the surface of one in texels, to the right and down.
  Vector3 way(const Vector2& texels) const { return edges * (in_texels.inverse() * texels); }
  Vector2 texels(const Vector3& way) const { return in_texels * (gram_inverse * (edges.transpose() * way)); }
  /// ∇ of a function with these derivatives per texel.
  Vector3 gradient(const Vector2& derivatives) const {
    return edges * (gram_inverse * (in_texels.transpose() * derivatives));
  }
};

}  // namespace mq
