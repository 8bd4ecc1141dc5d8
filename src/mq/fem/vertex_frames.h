#pragma once
/// Tangent planes at vertices: where a vector field has one complex number per vertex.

#include <vector>

#include "mq/fem/edges.h"
#include "mq/fem/flat_triangle.h"
#include "mq/linear/matrix.h"

namespace mq {

/// Directions around vertices as angles, counter-clockwise from the vertex' first edge. Angles
/// around an inner vertex are scaled to sum to 2π; at a boundary they are taken as they are.
/// Knöppel, Crane, Pinkall, Schröder [knoppel2013globally]; Sharp, Soliman, Crane
/// [sharp2019vector]. Half-edges of triangles without area have 0.
struct VertexFrames {
  std::vector<double> at_source;  ///< per half-edge the angle of the edge at its source
  std::vector<double> at_target;  ///< and at its target, looking back
  /// Per corner 3·triangle + k: what to add to the angle of a vector at the vertex for its angle in
  /// the triangle's frame. The corner's middle goes to its middle.
  std::vector<double> into_triangle;

  /// What to add to the angle of a vector at the target of h for that at its source, carried along
  /// the edge.
  double along(HalfEdge h) const;
};

VertexFrames vertex_frames(const Surface& surface, const std::vector<FlatTriangle>& shapes);

/// The connection Laplacian of tangent vectors at vertices, 2·vertices × 2·vertices,
///
///     ⟨z, L·z⟩ = Σ_ij ½(cot α + cot β) |z_i − r_ij·z_j|²  ≈  ∫ |∇X|² dA,
///
/// z_i = (z_2i, z_2i+1) being components along and across the vertex' first edge, and r_ij the
/// rotation that carries vectors along edge ij. Symmetric; semidefinite where the mesh is Delaunay.
/// Null space: parallel fields, none where there is curvature. The mass that goes with it is
/// `vertex_area_mass` (exterior.h).
SparseMatrix connection_laplacian(const Surface& surface, const std::vector<FlatTriangle>& shapes);

/// V: P makes a vector per triangle, in its frame, the mean of those at its corners: 2·triangles ×
/// 2·vertices. Exact for constant fields in the plane.
SparseMatrix vertex_prolongation(const Surface& surface, const std::vector<FlatTriangle>& shapes,
                                 const VertexFrames& frames);

/// V to W: ω_e = ∫ ⟨X, ds⟩ along each edge by the mean of X at its ends, edges × 2·vertices. Exact for constant fields in
/// the plane.
SparseMatrix circulation_along_edges(const Surface& surface, const std::vector<FlatTriangle>& shapes,
                                     const VertexFrames& frames, const Edges& edges);

}  // namespace mq
