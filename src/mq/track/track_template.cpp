#include "mq/track/track_template.h"

#include <unordered_map>

#include "mq/base/error.h"

namespace mq {
namespace {

/// The index of each id.
std::unordered_map<int, int> places(const std::vector<int>& ids) {
  std::unordered_map<int, int> result;
  for (std::size_t i = 0; i < ids.size(); ++i) result.emplace(ids[i], int(i));
  return result;
}

/// Ids of what has an origin, new ones for the rest.
std::vector<int> inherited(const std::vector<int>& origins, const std::vector<int>& ids, int next) {
  std::vector<int> result;
  for (const int origin : origins) result.push_back(origin >= 0 ? ids[origin] : next++);
  return result;
}

}  // namespace

TrackTemplate new_template(const Mesh& mesh, const Signal& colours,
                           const std::vector<Vector3>& material, int first_vertex_id,
                           int first_triangle_id) {
  return {segment_of(mesh, first_vertex_id, first_triangle_id), mesh.positions, colours, material,
          corner_positions(mesh)};
}

EvolvingSegment remeshed_segment(const Remeshed& remeshed, const EvolvingSegment& before,
                                 int first_vertex_id, int first_triangle_id) {
  EvolvingSegment segment;
  segment.triangles = remeshed.mesh.triangles;
  segment.vertex_ids = inherited(remeshed.template_vertices, before.vertex_ids, first_vertex_id);
  segment.triangle_ids =
      inherited(remeshed.template_triangles, before.triangle_ids, first_triangle_id);
  return segment;
}

TrackTemplate carried(const TrackTemplate& before, const EvolvingSegment& after,
                      const std::vector<Vector3>& positions, const TrackTarget& frame,
                      const MaterialFrame* truth) {
  TrackTemplate result{after, positions, {}, {}, corner_positions(mesh_of(after, positions))};
  const auto vertex_before = places(before.segment.vertex_ids);
  const auto triangle_before = places(before.segment.triangle_ids);
  for (int t = 0; t < after.triangle_count(); ++t) {
    const auto found = triangle_before.find(after.triangle_ids[t]);
    // A triangle may begin at another corner now.
    if (found == triangle_before.end()) continue;
    const Triangle& old = before.segment.triangles[found->second];
    for (int k = 0; k < 3; ++k)
      for (int l = 0; l < 3; ++l)
        if (before.segment.vertex_ids[old[l]] == after.vertex_ids[after.triangles[t][k]])
          result.rest[t][k] = before.rest[found->second][l];
  }
  if (before.colours.size() > 0) {
    require(frame.colours().cols() == before.colours.cols(), "the frame has other colours");
    const std::vector<ClosestPoint> nearest = frame.closest()(positions);
    result.colours.resize(std::ssize(positions), before.colours.cols());
    for (std::size_t v = 0; v < positions.size(); ++v) {
      const auto found = vertex_before.find(after.vertex_ids[v]);
      if (found != vertex_before.end()) {
        result.colours.row(std::int64_t(v)) = before.colours.row(found->second);
        continue;
      }
      const Triangle& corners = frame.surface().mesh.triangles[nearest[v].triangle];
      result.colours.row(std::int64_t(v)).setZero();
      for (int k = 0; k < 3; ++k)
        result.colours.row(std::int64_t(v)) +=
            nearest[v].barycentric[k] * frame.colours().row(corners[k]);
    }
  }
  if (truth != nullptr) {
    const std::vector<ClosestPoint> nearest = ClosestPointFinder(truth->space)(positions);
    result.material.resize(positions.size());
    for (std::size_t v = 0; v < positions.size(); ++v) {
      const auto found = vertex_before.find(after.vertex_ids[v]);
      if (found != vertex_before.end()) {
        result.material[v] = before.material[found->second];
        continue;
      }
      result.material[v].setZero();
      for (int k = 0; k < 3; ++k)
        result.material[v] +=
            nearest[v].barycentric[k] * truth->material.position(nearest[v].triangle, k);
    }
  }
  return result;
}

std::vector<Vector3> positions_before(const EvolvingSegment& before,
                                      std::span<const Vector3> positions_before,
                                      const EvolvingSegment& after,
                                      std::span<const Vector3> positions) {
  const auto vertex_before = places(before.vertex_ids);
  const std::size_t n = positions.size();
  std::vector<Vector3> moves(n, Vector3::Zero());
  std::vector<char> known(n, 0);
  for (std::size_t v = 0; v < n; ++v) {
    const auto found = vertex_before.find(after.vertex_ids[v]);
    if (found == vertex_before.end()) continue;
    moves[v] = positions[v] - positions_before[found->second];
    known[v] = 1;
  }
  // Ring after ring from what is known.
  for (bool grows = true; grows;) {
    grows = false;
    std::vector<Vector3> sums(n, Vector3::Zero());
    std::vector<int> counts(n, 0);
    for (const Triangle& t : after.triangles)
      for (int k = 0; k < 3; ++k)
        for (const int other : {t[(k + 1) % 3], t[(k + 2) % 3]})
          if (!known[t[k]] && known[other]) sums[t[k]] += moves[other], ++counts[t[k]];
    for (std::size_t v = 0; v < n; ++v)
      if (counts[v] > 0) moves[v] = sums[v] / counts[v], known[v] = 1, grows = true;
  }
  std::vector<Vector3> result(positions.begin(), positions.end());
  for (std::size_t v = 0; v < n; ++v) result[v] -= moves[v];
  return result;
}

Distortion distortion(const TrackTemplate& tracked, std::span<const Vector3> now) {
  std::vector<Triangle> triangles;
  std::vector<Vector3> rest, corners;
  for (int t = 0; t < tracked.segment.triangle_count(); ++t) {
    triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    for (int k = 0; k < 3; ++k) {
      rest.push_back(tracked.rest[t][k]);
      corners.push_back(now[tracked.segment.triangles[t][k]]);
    }
  }
  return distortion(triangles, rest, corners);
}

}  // namespace mq
