#include "mq/evolving/evolving_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <array>
#include <limits>
#include <map>
#include <numeric>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "mq/base/error.h"

namespace mq {
namespace {

void check_ids(const std::vector<int>& ids, std::size_t count, const char* what) {
  require(ids.size() == count,
          fmt::format("a segment has {} {} and {} ids of them", count, what, ids.size()));
  const bool are_increasing = std::ranges::adjacent_find(ids, std::ranges::greater_equal()) == ids.end();
  if (are_increasing && (ids.empty() || ids.front() >= 0)) return;
  const auto [least, most] = std::ranges::minmax(ids);
  if (least < 0) throw InvalidInput(fmt::format("a segment's {} have the id {}", what, least));
  const auto twice = [what](int id) {
    return InvalidInput(fmt::format("the id {} is given twice to {} of one segment", id, what));
  };
  constexpr std::size_t few_gaps = 16;  // for each id, which a table of all may have
  if (std::size_t(most) <= few_gaps * ids.size()) {
    std::vector<char> seen(std::size_t(most) + 1, 0);
    for (const int id : ids)
      if (std::exchange(seen[std::size_t(id)], 1)) throw twice(id);
    return;
  }
  std::vector<int> sorted = ids;
  std::ranges::sort(sorted);
  if (const auto found = std::ranges::adjacent_find(sorted); found != sorted.end()) throw twice(*found);
}

void check_indices(const std::vector<Triangle>& triangles, int least, std::size_t count,
                   const char* what) {
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (const int index : triangles[t])
      if (index < least || index >= int(count))
        throw InvalidInput(
            fmt::format("triangle {} of a segment names {} {} of {}", t, what, index, count));
}

/// The ids of a triangle's vertices, the lowest first, in their order around it.
Triangle vertices_of(const EvolvingSegment& segment, int t) {
  Triangle ids;
  for (int k = 0; k < 3; ++k) ids[k] = segment.vertex_ids[segment.triangles[t][k]];
  std::rotate(ids.begin(), std::ranges::min_element(ids), ids.end());
  return ids;
}

int next_id(const EvolvingMesh& evolving, std::vector<int> EvolvingSegment::*ids) {
  int next = 0;
  for (const EvolvingSegment& segment : evolving.segments)
    for (const int id : segment.*ids) next = std::max(next, id + 1);
  return next;
}

}  // namespace

Mesh mesh_of(const EvolvingSegment& segment, std::vector<Vector3> positions) {
  Mesh mesh;
  mesh.positions = std::move(positions);
  mesh.triangles = segment.triangles;
  mesh.uvs = segment.uvs;
  mesh.corner_uvs = segment.corner_uvs;
  return mesh;
}

Mesh EvolvingMesh::mesh(int frame) const {
  const EvolvingFrame& f = frames.at(std::size_t(frame));
  return mesh_of(segments.at(std::size_t(f.segment)), f.positions);
}

EvolvingSegment segment_of(const Mesh& mesh, int first_vertex_id, int first_triangle_id) {
  EvolvingSegment segment;
  segment.triangles = mesh.triangles;
  segment.uvs = mesh.uvs;
  segment.corner_uvs = mesh.corner_uvs;
  segment.vertex_ids.resize(mesh.positions.size());
  segment.triangle_ids.resize(mesh.triangles.size());
  std::iota(segment.vertex_ids.begin(), segment.vertex_ids.end(), first_vertex_id);
  std::iota(segment.triangle_ids.begin(), segment.triangle_ids.end(), first_triangle_id);
  return segment;
}

int next_vertex_id(const EvolvingMesh& evolving) {
  return next_id(evolving, &EvolvingSegment::vertex_ids);
}

int next_triangle_id(const EvolvingMesh& evolving) {
  return next_id(evolving, &EvolvingSegment::triangle_ids);
}

std::vector<Lifespan> triangle_lifespans(const EvolvingMesh& evolving) {
  struct Life {
    Lifespan span;
    Triangle vertices;
  };
  std::map<int, Life> lives;
  const int frame_count = int(evolving.frames.size());
  for (int first = 0; first < frame_count;) {
    const int s = evolving.frames[first].segment;
    int last = first;
    while (last + 1 < frame_count && evolving.frames[last + 1].segment == s) ++last;
    const EvolvingSegment& segment = evolving.segments.at(std::size_t(s));
    for (int t = 0; t < segment.triangle_count(); ++t) {
      const int id = segment.triangle_ids[t];
      const Triangle vertices = vertices_of(segment, t);
      const auto [place, is_new] = lives.try_emplace(id, Life{{id, first, last}, vertices});
      if (is_new) continue;
      Life& life = place->second;
      require(life.span.last == first - 1,
              fmt::format("triangle {} was gone after frame {} and is back in frame {}", id,
                          life.span.last, first));
      require(life.vertices == vertices,
              fmt::format("triangle {} has other vertices from frame {} on", id, first));
      life.span.last = last;
    }
    first = last + 1;
  }
  std::vector<Lifespan> spans;
  spans.reserve(lives.size());
  for (const auto& [id, life] : lives) spans.push_back(life.span);
  return spans;
}

std::vector<std::vector<Lifespan>> coordinate_lifespans(const EvolvingMesh& evolving) {
  struct Stay {
    Lifespan span;
    std::array<Vector2, 3> uvs;
  };
  std::vector<Stay> stays;
  std::unordered_map<int, int> latest;  // of a triangle's id
  std::vector<std::vector<int>> stay_of(evolving.segments.size());
  const int frame_count = int(evolving.frames.size());
  for (int first = 0; first < frame_count;) {
    const int s = evolving.frames[first].segment;
    int last = first;
    while (last + 1 < frame_count && evolving.frames[last + 1].segment == s) ++last;
    const EvolvingSegment& segment = evolving.segments.at(std::size_t(s));
    for (int t = 0; t < segment.triangle_count(); ++t) {
      const int id = segment.triangle_ids[t];
      std::array<Vector2, 3> uvs{Vector2::Zero(), Vector2::Zero(), Vector2::Zero()};
      for (int k = 0; k < 3 && !segment.corner_uvs.empty(); ++k)
        if (const int uv = segment.corner_uvs[t][k]; uv >= 0) uvs[k] = segment.uvs[uv];
      const auto [place, is_new] = latest.try_emplace(id, -1);
      if (is_new || stays[place->second].span.last != first - 1 ||
          stays[place->second].uvs != uvs) {
        place->second = int(stays.size());
        stays.push_back({{id, first, last}, uvs});
      }
      stays[place->second].span.last = last;
      stay_of[s].push_back(place->second);
    }
    first = last + 1;
  }
  std::vector<std::vector<Lifespan>> result(evolving.segments.size());
  for (std::size_t s = 0; s < result.size(); ++s)
    for (const int stay : stay_of[s]) result[s].push_back(stays[stay].span);
  return result;
}

SegmentChange change(const EvolvingSegment& before, const EvolvingSegment& after) {
  const std::unordered_set<int> known(before.triangle_ids.begin(), before.triangle_ids.end());
  SegmentChange result;
  for (const int id : after.triangle_ids) ++(known.contains(id) ? result.kept : result.added);
  result.removed = before.triangle_count() - result.kept;
  return result;
}

UnitGrid unit_grid(const EvolvingMesh& evolving) {
  Vector3 low = Vector3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const EvolvingFrame& frame : evolving.frames)
    for (const Vector3& p : frame.positions) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const double size = (high - low).maxCoeff();
  require(size > 0, "no frame of the evolving mesh has any extent");
  return {low, size};
}

EvolvingMesh on_unit_grid(EvolvingMesh evolving, const UnitGrid& grid) {
  for (EvolvingFrame& frame : evolving.frames)
    for (Vector3& p : frame.positions)
      p = ((p - grid.low) / grid.size * 0x1p32).array().rint().matrix() * 0x1p-32;
  return evolving;
}

EvolvingMesh on_unit_grid(EvolvingMesh evolving) {
  const UnitGrid grid = unit_grid(evolving);
  return on_unit_grid(std::move(evolving), grid);
}

void check(const EvolvingSegment& segment) {
  check_ids(segment.vertex_ids, segment.vertex_ids.size(), "vertices");
  check_ids(segment.triangle_ids, segment.triangles.size(), "triangles");
  check_indices(segment.triangles, 0, segment.vertex_ids.size(), "vertex");
  require(segment.corner_uvs.empty() || segment.corner_uvs.size() == segment.triangles.size(),
          fmt::format("a segment has {} triangles, and texture coordinates for {}",
                      segment.triangles.size(), segment.corner_uvs.size()));
  check_indices(segment.corner_uvs, -1, segment.uvs.size(), "texture coordinate");
  for (const Vector2& uv : segment.uvs)
    require(uv.allFinite(), "a segment has texture coordinates that are not finite");
}

void check(const EvolvingMesh& evolving) {
  for (const EvolvingSegment& segment : evolving.segments) check(segment);
  for (std::size_t f = 0; f < evolving.frames.size(); ++f) {
    const EvolvingFrame& frame = evolving.frames[f];
    require(
        frame.segment >= 0 && frame.segment < int(evolving.segments.size()),
        fmt::format("frame {} names segment {} of {}", f, frame.segment, evolving.segments.size()));
    const int vertices = evolving.segments[frame.segment].vertex_count();
    require(int(frame.positions.size()) == vertices,
            fmt::format("frame {} has {} positions for {} vertices", f, frame.positions.size(),
                        vertices));
    for (const Vector3& p : frame.positions)
      if (!p.allFinite())
        throw InvalidInput(fmt::format("frame {} has a position that is not finite", f));
    if (f == 0) continue;
    const EvolvingFrame& before = evolving.frames[f - 1];
    require(
        frame.number > before.number,
        fmt::format("frame number {} follows {}: they must increase", frame.number, before.number));
    require(frame.segment >= before.segment,
            fmt::format("frame {} goes back to segment {}", f, frame.segment));
  }
}

}  // namespace mq
