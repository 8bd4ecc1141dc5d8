#pragma once
/// From a mesh as a file says it to a surface one can integrate over: vertices that exporters split
/// at seams are joined, vertices that are not manifold are split, every defect is listed.
/// Triangles keep their ids and their order; none is removed.

#include <string>

#include "mq/base/defect.h"
#include "mq/base/progress.h"
#include "mq/mesh/mesh.h"

namespace mq {

struct WeldOptions {
  enum class Kind {
    exact,    ///< vertices at bitwise equal positions become one (0 and -0 are equal)
    none,     ///< vertices are what the file says
    distance  ///< vertices closer than `distance` become one
  } kind = Kind::exact;
  double distance = 0;  ///< model units
};

/// Half-edge h = 3·triangle + corner runs from that corner to the next one.
using HalfEdge = int;

/// The half-edges after and before one around its triangle; `next(h)` starts where h ends.
inline HalfEdge next(HalfEdge h) { return h % 3 == 2 ? h - 2 : h + 1; }
inline HalfEdge previous(HalfEdge h) { return h % 3 == 0 ? h + 2 : h - 1; }

/// A mesh made fit for integration.
struct Surface {
  Mesh mesh;                            ///< same triangles, corner UVs and textures as the source
  std::vector<int> vertex_from_source;  ///< per source vertex its vertex here, -1: unreferenced
  std::vector<int> source_from_vertex;  ///< per vertex here one source vertex
  std::vector<HalfEdge> twins;          ///< per half-edge the one across the edge, -1 at a boundary
  std::vector<char> degenerate;         ///< per triangle: 1 where it has no area (it is left out of
                                        ///< every integral but keeps its place)
  double area = 0;                      ///< of all triangles
  int components = 0;                   ///< connected through edges
  int boundary_edges = 0;               ///< edges of one triangle, after cutting
  int euler_characteristic = 0;         ///< of the result, unreferenced vertices not counted
  Defects defects;

  int triangle_count() const { return mesh.triangle_count(); }
};

/// Joins and splits as said above, in time linear in the mesh.
///
/// Edges. Two half-edges between the same vertices in opposite directions are twins. Where more
/// than two meet, those that the file itself joins (by the same source vertices) stay joined, then
/// those for which only one partner is left; the others are cut, as are two of equal direction.
/// A welded vertex whose triangles form several fans becomes one vertex per fan.
///
/// Triangles. Degenerate are those with two equal vertices, and those whose three points are
/// collinear to the rounding of double (sine of the angle between the two shortest edges below
/// 8·2⁻⁵²); anything with more area, however thin, is integrated. With two equal vertices a
/// triangle has no twins, its neighbours are each other's; otherwise it keeps its place between
/// them. A triangle that repeats an earlier one (same vertices, same direction) stands alone,
/// without twins. A vertex that only degenerate triangles use remains, and no integral reaches it.
///
/// Defects (ids of vertices are those of the source; an edge goes by its lowest half-edge):
///   welded_vertices, unreferenced_vertices, two_sided_triangles                          notes
///   degenerate_triangles, duplicate_triangles, nonmanifold_edges, touching_edges (more than two
///   triangles only because vertices were joined), inconsistent_edges, nonmanifold_vertices,
///   triangles_collapsed_by_weld                                                       warnings
///
/// Throws `InvalidInput`, with the first ids, on indices out of range, on positions of referenced
/// vertices that are not finite or beyond 1e60, and on a weld distance that is not positive.
Surface make_surface(const Mesh& mesh, const WeldOptions& weld = {}, const Progress& progress = {});

}  // namespace mq
