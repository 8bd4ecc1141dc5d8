#pragma once
/// Where a chart can grow in a texture.

#include <vector>

#include "mq/mesh/mesh.h"

namespace mq {

/// What is free beside a chart of the texture that is to grow, near some points. All are in texels from the
/// lower left corner, y upward.
class FreeTexels {
 public:
  /// `taken` are triangles in the texture; those with `own` 1 are of the chart itself, from which no gutter is
  /// kept. Of all others `gutter` texels stay free in rows, columns and diagonals, and half of them (rounded
  /// up) at the border, as in `pack`.
  FreeTexels(const std::vector<std::vector<Vector2>>& taken, const std::vector<char>& own,
             const std::vector<Vector2>& points, int width, int height, int gutter);

  /// Whether a triangle whose corners are among the points can be laid.
  bool fits(const std::vector<Vector2>& triangle) const;

  /// Lays a triangle of the chart: another one has no area in common with it then.
  void take(const std::vector<Vector2>& triangle);

 private:
  struct Extent {
    Vector2 low, high;
    explicit Extent(const std::vector<Vector2>& points);
    bool meets(const Extent& other, double margin) const;
  };

  void mark(const std::vector<std::vector<Vector2>>& polygons);

  Extent inside_, window_;
  int left_ = 0, low_ = 0, width_ = 0, height_ = 0, gutter_;
  std::vector<char> marked_;  // per texel of the window, what others touch and the gutter around it
  std::vector<std::vector<Vector2>> near_;
  std::vector<Extent> extents_;
};

}  // namespace mq
