// Vertices and triangles that were there before are told by where they were, nearly always one after the last; those
// that are new by their ids, and triangles by what their corners have to do with the triangles known by then. Of the
// texture coordinates those that were there before are told in the same way, the others are predicted in space.

#include "mq/io/detail/evolving_change.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "mq/base/error.h"
#include "mq/io/detail/evolving_uvs.h"
#include "mq/io/detail/symbol_streams.h"
#include "mq/io/detail/triangle_codes.h"

namespace mq {
namespace {

enum ChangeStream : int {
  count_stream,
  vertex_place_stream,
  vertex_id_stream,
  triangle_place_stream,
  triangle_id_stream,
  same_stream,
  uv_place_stream,
  corner_stream,                                                 // 6 of them
  far_corner_stream = corner_stream + 6,
  uv_stream,
  triangle_stream = uv_stream + uv_streams,
  change_streams = triangle_stream + TriangleCoder::stream_count
};

// Numbers for each vertex, triangle and texture coordinate, at most: place, id; place, id, same, edge, rotation,
// across and how far, or none and three vertices, same, and three corners with where they are; place, u, v.
constexpr std::size_t numbers_each = 16;

/// Where things were in a list, each mostly one after the last.
class Places {
 public:
  void put(SymbolWriter& to, int stream, int place) {
    if (place == new_place) return to.put(stream, 0);
    to.put(stream, 1 + folded(place - expected_));
    expected_ = place + 1;
  }
  int get(SymbolReader& from, int stream, std::size_t count) {
    const std::uint64_t code = from.get(stream);
    if (code == 0) return new_place;
    const std::int64_t place = std::int64_t(std::uint64_t(expected_) + std::uint64_t(unfolded(code - 1)));
    if (place < 0 || std::uint64_t(place) >= count) from.fail("names a place that is not there");
    expected_ = int(place) + 1;
    return int(place);
  }
  int expected() const { return expected_; }

 private:
  int expected_ = 0;
};

std::vector<int> places_of(const std::vector<int>& ids, const std::vector<int>& before) {
  constexpr std::ptrdiff_t few = 64;
  const int most = before.empty() ? -1 : std::ranges::max(before);
  std::vector<std::pair<int, int>> known;  // by id; made once an id is not one of the next few, and may be another
  std::vector<int> places;
  places.reserve(ids.size());
  std::size_t expected = 0;
  for (const int id : ids) {
    int place = new_place;
    const auto next = before.begin() + std::ptrdiff_t(expected);
    const auto end = next + std::min(few, before.end() - next), near = id <= most ? std::find(next, end, id) : end;
    if (near != end) {
      place = int(near - before.begin());
    } else if (id <= most) {
      if (known.empty()) {
        for (std::size_t i = 0; i < before.size(); ++i) known.emplace_back(before[i], int(i));
        std::ranges::sort(known);
      }
      const auto found = std::ranges::lower_bound(known, id, {}, &std::pair<int, int>::first);
      if (found != known.end() && found->first == id) place = found->second;
    }
    if (place != new_place) expected = std::size_t(place) + 1;
    places.push_back(place);
  }
  return places;
}

void put_ids(SymbolWriter& to, const std::vector<int>& ids, const std::vector<int>& before, int place_stream,
             int id_stream) {
  Places places;
  int expected = 0;
  const std::vector<int> from = places_of(ids, before);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    places.put(to, place_stream, from[i]);
    if (from[i] != new_place) continue;
    to.put_signed(id_stream, std::int64_t(ids[i]) - expected);
    expected = int(std::min<std::int64_t>(std::int64_t(ids[i]) + 1, std::numeric_limits<int>::max()));
  }
}

std::vector<int> get_ids(SymbolReader& from, std::size_t count, const std::vector<int>& before, int place_stream,
                         int id_stream, std::vector<int>& found) {
  Places places;
  std::vector<int> ids(count);
  found.resize(count);
  int expected = 0;
  for (std::size_t i = 0; i < count; ++i) {
    found[i] = places.get(from, place_stream, before.size());
    if (found[i] != new_place) {
      ids[i] = before[std::size_t(found[i])];
      continue;
    }
    const auto id = std::int64_t(std::uint64_t(expected) + std::uint64_t(from.get_signed(id_stream)));
    if (id < 0 || id > std::numeric_limits<int>::max()) from.fail("holds an id out of range");
    ids[i] = int(id);
    expected = int(std::min<std::int64_t>(id + 1, std::numeric_limits<int>::max()));
  }
  return ids;
}

/// Where each thing of the segment before is now, -1: nowhere.
std::vector<int> places_now(const std::vector<int>& places, std::size_t count) {
  std::vector<int> now(count, -1);
  for (std::size_t i = 0; i < places.size(); ++i)
    if (places[i] != new_place) now[std::size_t(places[i])] = int(i);
  return now;
}

/// A triangle of before with what its corners are now; false where one of them is gone.
bool carried(const Triangle& before, const std::vector<int>& now, Triangle& result) {
  for (std::size_t k = 0; k < 3; ++k) {
    result[k] = before[k] < 0 ? -1 : now[std::size_t(before[k])];
    if (before[k] >= 0 && result[k] < 0) return false;
  }
  return true;
}

// ---- Texture coordinates of corners ----

/// The texture coordinates that each vertex had last, newest first.
class CornerCoder {
 public:
  CornerCoder(std::size_t vertices, std::size_t uvs) : recent_(vertices, {-1, -1, -1, -1}), seen_(uvs, 0) {}

  void know(const Triangle& triangle, const Triangle& uvs) {
    for (std::size_t k = 0; k < 3; ++k) use(triangle[k], uvs[k]);
  }

  void put(SymbolWriter& to, const Triangle& triangle, const Triangle& uvs) {
    bool as_before = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& recent = recent_[std::size_t(triangle[k])];
      const int stream = stream_of(recent, k, as_before);
      const std::size_t code = code_of(recent, triangle[k], uvs[k]);
      to.put(stream, code);
      if (code == far) to.put_signed(far_corner_stream, std::int64_t(uvs[k]) - expected(triangle[k]));
      as_before = as_before && code == 0;
      use(triangle[k], uvs[k]);
    }
  }

  Triangle get(SymbolReader& from, const Triangle& triangle) {
    Triangle uvs{};
    bool as_before = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& recent = recent_[std::size_t(triangle[k])];
      const std::size_t code = from.index(stream_of(recent, k, as_before), far + 1);
      std::int64_t uv = -1;
      if (code < recent.size())
        uv = recent[code];
      else if (code != none)
        uv = expected(triangle[k]);
      if (code == far)
        uv = std::int64_t(std::uint64_t(uv) + std::uint64_t(from.get_signed(far_corner_stream)));
      if (uv < -1 || uv >= std::ssize(seen_)) from.fail("names a texture coordinate that is not there");
      as_before = as_before && code == 0;
      uvs[k] = int(uv);
      use(triangle[k], uvs[k]);
    }
    return uvs;
  }

 private:
  static constexpr std::size_t fresh = 4, none = 5, far = 6;

  static int stream_of(const std::array<int, 4>& recent, std::size_t corner, bool as_before) {
    return corner_stream + 3 * int(recent[0] >= 0) + (corner == 0 ? 0 : as_before ? 1 : 2);
  }
  std::size_t code_of(const std::array<int, 4>& recent, int vertex, int uv) const {
    if (uv < 0) return none;
    const auto found = std::ranges::find(recent, uv);
    if (found != recent.end()) return std::size_t(found - recent.begin());
    return uv == expected(vertex) ? fresh : far;
  }
  /// Those that are new mostly have the order of vertices.
  std::int64_t expected(int vertex) const { return std::int64_t(vertex) + offset_; }
  void use(int vertex, int uv) {
    if (uv < 0) return;
    if (!seen_[std::size_t(uv)]) offset_ = std::int64_t(uv) - vertex;
    seen_[std::size_t(uv)] = 1;
    auto& recent = recent_[std::size_t(vertex)];
    auto found = std::ranges::find(recent, uv);
    if (found == recent.end()) *--found = uv;
    std::rotate(recent.begin(), found, found + 1);
  }

  std::vector<std::array<int, 4>> recent_;
  std::vector<char> seen_;
  std::int64_t offset_ = 0;  ///< of the one seen for the first time last, from its vertex
};

// ---- All of it ----

std::size_t entry_count(const EvolvingSegment& segment) {
  return segment.vertex_ids.size() + segment.triangle_ids.size() + segment.uvs.size();
}

/// What a triangle of a segment has of the one it was.
constexpr std::uint64_t same_corners = 1, same_uvs = 2;

std::uint64_t what_is_same(const EvolvingSegment& segment, const EvolvingSegment& before, std::size_t t, int place,
                   const std::vector<int>& vertices, const std::vector<int>& uvs) {
  if (place == new_place) return 0;
  Triangle found{};
  std::uint64_t result = 0;
  if (carried(before.triangles[std::size_t(place)], vertices, found) && found == segment.triangles[t])
    result |= same_corners;
  if (!segment.corner_uvs.empty() && !before.corner_uvs.empty() &&
      carried(before.corner_uvs[std::size_t(place)], uvs, found) && found == segment.corner_uvs[t])
    result |= same_uvs;
  return result;
}

/// The coders of corners, that know the triangles which are as they were.
struct CornerCoders {
  TriangleCoder triangles;
  CornerCoder uvs;

  CornerCoders(const EvolvingSegment& segment, const std::vector<std::uint64_t>& same)
      : triangles(triangle_stream, segment.vertex_count()), uvs(segment.vertex_ids.size(), segment.uvs.size()) {
    for (std::size_t t = 0; t < same.size(); ++t) {
      if (same[t] & same_corners) triangles.know(segment.triangles[t]);
      if (same[t] == (same_corners | same_uvs)) uvs.know(segment.triangles[t], segment.corner_uvs[t]);
    }
  }
};

}  // namespace

std::vector<int> vertices_before(const EvolvingSegment& segment, const EvolvingSegment& before) {
  return places_of(segment.vertex_ids, before.vertex_ids);
}

CodingOrder order_of(const EvolvingSegment& segment, const MotionState& motion) {
  return {segment.triangles, segment.vertex_count(),
          motion.empty() ? CodingOrder::Parallelograms::found : CodingOrder::Parallelograms::none};
}

Bytes encode_change(const EvolvingSegment& segment, const EvolvingSegment& before, double uv_step) {
  SymbolWriter to(change_streams);
  const std::size_t triangles = segment.triangles.size();
  for (const std::size_t count : {segment.vertex_ids.size(), triangles, segment.uvs.size()})
    to.put(count_stream, count);
  to.put(count_stream, segment.corner_uvs.empty() ? 0 : 1);
  put_ids(to, segment.vertex_ids, before.vertex_ids, vertex_place_stream, vertex_id_stream);
  put_ids(to, segment.triangle_ids, before.triangle_ids, triangle_place_stream, triangle_id_stream);
  EvolvingSegment stored = segment;
  stored.uvs = rounded_uvs(std::move(stored.uvs), uv_step);
  const std::vector<int> uv_places = uvs_before(stored.uvs, before.uvs);
  Places places;
  for (const int place : uv_places) places.put(to, uv_place_stream, place);

  const std::vector<int> vertices_now = places_now(vertices_before(segment, before), before.vertex_ids.size()),
                         uvs_now = places_now(uv_places, before.uvs.size()),
                         triangle_places = places_of(segment.triangle_ids, before.triangle_ids);
  std::vector<std::uint64_t> sames(triangles);
  for (std::size_t t = 0; t < triangles; ++t) {
    sames[t] = what_is_same(segment, before, t, triangle_places[t], vertices_now, uvs_now);
    if (triangle_places[t] != new_place) to.put(same_stream, sames[t]);
  }
  CornerCoders corners(segment, sames);
  for (std::size_t t = 0; t < triangles; ++t) {
    if (!(sames[t] & same_corners)) corners.triangles.put(to, segment.triangles[t]);
    if (!segment.corner_uvs.empty() && !(sames[t] & same_uvs))
      corners.uvs.put(to, segment.triangles[t], segment.corner_uvs[t]);
  }
  put_uvs(to, count_stream, uv_stream, stored, uv_places, uv_step);
  Bytes bytes = to.bytes();
  const std::size_t added = entry_count(segment) - std::min(entry_count(segment), entry_count(before));
  bytes.resize(std::max(bytes.size(), added / std::size_t(most_added_per_byte) + 1));
  return bytes;
}

EvolvingSegment decode_change(ByteView bytes, const EvolvingSegment& before, const std::string& what) {
  const std::size_t most = entry_count(before) + std::size_t(most_added_per_byte) * bytes.size();
  SymbolReader from(bytes, change_streams, numbers_each * (most + 1), what);
  EvolvingSegment segment;
  const std::size_t vertices = from.index(count_stream, most + 1),
                    triangles = from.index(count_stream, most + 1 - vertices),
                    uvs = from.index(count_stream, most + 1 - vertices - triangles);
  const bool has_uvs = from.index(count_stream, 2) == 1;
  std::vector<int> vertex_places, triangle_places, uv_places(uvs);
  segment.vertex_ids =
      get_ids(from, vertices, before.vertex_ids, vertex_place_stream, vertex_id_stream, vertex_places);
  segment.triangle_ids =
      get_ids(from, triangles, before.triangle_ids, triangle_place_stream, triangle_id_stream, triangle_places);
  segment.uvs.resize(uvs, Vector2::Zero());
  Places places;
  for (std::size_t i = 0; i < uvs; ++i) {
    uv_places[i] = places.get(from, uv_place_stream, before.uvs.size());
    if (uv_places[i] != new_place) segment.uvs[i] = before.uvs[std::size_t(uv_places[i])];
  }

  const std::vector<int> vertices_now = places_now(vertex_places, before.vertex_ids.size()),
                         uvs_now = places_now(uv_places, before.uvs.size());
  segment.triangles.resize(triangles);
  if (has_uvs) segment.corner_uvs.resize(triangles);
  std::vector<std::uint64_t> sames(triangles);
  for (std::size_t t = 0; t < triangles; ++t) {
    if (triangle_places[t] == new_place) continue;
    const auto place = std::size_t(triangle_places[t]);
    sames[t] = from.index(same_stream, 4);
    if (sames[t] & same_corners && !carried(before.triangles[place], vertices_now, segment.triangles[t]))
      from.fail("keeps a triangle whose vertices are gone");
    if (sames[t] & same_uvs && (!has_uvs || before.corner_uvs.empty() ||
                                !carried(before.corner_uvs[place], uvs_now, segment.corner_uvs[t])))
      from.fail("keeps texture coordinates that are gone");
  }
  CornerCoders corners(segment, sames);
  for (std::size_t t = 0; t < triangles; ++t) {
    if (!(sames[t] & same_corners)) segment.triangles[t] = corners.triangles.get(from);
    if (has_uvs && !(sames[t] & same_uvs)) segment.corner_uvs[t] = corners.uvs.get(from, segment.triangles[t]);
  }
  get_uvs(from, count_stream, uv_stream, segment, uv_places);
  from.end();
  try {
    check(segment);
  } catch (const InvalidInput& error) {
    from.fail(fmt::format("says nothing sensible: {}", error.what()));
  }
  return segment;
}

}  // namespace mq
