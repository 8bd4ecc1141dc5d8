// Neighbouring triangles follow each other in most files, so that an edge of one of the last triangles is an edge of
// the next one, and the vertex across is new, or beside that edge on the border of what is known, or was used not
// long ago.

#include "mq/io/detail/triangle_codes.h"

#include <algorithm>

namespace mq {
namespace {

enum TriangleStream : int { place_kind = 0, rotation_kind = 1, vertex_kind = 4, explicit_kind = 5, across_kind = 6 };
enum AcrossCode : int { across_new = 0, across_after = 1, across_before = 2, across_recent = 3 };

}  // namespace

TriangleCoder::TriangleCoder(int first_stream, int vertices)
    : first_(first_stream),
      vertices_(vertices),
      seen_(std::size_t(vertices), 0),
      next_(std::size_t(vertices), -1),
      last_(std::size_t(vertices), -1) {
  recent_.fill(-1);
}

int TriangleCoder::across_stream(const Edge& edge, int place) const {
  const bool has_after = next_[std::size_t(edge.begin)] >= 0, has_before = last_[std::size_t(edge.end)] >= 0;
  return stream(across_kind) + 4 * std::min(place, 2) + 2 * int(has_after) + int(has_before);
}

/// The next one that was not seen after the newest; or, where the next few were, the first of all.
int TriangleCoder::next_new() {
  constexpr int few = 16;
  for (int vertex = newest_ + 1; vertex < std::min(vertices_, newest_ + few); ++vertex)
    if (!seen_[std::size_t(vertex)]) return vertex;
  while (first_new_ < vertices_ && seen_[std::size_t(first_new_)]) ++first_new_;
  return first_new_;
}

void TriangleCoder::see(int vertex) {
  if (seen_[std::size_t(vertex)]) return;
  seen_[std::size_t(vertex)] = 1;
  newest_ = vertex;
}

/// The border goes along b from a where a triangle has that edge and none has b, a.
void TriangleCoder::know(const Triangle& t) {
  std::array<bool, 3> is_border{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto a = std::size_t(t[k]), b = std::size_t(t[(k + 1) % 3]);
    is_border[k] = next_[b] != int(a);
    if (is_border[k]) continue;
    next_[b] = -1;
    if (last_[a] == int(b)) last_[a] = -1;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    see(t[k]);
    if (!is_border[k]) continue;
    next_[std::size_t(t[k])] = t[(k + 1) % 3];
    last_[std::size_t(t[(k + 1) % 3])] = t[k];
  }
}

/// The edges that the next triangle may have, turned as it has them.
void TriangleCoder::remember(const Triangle& t) {
  know(t);
  for (std::size_t k = 0; k < 3; ++k) {
    newest_edge_ = (newest_edge_ + 1) % edges_kept;
    edges_[std::size_t(newest_edge_)] = {t[(k + 1) % 3], t[k]};
    if (std::ranges::find(recent_, t[k]) != recent_.end()) continue;
    newest_vertex_ = (newest_vertex_ + 1) % vertices_kept;
    recent_[std::size_t(newest_vertex_)] = t[k];
  }
  before_ = t[2];
}

void TriangleCoder::put_vertex(SymbolWriter& to, int vertex, int near) {
  if (vertex == next_new())
    to.put(stream(vertex_kind), 0);
  else
    to.put(stream(vertex_kind), 1 + folded(vertex - near));
  see(vertex);
}

int TriangleCoder::get_vertex(SymbolReader& from, int near) {
  const std::uint64_t code = from.get(stream(vertex_kind));
  const std::int64_t vertex =
      code == 0 ? next_new() : std::int64_t(std::uint64_t(near) + std::uint64_t(unfolded(code - 1)));
  if (vertex < 0 || vertex >= vertices_) from.fail("names a vertex that is not there");
  see(int(vertex));
  return int(vertex);
}

void TriangleCoder::put_across(SymbolWriter& to, const Edge& edge, int place, int vertex) {
  const int kind = across_stream(edge, place);
  if (vertex == next_new()) return to.put(kind, across_new);
  if (vertex == next_[std::size_t(edge.begin)]) return to.put(kind, across_after);
  if (vertex == last_[std::size_t(edge.end)]) return to.put(kind, across_before);
  for (int k = 0; k < vertices_kept; ++k)
    if (recent_[std::size_t(known_vertex(k))] == vertex) return to.put(kind, std::uint64_t(across_recent + k));
  to.put(kind, across_recent + vertices_kept);
  to.put_signed(stream(explicit_kind), vertex - edge.begin);
}

int TriangleCoder::get_across(SymbolReader& from, const Edge& edge, int place) {
  const std::size_t code = from.index(across_stream(edge, place), across_recent + vertices_kept + 1);
  std::int64_t vertex = -1;
  if (code == across_new)
    vertex = next_new();
  else if (code == across_after)
    vertex = next_[std::size_t(edge.begin)];
  else if (code == across_before)
    vertex = last_[std::size_t(edge.end)];
  else if (code < across_recent + vertices_kept)
    vertex = recent_[std::size_t(known_vertex(int(code) - across_recent))];
  else
    vertex = std::int64_t(std::uint64_t(edge.begin) + std::uint64_t(from.get_signed(stream(explicit_kind))));
  if (vertex < 0 || vertex >= vertices_) from.fail("names a vertex that is not there");
  return int(vertex);
}

void TriangleCoder::put(SymbolWriter& to, const Triangle& t) {
  for (int place = 0; place < edges_kept; ++place)
    for (int turn = 0; turn < 3; ++turn) {
      const Edge& edge = edges_[std::size_t(known_edge(place))];
      const auto r = std::size_t(turn);
      if (edge.begin != t[r] || edge.end != t[(r + 1) % 3]) continue;
      to.put(stream(place_kind), std::uint64_t(place) + 1);
      to.put(stream(rotation_kind + rotation_), r);
      put_across(to, edge, place, t[(r + 2) % 3]);
      rotation_ = turn;
      return remember(t);
    }
  to.put(stream(place_kind), 0);
  for (std::size_t k = 0; k < 3; ++k) put_vertex(to, t[k], k == 0 ? before_ : t[k - 1]);
  remember(t);
}

Triangle TriangleCoder::get(SymbolReader& from) {
  Triangle t{};
  const int place = int(from.index(stream(place_kind), edges_kept + 1)) - 1;
  if (place < 0) {
    for (std::size_t k = 0; k < 3; ++k) t[k] = get_vertex(from, k == 0 ? before_ : t[k - 1]);
  } else {
    const Edge edge = edges_[std::size_t(known_edge(place))];
    if (edge.begin < 0) from.fail("names an edge that is not there");
    const std::size_t r = from.index(stream(rotation_kind + rotation_), 3);
    t[r] = edge.begin;
    t[(r + 1) % 3] = edge.end;
    t[(r + 2) % 3] = get_across(from, edge, place);
    rotation_ = int(r);
  }
  remember(t);
  return t;
}

}  // namespace mq
