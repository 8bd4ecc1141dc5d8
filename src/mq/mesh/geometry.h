#pragma once
/// Measures of a mesh: areas, angles, normals, curvatures. Everything in model units; triangles are
/// those of the mesh, degenerate ones included (they have area 0, normal 0 and angles that are
/// finite). Nothing here depends on the number of threads.

#include <span>
#include <vector>

#include "mq/mesh/surface.h"

namespace mq {

/// ½ |(q − p) × (r − p)|.
double triangle_area(const Mesh& mesh, int triangle);
std::vector<double> triangle_areas(const Mesh& mesh);
double total_area(const Mesh& mesh);

/// Twice the signed area of the triangle 0, a, b: positive where b lies to the left of a.
inline double cross(const Vector2& a, const Vector2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// The unit normal (q − p) × (r − p) / |...|; 0 where the triangle has no area.
Vector3 triangle_normal(const Mesh& mesh, int triangle);
std::vector<Vector3> triangle_normals(const Mesh& mesh);

/// The angles at the three corners in radians, by atan2 (accurate for any shape); they sum to π.
/// Of a triangle with equal vertices the angles at these are 0.
Vector3 corner_angles(const Mesh& mesh, int triangle);

/// Unit normals of vertices: Σ angle · normal over the triangles around, normalised (Thürmer and
/// Wüthrich [thurmer1998normals]), independent of how the mesh is triangulated. 0 where no triangle
/// has area.
std::vector<Vector3> vertex_normals(const Mesh& mesh);

/// Mean length over the edges, each counted once; 0 for an empty surface.
double mean_edge_length(const Surface& surface);

/// Corners of the smallest box around the vertices that triangles use; both 0 if there are none.
struct Box {
  Vector3 low = Vector3::Zero();
  Vector3 high = Vector3::Zero();
  double diagonal() const { return (high - low).norm(); }
};
Box bounding_box(const Mesh& mesh);

/// Eigenvalues and unit eigenvectors of the shape operator dN: dN(max_direction) = max ·
/// max_direction, so that a sphere of radius R with outward normal has 1/R twice. max ≥ min; the
/// directions are orthogonal, tangent, and have no sign; where max = min they are arbitrary.
struct PrincipalCurvatures {
  double max = 0;
  double min = 0;
  Vector3 max_direction = Vector3::Zero();
  Vector3 min_direction = Vector3::Zero();

  double gauss() const { return max * min; }
  double mean() const { return 0.5 * (max + min); }
};

struct CurvatureOptions {
  int rings = 2;  ///< neighbours that the fit uses, at least 1; more is smoother
};

/// Curvatures at vertices: a cubic height function over the plane of the vertex normal, fitted by
/// least squares to the rings around (Cazals and Pouget [cazals2005jets]); error O(h²) in the edge
/// length h. Where there are too few neighbours the fit is quadratic; where there is no fit at all
/// curvatures are 0 and directions any frame (0 where no triangle has area). Cost about 2 µs per
/// vertex and thread. Throws `InvalidInput` when `rings` is below 1.
std::vector<PrincipalCurvatures> vertex_curvatures(const Surface& surface,
                                                   const CurvatureOptions& options = {},
                                                   const Progress& progress = {});

/// The same of these vertices alone, in their order.
std::vector<PrincipalCurvatures> vertex_curvatures(const Surface& surface, std::span<const int> vertices,
                                                   const CurvatureOptions& options = {},
                                                   const Progress& progress = {});

/// Curvatures of triangles: the mean of the corners' shape operators, restricted to the plane of
/// the triangle. 0 where the triangle has no area.
std::vector<PrincipalCurvatures> triangle_curvatures(
    const Surface& surface, const std::vector<PrincipalCurvatures>& vertices);

}  // namespace mq
