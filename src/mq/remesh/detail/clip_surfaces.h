#pragma once
/// Two surfaces in one list of triangles, of which some are kept; and the curves along which what
/// is kept ends.

#include <span>
#include <vector>

#include "mq/mesh/surface.h"

namespace mq {

/// The triangles of a template and, after them, of a target. Cutting long triangles adds vertices
/// and triangles at the end, of either.
struct SurfacePair {
  Mesh mesh;                         ///< positions and triangles
  std::vector<HalfEdge> twins;       ///< per half-edge, −1 at the boundaries of the surfaces
  std::vector<Vector3> normals;      ///< of the vertices, on the surface they belong to
  std::vector<char> of_target;       ///< per vertex 1 on the target
  std::vector<int> source_vertex;    ///< per vertex that of its surface, −1: from cutting
  std::vector<int> source_triangle;  ///< per triangle that of its surface
  std::vector<char> whole;           ///< per triangle 1 where it is that one, 0 where a part of it

  bool triangle_of_target(int t) const { return of_target[std::size_t(mesh.triangles[t][0])] != 0; }
};

SurfacePair join(const Surface& first, const Surface& second);

/// Cuts triangles for which `meets(pair, t)` says 1 (asked for those with an edge longer than
/// `most`): the longest edge is halved, from both sides, again and again until none is left, or
/// there are more than `most_triangles`. Whether none is left. A triangle's first part has its id.
template <class Meets>
bool cut_long_triangles(SurfacePair& pair, double most, std::int64_t most_triangles,
                        const Meets& meets);

/// One round of it: halves the longest edge of each of these triangles; others that share such an
/// edge are cut as well. A triangle's first part takes its place.
void halve_longest_edges(SurfacePair& pair, std::span<const int> triangles);

/// The first longest edge of a triangle, and its length in model units.
HalfEdge longest_half_edge(const Mesh& mesh, int triangle);
double longest_edge(const Mesh& mesh, int triangle);

template <class Meets>
bool cut_long_triangles(SurfacePair& pair, double most, std::int64_t most_triangles,
                        const Meets& meets) {
  for (;;) {
    std::vector<int> cut;
    for (int t = 0; t < pair.mesh.triangle_count(); ++t)
      if (longest_edge(pair.mesh, t) > most && meets(pair, t)) cut.push_back(t);
    if (cut.empty()) return true;
    if (pair.mesh.triangle_count() + std::ssize(cut) > most_triangles) return false;
    halve_longest_edges(pair, cut);
  }
}

/// Removes from what is kept (1 per triangle) what would make the curves awkward: triangles that
/// hang on it by one edge or less, and at vertices where several fans meet all but the largest.
void clean_cut(const SurfacePair& pair, std::vector<char>& kept);

/// Consecutive edges between kept triangles (on their left) and removed ones.
struct CutCurve {
  std::vector<int> vertices;                             ///< in order; of a closed curve none twice
  enum class Kind { closed, open } kind = Kind::closed;  ///< open: ends at a surface's boundary

  int edge_count() const { return int(vertices.size()) - (kind == Kind::open ? 1 : 0); }
};
std::vector<CutCurve> cut_curves(const SurfacePair& pair, const std::vector<char>& kept);

}  // namespace mq
