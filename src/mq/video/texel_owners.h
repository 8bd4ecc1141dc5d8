#pragma once
/// Which triangle of a mesh speaks for a place in its texture.

#include <array>
#include <limits>
#include <vector>

#include "mq/mesh/mesh.h"

namespace mq {

/// Barycentric coordinates of the point of a triangle in the plane that is nearest to p.
Vector3 nearest_in_triangle(const std::array<Vector2, 3>& corners, const Vector2& p);

/// A texture in which every texel has `samples` × `samples` places, sample (i, j) of the whole at
/// ((i + ½) / samples, (j + ½) / samples) texels from its upper left corner. Each belongs to the
/// triangle that it is in (the first, where several overlap), else to the nearest one that is no
/// farther than `margin` texels.
class TexelOwners {
 public:
  struct Owner {
    int triangle = -1;
    float distance = std::numeric_limits<float>::infinity();  ///< texels; 0: it is inside
  };

  TexelOwners(const Mesh& mesh, int width, int height, int samples = 1, double margin = 1);

  const Owner& owner(int column, int row) const {
    return owners_[std::size_t(row) * width_ * samples_ + column];
  }

  /// Corners of a triangle in texels, y downward.
  std::array<Vector2, 3> corners(int triangle) const;
  Vector2 place(int column, int row) const {
    return {(column + 0.5) / samples_, (row + 0.5) / samples_};
  }

 private:
  void add(int triangle, double margin);

  const Mesh& mesh_;
  int width_, height_, samples_;
  std::vector<Owner> owners_;
};

}  // namespace mq
