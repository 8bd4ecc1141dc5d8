// New triangles laid beside pieces that are there, so that they need no chart of their own. What several
// pieces surround is parted between them, each part beside its own; what is small is moved there.

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <queue>
#include <tuple>

#include "mq/evolving/detail/extended_chart.h"
#include "mq/evolving/detail/filled_hole.h"
#include "mq/evolving/detail/free_texels.h"
#include "mq/evolving/detail/parts_of.h"
#include "mq/evolving/detail/rolling_atlas.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/weld.h"

namespace mq {
namespace {

/// Of what is left when a part was laid beside the pieces around it, how often it is tried again.
constexpr int most_rounds = 4;
/// Where a part does not fit beside the pieces around it, so many rings of triangles around it are moved with it.
constexpr std::array rings_moved = {0, 1, 3};
/// Of all triangles, those of a chart that is moved beside others.
constexpr double small_share = 1.0 / 50;

/// Of a patch the triangles that are accepted, one after the other: those at these edges, whose ends are
/// fixed, and those beside one that is accepted. `sources` are the surface's triangles, which edges are of.
template <class Accepts>
std::vector<int> from_shore(const std::vector<int>& sources, const HolePatch& patch,
                            const std::vector<HalfEdge>& edges, const Accepts& accepts) {
  std::map<std::pair<int, int>, std::vector<int>> by_edge;
  std::unordered_map<int, int> local;
  for (int t = 0; t < int(sources.size()); ++t) {
    local[sources[t]] = t;
    for (int k = 0; k < 3; ++k)
      by_edge[std::minmax({patch.triangles[t][k], patch.triangles[t][(k + 1) % 3]})].push_back(t);
  }
  std::queue<int> open;
  std::vector<char> seen(sources.size(), 0);
  for (const HalfEdge h : edges) {
    const auto t = local.find(h / 3);
    if (t == local.end() || seen[t->second]) continue;
    const Triangle& corners = patch.triangles[t->second];
    if (!patch.fixed[corners[h % 3]] || !patch.fixed[corners[(h + 1) % 3]]) continue;
    seen[t->second] = 1;
    open.push(t->second);
  }
  std::vector<int> accepted;
  for (; !open.empty(); open.pop()) {
    const int t = open.front();
    if (!accepts(t)) continue;
    accepted.push_back(t);
    for (int k = 0; k < 3; ++k)
      for (const int other : by_edge[std::minmax({patch.triangles[t][k], patch.triangles[t][(k + 1) % 3]})])
        if (!seen[other]) seen[other] = 1, open.push(other);
  }
  return accepted;
}

}  // namespace

/// Triangles laid beside a piece: those that fit there and hang together with it.
struct RollingAtlas::Extended {
  int piece = -1;
  std::vector<int> triangles = {};
  std::vector<Triangle> corners = {};           ///< per triangle, of the vertices below
  std::vector<std::vector<Vector2>> laid = {};  ///< likewise, in texels
  std::vector<int> uv_of = {};                  ///< per vertex, that of the piece; −1: it has none yet
  std::vector<Vector2> places = {};             ///< per vertex, in texels
};

std::vector<HalfEdge> RollingAtlas::twins() const {
  return make_surface(mesh_of(film_.segments[periods_[now_].segment], film_.frames[periods_[now_].first].positions),
                      {.kind = WeldOptions::Kind::none})
      .twins;
}

/// The longest first.
std::vector<RollingAtlas::Shore> RollingAtlas::shores_of(const std::vector<int>& triangles,
                                                         const std::vector<HalfEdge>& twins) const {
  const EvolvingSegment& segment = film_.segments[periods_[now_].segment];
  const std::unordered_set<int> own(triangles.begin(), triangles.end());
  struct Edge {
    HalfEdge edge;
    int piece;
    std::array<int, 2> vertices, uvs;
  };
  std::vector<Edge> edges;
  for (const int t : triangles)
    for (int k = 0; k < 3; ++k) {
      const HalfEdge across = twins[3 * t + k];
      if (across < 0 || own.contains(across / 3)) continue;
      const auto home = homes_.find(segment.triangle_ids[across / 3]);
      if (home == homes_.end() || pieces_[home->second.piece].scale != scale_) continue;
      const Piece& piece = pieces_[home->second.piece];
      Edge edge{3 * t + k, home->second.piece, {}, {}};
      for (int end = 0; end < 2; ++end) {
        edge.vertices[end] = segment.triangles[t][(k + end) % 3];
        const Triangle& ids = piece.vertex_ids[home->second.index];
        const auto at = std::ranges::find(ids, segment.vertex_ids[edge.vertices[end]]);
        edge.uvs[end] = at == ids.end() ? -1 : piece.corners[home->second.index][at - ids.begin()];
      }
      if (edge.uvs[0] >= 0 && edge.uvs[1] >= 0) edges.push_back(edge);
    }
  DisjointSets sets(edges.size());
  std::map<std::pair<int, int>, int> edge_at;  // of piece and texture coordinates
  for (int e = 0; e < int(edges.size()); ++e)
    for (const int uv : edges[e].uvs) sets.join(e, edge_at.try_emplace({edges[e].piece, uv}, e).first->second);
  std::map<int, Shore> by_root;
  for (int e = 0; e < int(edges.size()); ++e) {
    const Edge& edge = edges[e];
    Shore& shore = by_root[sets.root(e)];
    shore.piece = edge.piece;
    shore.edges.push_back(edge.edge);
    shore.length += (positions_[edge.vertices[1]] - positions_[edge.vertices[0]]).norm();
    for (int end = 0; end < 2; ++end) {
      const auto [place, is_new] = shore.uv_of.try_emplace(edge.vertices[end], edge.uvs[end]);
      if (!is_new && place->second != edge.uvs[end]) place->second = -1;
    }
  }
  std::vector<Shore> shores;
  for (auto& [root, shore] : by_root) shores.push_back(std::move(shore));
  std::ranges::stable_sort(shores, std::ranges::greater{}, &Shore::length);
  return shores;
}

/// What of connected triangles fits beside a piece, laid as rigidly as can be.
RollingAtlas::Extended RollingAtlas::extended(const std::vector<int>& triangles, const Shore& shore,
                                              const Taken& taken) const {
  HoleBorder border{.piece = shore.piece, .edges = 0};
  for (const auto& [vertex, uv] : shore.uv_of)
    if (uv >= 0) border.uv_of.emplace(vertex, uv);
  std::vector<int> vertices;
  const HolePatch patch = patch_of(triangles, border, vertices);
  const auto found = extended_chart(patch);
  Extended result{.piece = shore.piece};
  if (!found) return result;
  std::vector<std::vector<Vector2>> laid;
  std::vector<Vector2> all;
  for (const Triangle& t : patch.triangles) {
    laid.push_back({found->places[t[0]], found->places[t[1]], found->places[t[2]]});
    all.insert(all.end(), laid.back().begin(), laid.back().end());
  }
  if (!std::ranges::all_of(all, [](const Vector2& p) { return p.allFinite(); })) return result;
  std::vector<char> own;
  for (const int piece : taken.pieces) own.push_back(piece == shore.piece);
  const UnwrapOptions& unwrap = options_.unwrap;
  FreeTexels free(taken.polygons, own, all, unwrap.width, unwrap.height, unwrap.gutter);
  const auto accepts = [&](int t) {
    if (!found->sound[t] || !free.fits(laid[t])) return false;
    free.take(laid[t]);
    return true;
  };
  for (const int t : from_shore(triangles, patch, shore.edges, accepts)) {
    result.triangles.push_back(triangles[t]);
    result.corners.push_back(patch.triangles[t]);
    result.laid.push_back(laid[t]);
  }
  result.places = found->places;
  for (const int v : vertices) {
    const auto uv = border.uv_of.find(v);
    result.uv_of.push_back(uv != border.uv_of.end() ? uv->second : -1);
  }
  return result;
}

void RollingAtlas::add_triangle(int number, int triangle, const Triangle& uvs, std::vector<Vector2> laid,
                                Taken& taken) {
  const EvolvingSegment& segment = film_.segments[periods_[now_].segment];
  Piece& piece = pieces_[number];
  const int id = segment.triangle_ids[triangle];
  Triangle ids;
  for (int k = 0; k < 3; ++k) ids[k] = segment.vertex_ids[segment.triangles[triangle][k]];
  homes_[id] = {number, int(piece.ids.size())};
  piece.ids.push_back(id);
  piece.vertex_ids.push_back(ids);
  piece.corners.push_back(uvs);
  piece.areas.push_back(cross(laid[1] - laid[0], laid[2] - laid[0]) / 2 / (scale_ * scale_));
  piece.since.push_back(now_);
  piece.last.push_back(now_ - 1);  // until it is written
  taken.polygons.push_back(std::move(laid));
  taken.pieces.push_back(number);
}

void RollingAtlas::put(const Extended& extended, Taken& taken) {
  const Vector2 size(options_.unwrap.width, options_.unwrap.height);
  Piece& piece = pieces_[extended.piece];
  std::vector<int> uv_of = extended.uv_of;
  for (std::size_t i = 0; i < extended.triangles.size(); ++i) {
    Triangle uvs;
    for (int k = 0; k < 3; ++k) {
      int& uv = uv_of[extended.corners[i][k]];
      if (uv < 0) {
        uv = int(piece.uvs.size());
        piece.uvs.push_back(extended.places[extended.corners[i][k]].cwiseQuotient(size));
      }
      uvs[k] = uv;
    }
    add_triangle(extended.piece, extended.triangles[i], uvs, extended.laid[i], taken);
  }
}

/// Lays a part as a whole beside one of the pieces around it; whether it fits.
bool RollingAtlas::extend_whole(const std::vector<int>& part, const std::vector<HalfEdge>& twins, Taken& taken) {
  for (const Shore& shore : shores_of(part, twins)) {
    const Extended all = extended(part, shore, taken);
    if (all.triangles.size() < part.size()) continue;
    put(all, taken);
    return true;
  }
  return false;
}

/// Lays of a part beside each piece around it what is nearest to it and fits. Returns what does not.
std::vector<int> RollingAtlas::extend_split(const std::vector<int>& part, const std::vector<HalfEdge>& twins,
                                            Taken& taken) {
  const EvolvingSegment& segment = film_.segments[periods_[now_].segment];
  const auto middle = [&](int t) -> Vector3 {
    const Triangle& v = segment.triangles[t];
    return (positions_[v[0]] + positions_[v[1]] + positions_[v[2]]) / 3;
  };
  const std::vector<Shore> shores = shores_of(part, twins);
  using Way = std::tuple<double, int, int>;  // length, shore, triangle
  std::priority_queue<Way, std::vector<Way>, std::greater<>> open;
  for (int s = 0; s < int(shores.size()); ++s)
    for (const HalfEdge h : shores[s].edges) {
      const Triangle& v = segment.triangles[h / 3];
      const Vector3 edge = (positions_[v[h % 3]] + positions_[v[(h + 1) % 3]]) / 2;
      open.push({(middle(h / 3) - edge).norm(), s, h / 3});
    }
  const std::unordered_set<int> own(part.begin(), part.end());
  std::unordered_map<int, int> shore_of;
  while (!open.empty()) {
    const auto [length, s, t] = open.top();
    open.pop();
    if (!shore_of.try_emplace(t, s).second) continue;
    for (int k = 0; k < 3; ++k)
      if (const HalfEdge across = twins[3 * t + k]; across >= 0 && own.contains(across / 3))
        open.push({length + (middle(across / 3) - middle(t)).norm(), s, across / 3});
  }
  std::unordered_set<int> left = own;
  for (int s = 0; s < int(shores.size()); ++s) {
    std::vector<int> mine;
    for (const int t : part)
      if (const auto of = shore_of.find(t); of != shore_of.end() && of->second == s) mine.push_back(t);
    if (mine.empty()) continue;
    const Extended some = extended(mine, shores[s], taken);
    put(some, taken);
    for (const int t : some.triangles) left.erase(t);
  }
  std::vector<int> result;
  for (const int t : part)
    if (left.contains(t)) result.push_back(t);
  return result;
}

/// Removes what was added to pieces.
void RollingAtlas::take_back(const std::vector<Before>& before) {
  for (const Before& at : before) {
    Piece& piece = pieces_[at.piece];
    for (std::size_t i = at.triangles; i < piece.ids.size(); ++i) homes_.erase(piece.ids[i]);
    piece.ids.resize(at.triangles);
    piece.vertex_ids.resize(at.triangles);
    piece.corners.resize(at.triangles);
    piece.areas.resize(at.triangles);
    piece.since.resize(at.triangles);
    piece.last.resize(at.triangles);
    piece.uvs.resize(at.uvs);
  }
}

/// Lays a part, none of which has a place, beside the pieces around it, and adds it to what is taken; whether
/// all of it fits: else none is.
bool RollingAtlas::take_in(const std::vector<int>& part, const std::vector<HalfEdge>& twins, Taken& taken) {
  if (refill_hole(part, twins, taken)) return true;
  std::vector<Before> before;
  for (int p = 0; p < int(pieces_.size()); ++p) before.push_back({p, pieces_[p].ids.size(), pieces_[p].uvs.size()});
  const std::size_t taken_before = taken.polygons.size();
  std::vector<std::vector<int>> open = {part};
  for (int round = 0; round < most_rounds && !open.empty(); ++round) {
    std::vector<std::vector<int>> next;
    for (const std::vector<int>& one : open) {
      if (extend_whole(one, twins, taken)) continue;
      for (auto& rest : parts_of(extend_split(one, twins, taken), twins)) next.push_back(std::move(rest));
    }
    open = std::move(next);
  }
  if (open.empty()) return true;
  take_back(before);
  taken.polygons.resize(taken_before);
  taken.pieces.resize(taken_before);
  return false;
}

/// Lays what is new beside the pieces around it, where it fits; then what is small.
void RollingAtlas::extend_pieces() {
  const EvolvingSegment& segment = film_.segments[periods_[now_].segment];
  const std::vector<HalfEdge> across = twins();
  std::vector<int> fresh;
  for (int t = 0; t < segment.triangle_count(); ++t) {
    const Triangle& v = segment.triangles[t];
    if (v[0] != v[1] && v[1] != v[2] && v[2] != v[0] && !homes_.contains(segment.triangle_ids[t]))
      fresh.push_back(t);
  }
  if (fresh.empty()) return;
  for (const std::vector<int>& part : parts_of(fresh, across)) move_in(part, across);
  absorb_small(across);
}

/// Moves small charts beside those around them, where all of one fits.
void RollingAtlas::absorb_small(const std::vector<HalfEdge>& twins) {
  const EvolvingSegment& segment = film_.segments[periods_[now_].segment];
  std::map<int, std::vector<int>> by_piece;
  int all = 0;
  for (int t = 0; t < segment.triangle_count(); ++t)
    if (const auto home = homes_.find(segment.triangle_ids[t]); home != homes_.end()) {
      by_piece[home->second.piece].push_back(t);
      ++all;
    }
  std::vector<std::vector<int>> small;
  for (const auto& [number, triangles] : by_piece)
    for (std::vector<int>& part : parts_of(triangles, twins))
      if (double(part.size()) <= small_share * all) small.push_back(std::move(part));
  std::ranges::stable_sort(small, {}, &std::vector<int>::size);
  for (const std::vector<int>& part : small) move_in(part, twins);
}

/// The triangles that have a corner in common with a part, and those that have one in common with these, and so on.
std::vector<int> RollingAtlas::with_rings(const std::vector<int>& part, int rings) const {
  const EvolvingSegment& segment = film_.segments[periods_[now_].segment];
  std::vector<char> near(segment.vertex_ids.size(), 0), chosen(segment.triangles.size(), 0);
  for (const int t : part) chosen[t] = 1;
  for (int ring = 0; ring < rings; ++ring) {
    for (int t = 0; t < segment.triangle_count(); ++t)
      if (chosen[t])
        for (const int v : segment.triangles[t]) near[v] = 1;
    for (int t = 0; t < segment.triangle_count(); ++t)
      if (homes_.contains(segment.triangle_ids[t]))
        for (const int v : segment.triangles[t]) chosen[t] = char(chosen[t] | near[v]);
  }
  std::vector<int> result;
  for (int t = 0; t < segment.triangle_count(); ++t)
    if (chosen[t]) result.push_back(t);
  return result;
}

/// Lays a part, wherever it is, beside the pieces around it; where it does not fit, together with what is around
/// it, which is moved then.
bool RollingAtlas::move_in(const std::vector<int>& part, const std::vector<HalfEdge>& twins) {
  const EvolvingSegment& segment = film_.segments[periods_[now_].segment];
  for (const int rings : rings_moved) {
    std::vector<std::pair<int, Home>> before;
    std::unordered_set<int> ids;
    const std::vector<int> all = rings > 0 ? with_rings(part, rings) : part;
    for (const int t : all) {
      const auto home = homes_.find(segment.triangle_ids[t]);
      if (home == homes_.end()) continue;
      before.push_back(*home);
      ids.insert(home->first);
    }
    Taken taken = taken_without(ids);
    for (const int id : ids) homes_.erase(id);
    if (take_in(all, twins, taken)) return true;
    for (const auto& [id, home] : before) homes_[id] = home;
  }
  return false;
}

}  // namespace mq
