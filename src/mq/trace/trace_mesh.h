#pragma once
/// A surface made ready to be walked: triangles in an order in which neighbours lie close in
/// memory.

#include <array>
#include <cstdint>
#include <vector>

#include "mq/base/progress.h"
#include "mq/fem/flat_triangle.h"
#include "mq/mesh/surface.h"

namespace mq {

/// Triangles and vertices of a surface, renumbered along a space-filling curve through the
/// triangles' centres (Morton 1966), whatever the order of the file: `trace_triangle` and `vertex`
/// below are numbers of this order, and `source_triangle` and `source_vertex` say which they are on
/// the surface. Corners keep theirs. About 80 bytes per triangle; a few passes and one sort to
/// make.
///
/// The surface ends at boundaries, and for walkers also at triangles without area, whose edges
/// count as boundaries, since no gradient says where to go in them.
class TraceMesh {
 public:
  explicit TraceMesh(const Surface& surface, const Progress& progress = {});

  int triangle_count() const { return int(corners_.size()); }
  int vertex_count() const { return int(source_vertices_.size()); }
  int source_triangle(int t) const { return source_triangles_[t]; }
  int source_vertex(int v) const { return source_vertices_[v]; }
  int trace_triangle(int source) const { return trace_triangles_[source]; }

  const Triangle& corners(int t) const { return corners_[t]; }
  const FlatTriangle& shape(int t) const { return shapes_[t]; }

  /// Across the edge opposite corner k: 4·triangle + the corner opposite the edge there; −1 at an
  /// end. The edge's first corner here, k + 1, is its second there.
  int across(int t, int k) const { return across_[t][k]; }

  /// Corners 3·triangle + k at vertex v, of triangles with area, in increasing order; `any_corner`
  /// is one of any triangle, −1 if no triangle uses the vertex.
  const int* corners_begin(int v) const { return fans_.data() + fan_begin_[v]; }
  const int* corners_end(int v) const { return fans_.data() + fan_begin_[v + 1]; }
  int any_corner(int v) const { return any_corner_[v]; }

  double mean_edge_length() const { return mean_edge_length_; }

 private:
  void order_triangles(const Surface& surface);
  void order_vertices(const Surface& surface);
  void link(const Surface& surface);

  std::vector<int> source_triangles_, trace_triangles_, source_vertices_;
  std::vector<Triangle> corners_;
  std::vector<FlatTriangle> shapes_;
  std::vector<std::array<int, 3>> across_;
  std::vector<int> fan_begin_, fans_, any_corner_;
  double mean_edge_length_ = 0;
};

}  // namespace mq
