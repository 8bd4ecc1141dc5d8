#pragma once
/// The same surface in triangles of better shape.

#include "mq/fem/flat_triangle.h"

namespace mq {

/// A triangulation whose edges are straight lines on the surface, not in space.
struct IntrinsicTriangulation {
  /// Triangles and twins are those of the triangulation; vertices, area and topology those of the
  /// surface. Positions are where its vertices are, but say nothing of lengths. Texture
  /// coordinates are left out, and two triangles may share two edges.
  Surface surface;
  std::vector<FlatTriangle> shapes;  ///< the metric
  std::int64_t flips = 0;
  /// Per half-edge its angle at its source, in the `vertex_frames` of the surface that was given: a
  /// vector at a vertex is the same in both triangulations.
  std::vector<double> directions = {};
};

/// Flips edges until each is Delaunay, cot α + cot β ≥ 0, laying two triangles flat beside each
/// other at every flip; always ends. Operators made of `surface` and `shapes` then have no negative
/// weight. Bobenko and Springborn, A discrete Laplace–Beltrami operator for simplicial surfaces,
/// 2007; directions by signposts, Sharp, Soliman, Crane, Navigating intrinsic triangulations, 2019.
/// Edges of triangles without area stay; flips stop after 100 per edge, which rounding alone
/// can bring about.
IntrinsicTriangulation intrinsic_delaunay(const Surface& surface,
                                          const std::vector<FlatTriangle>& shapes);
IntrinsicTriangulation intrinsic_delaunay(const Surface& surface);

}  // namespace mq
