#include "mq/fem/edges.h"

#include <fmt/format.h>

#include "mq/base/error.h"

namespace mq {

Edges make_edges(const Surface& surface, const std::vector<FlatTriangle>& shapes) {
  require(int(shapes.size()) == surface.triangle_count(),
          fmt::format("{} shapes were given for {} triangles", shapes.size(),
                      surface.triangle_count()));
  const int half_edges = 3 * surface.triangle_count();
  Edges edges;
  edges.from_half_edge.assign(half_edges, -1);
  edges.sign.assign(half_edges, 0);
  for (HalfEdge h = 0; h < half_edges; ++h) {
    if (shapes[h / 3].empty()) continue;
    const HalfEdge twin = surface.twins[h];
    if (twin >= 0 && twin < h && !shapes[twin / 3].empty()) {
      edges.from_half_edge[h] = edges.from_half_edge[twin];
      edges.sign[h] = -1;
      continue;
    }
    const Triangle& t = surface.mesh.triangles[h / 3];
    edges.from_half_edge[h] = edges.count();
    edges.sign[h] = 1;
    edges.vertices.push_back({t[h % 3], t[(h + 1) % 3]});
  }
  return edges;
}

}  // namespace mq
