#include "mq/baseline/forgetful.h"

#include <numeric>

namespace mq {

EvolvingMesh with_new_ids(const EvolvingMesh& evolving, Forgetting forgetting) {
  EvolvingMesh result;
  int next_vertex = 0, next_triangle = 0, open = -1;
  for (const EvolvingFrame& frame : evolving.frames) {
    if (frame.segment != open || forgetting == Forgetting::frames) {
      EvolvingSegment segment = evolving.segments[open = frame.segment];
      segment.uvs.clear();
      segment.corner_uvs.clear();
      std::iota(segment.vertex_ids.begin(), segment.vertex_ids.end(), next_vertex);
      std::iota(segment.triangle_ids.begin(), segment.triangle_ids.end(), next_triangle);
      next_vertex += segment.vertex_count();
      next_triangle += segment.triangle_count();
      result.segments.push_back(std::move(segment));
    }
    result.frames.push_back({frame.number, int(result.segments.size()) - 1, frame.positions});
  }
  return result;
}

}  // namespace mq
