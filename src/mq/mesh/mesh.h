#pragma once
/// A triangle mesh whose texture coordinates belong to triangle corners.
///
/// The mesh is what a file said, no more: topology, metric and defects are computed from it by the
/// functions of this room. Ids are indices into these arrays and are never renumbered behind a
/// caller's back.

#include <array>
#include <vector>

#include "mq/base/eigen_alignment.h"

namespace mq {

using Vector2 = Eigen::Vector2d;
using Vector3 = Eigen::Vector3d;
using Triangle = std::array<int, 3>;

struct Mesh {
  std::vector<Vector3> positions;    ///< of the vertices
  std::vector<Triangle> triangles;   ///< vertex of each corner, counter-clockwise seen from outside
  std::vector<Vector2> uvs;          ///< pool of texture coordinates; (0,0) is bottom-left
  std::vector<Triangle> corner_uvs;  ///< per corner an index into `uvs`, or -1; empty: no UVs
  std::vector<int> textures;         ///< per triangle its texture, -1: none; empty: all texture 0

  int vertex_count() const { return int(positions.size()); }
  int triangle_count() const { return int(triangles.size()); }
  bool has_uvs() const { return !corner_uvs.empty(); }

  int texture(int triangle) const { return textures.empty() ? 0 : textures[triangle]; }
  const Vector3& position(int triangle, int corner) const {
    return positions[triangles[triangle][corner]];
  }
  /// The corner's texture coordinate; the corner must have one.
  const Vector2& uv(int triangle, int corner) const { return uvs[corner_uvs[triangle][corner]]; }
  /// True where all three corners have a texture coordinate.
  bool textured(int triangle) const {
    if (corner_uvs.empty()) return false;
    const Triangle& c = corner_uvs[triangle];
    return c[0] >= 0 && c[1] >= 0 && c[2] >= 0;
  }
};

}  // namespace mq
