#pragma once
/// Better triangles along a seam between a template that must stay as it is and a target's part,
/// and where a template's are renewed.

#include <vector>

#include "mq/mesh/closest_point.h"
#include "mq/remesh/detail/clip_surfaces.h"

namespace mq {

/// A stitched mesh in the vertices of a pair.
struct Seam {
  std::vector<Triangle> triangles;
  std::vector<int> from;           ///< per triangle that of the pair, −1: of a strip, or changed
  std::vector<Vector3> positions;  ///< of the pair's vertices
  std::vector<Vector3> offsets;    ///< per vertex of the pair to the other surface; 0: not known
  std::vector<char> free;          ///< per vertex of the pair: of the template, but may move
};

/// Works on strips and on the target's triangles within two rings of them. Vertices of the target
/// next to a strip go half of their offset towards the template, those of the next ring a quarter.
/// Then, three times: edges shorter than 0.4 of those around are collapsed onto a vertex that
/// stays, edges are flipped where the worse of two triangles gets better, vertices of the target
/// slide along the surface to the middle of their neighbours. So are those of the template that are
/// free, onto the target where that faces alike, and the triangles around them, all of which must
/// be said to be changed. Nothing is done that would turn a triangle over against the surface or
/// make the mesh not manifold. The template's other triangles and all boundaries stay. Triangles
/// that went are taken out; the order of the others stays.
/// `finder` is on the target.
void improve_seam(const SurfacePair& pair, const Mesh& target, const ClosestPointFinder& finder,
                  Seam& seam);

/// 4√3 area / (sum of squared edges): 1 equilateral, 0 without area; negative where the normal
/// points away from `normal`.
double triangle_quality(const Vector3& p, const Vector3& q, const Vector3& r,
                        const Vector3& normal);

}  // namespace mq
