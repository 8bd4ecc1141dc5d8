#include "mq/mesh/soundness.h"

#include <algorithm>

#include "mq/mesh/geometry.h"

namespace mq {

bool is_manifold(const Surface& surface) {
  return std::ranges::none_of(surface.defects, [](const Defect& defect) {
    return defect.kind == "nonmanifold_edges" || defect.kind == "inconsistent_edges" ||
           defect.kind == "nonmanifold_vertices" || defect.kind == "duplicate_triangles";
  });
}

std::vector<int> folded_triangles(const Surface& surface) {
  const std::vector<Vector3> normals = triangle_normals(surface.mesh);
  std::vector<int> folded;
  for (int t = 0; t < surface.triangle_count(); ++t) {
    Vector3 around = Vector3::Zero();
    for (int k = 0; k < 3; ++k)
      if (const HalfEdge twin = surface.twins[3 * t + k]; twin >= 0) around += normals[twin / 3];
    if (surface.degenerate[t] || normals[t].dot(around) < 0) folded.push_back(t);
  }
  return folded;
}

}  // namespace mq
