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
    exact,     ///< vertices at bitwise equal positions become one (0 and -0 are equal)
    none,      ///< vertices are what the file says
    distance   ///< vertices closer than `distance` become one
  } kind = Kind::exact;
  double distance = 0;  ///< model units
};

/// Half-edge h = 3·triangle + corner runs from that corner to the next one.
using HalfEdge = int;

/// A mesh made fit for integration.
struct Surface {
  Mesh mesh;                            ///< same triangles, corner UVs and textures as the source
  std::vector<int> vertex_from_source;  ///< per source vertex its vertex here, or -1 if unreferenced
  std::vector<int> source_from_vertex;  ///< per vertex here one source vertex
  std::vector<HalfEdge> twins;          ///< per half-edge the one across the edge, -1 at a boundary
  std::vector<char> degenerate;         ///< per triangle: 1 where it has no area (it is left out of
                                        ///< every integral but keeps its place)
  double area = 0;                      ///< of all triangles
  int components = 0;                   ///< connected through edges
  int boundary_edges = 0;
  int euler_characteristic = 0;         ///< of the result, unreferenced vertices not counted
  Defects defects;

  int triangle_count() const { return mesh.triangle_count(); }
};

/// Joins and splits as said above. Edges with more than two triangles, or two of equal direction
/// (inconsistent orientation), are cut: their twins are -1. Reports welded, unreferenced and
/// non-manifold vertices, non-manifold and inconsistently oriented edges, degenerate and duplicate
/// triangles. Throws `InvalidInput` on indices out of range or positions that are not finite,
/// with the first ids.
Surface make_surface(const Mesh& mesh, const WeldOptions& weld = {}, const Progress& progress = {});

}  // namespace mq
