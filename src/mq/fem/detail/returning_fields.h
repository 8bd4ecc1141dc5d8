#pragma once
/// From an intrinsic triangulation back to the surface's triangles.

#include <cmath>
#include <vector>

#include "mq/fem/intrinsic_delaunay.h"
#include "mq/fem/vertex_frames.h"
#include "mq/linear/matrix.h"

namespace mq {

inline Vector2 turned_by(double angle, const Vector2& v) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * v.x() - s * v.y(), s * v.x() + c * v.y()};
}

/// Fields on `delaunay`, brought back by way of vertices, where vectors are the same in both triangulations but for the
/// direction from which angles are counted. The triangulation must outlive the object.
class ReturningFields {
 public:
  ReturningFields(const Surface& surface, const std::vector<FlatTriangle>& shapes,
                  const IntrinsicTriangulation& delaunay);

  /// Two components per vertex of the triangulation: two per triangle of the surface, in its frame.
  Vector from_vertices(Vector z) const;

  /// The same of two components per triangle of the triangulation: around vertices their mean counts.
  Vector from_triangles(const Vector& x) const;

  /// The other way: a vector in the frame of a triangle of the surface at one of its corners, 3·triangle + k.
  Vector2 at_vertex(int corner, const Vector2& v) const;

 private:
  int source(HalfEdge h) const { return delaunay_.surface.mesh.triangles[h / 3][h % 3]; }

  const Surface& surface_;
  const IntrinsicTriangulation& delaunay_;
  VertexFrames frames_, own_;
  std::vector<double> turn_;  ///< per vertex from the triangulation's frame to the surface's
  SparseMatrix prolongation_;
};

}  // namespace mq
