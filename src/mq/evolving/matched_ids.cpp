#include "mq/evolving/matched_ids.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>

namespace mq {
namespace {

/// Texture coordinates of a triangle from the smallest on, and which corner has that.
struct Place {
  std::array<double, 6> uvs;
  int first = 0;
};

std::optional<Place> place_of(const EvolvingSegment& segment, int t) {
  if (segment.corner_uvs.empty()) return {};
  const Triangle& corners = segment.corner_uvs[std::size_t(t)];
  if (std::ranges::any_of(corners, [](int uv) { return uv < 0; })) return {};
  const auto at = [&](int k) -> const Vector2& { return segment.uvs[std::size_t(corners[std::size_t(k % 3)])]; };
  const auto before = [&](int a, int b) {
    return at(a).x() < at(b).x() || (at(a).x() == at(b).x() && at(a).y() < at(b).y());
  };
  Place place;
  for (int k = 1; k < 3; ++k)
    if (before(k, place.first)) place.first = k;
  for (int k = 0; k < 3; ++k) {
    place.uvs[std::size_t(2 * k)] = at(place.first + k).x();
    place.uvs[std::size_t(2 * k + 1)] = at(place.first + k).y();
  }
  return place;
}

/// Triangles by their texture coordinates; −1: several have them.
std::map<std::array<double, 6>, int> triangles_by_place(const EvolvingSegment& segment) {
  std::map<std::array<double, 6>, int> found;
  for (int t = 0; t < segment.triangle_count(); ++t)
    if (const auto place = place_of(segment, t))
      if (const auto [entry, is_new] = found.try_emplace(place->uvs, t); !is_new) entry->second = -1;
  return found;
}

/// Takes ids over from the segment before, of which none are given yet (−1).
void take_over(const EvolvingSegment& before, EvolvingSegment& segment) {
  const auto known = triangles_by_place(before), own = triangles_by_place(segment);
  std::map<int, int> owner;  // of a vertex id, in this segment
  for (const auto& [uvs, t] : own) {
    const auto found = known.find(uvs);
    if (t < 0 || found == known.end() || found->second < 0) continue;
    const int old = found->second;
    const int turn = (place_of(segment, t)->first - place_of(before, old)->first + 3) % 3;
    Triangle corners = segment.triangles[std::size_t(t)], uv = segment.corner_uvs[std::size_t(t)];
    std::rotate(corners.begin(), corners.begin() + turn, corners.end());
    std::rotate(uv.begin(), uv.begin() + turn, uv.end());
    const auto id_of = [&](std::size_t k) {
      return before.vertex_ids[std::size_t(before.triangles[std::size_t(old)][k])];
    };
    bool fits = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const int given = segment.vertex_ids[std::size_t(corners[k])];
      const auto other = owner.find(id_of(k));
      fits = fits && (given < 0 || given == id_of(k)) && (other == owner.end() || other->second == corners[k]);
    }
    if (!fits) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      segment.vertex_ids[std::size_t(corners[k])] = id_of(k);
      owner[id_of(k)] = corners[k];
    }
    segment.triangles[std::size_t(t)] = corners;
    segment.corner_uvs[std::size_t(t)] = uv;
    segment.triangle_ids[std::size_t(t)] = before.triangle_ids[std::size_t(old)];
  }
}

void number_the_rest(std::vector<int>& ids, int& next) {
  for (int& id : ids)
    if (id < 0) id = next++;
}

}  // namespace

void match_ids(std::vector<EvolvingSegment>& segments) {
  int next_vertex = 0, next_triangle = 0;
  for (std::size_t s = 0; s < segments.size(); ++s) {
    EvolvingSegment& segment = segments[s];
    std::ranges::fill(segment.vertex_ids, -1);
    segment.triangle_ids.assign(segment.triangles.size(), -1);
    if (s > 0) take_over(segments[s - 1], segment);
    number_the_rest(segment.vertex_ids, next_vertex);
    number_the_rest(segment.triangle_ids, next_triangle);
  }
}

}  // namespace mq
