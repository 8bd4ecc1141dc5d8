// What is replaced inside of a chart leaves a hole in it, whose border stays where it is in the texture.
// New triangles that fit into it go there: the chart goes on, and no seam comes of them.

#include <algorithm>
#include <map>
#include <optional>
#include <unordered_map>
#include <unordered_set>

#include "mq/evolving/detail/filled_hole.h"
#include "mq/evolving/detail/flattened_charts.h"
#include "mq/evolving/detail/parts_of.h"
#include "mq/evolving/detail/rolling_atlas.h"
#include "mq/evolving/detail/rolling_plan.h"

namespace mq {
namespace {

/// Whether a triangle of these has an area in common with one of those.
bool any_overlap(const std::vector<std::vector<Vector2>>& these,
                 const std::vector<std::vector<Vector2>>& those) {
  Vector2 low = these[0][0], high = low;
  for (const auto& t : these)
    for (const Vector2& p : t) low = low.cwiseMin(p), high = high.cwiseMax(p);
  return std::ranges::any_of(those, [&](const std::vector<Vector2>& other) {
    for (const int axis : {0, 1}) {
      const auto [least, most] = std::minmax({other[0][axis], other[1][axis], other[2][axis]});
      if (most <= low[axis] || least >= high[axis]) return false;
    }
    return std::ranges::any_of(
        these, [&](const std::vector<Vector2>& t) { return overlap(t, other); });
  });
}

}  // namespace

/// The one piece all around a part, and its texture coordinates at the part's border; nothing where there
/// are several, none, or one that is torn there.
std::optional<RollingAtlas::HoleBorder> RollingAtlas::border_of(
    const std::vector<int>& triangles, const std::vector<HalfEdge>& twins) const {
  const EvolvingSegment& segment = film_.segments[periods_[now_].segment];
  const std::unordered_set<int> own(triangles.begin(), triangles.end());
  HoleBorder border;
  for (const int t : triangles)
    for (int k = 0; k < 3; ++k) {
      const HalfEdge across = twins[3 * t + k];
      if (across >= 0 && own.contains(across / 3)) continue;
      const auto home =
          across < 0 ? homes_.end() : homes_.find(segment.triangle_ids[across / 3]);
      if (home == homes_.end()) return {};
      const auto [number, index] = home->second;
      if (border.piece >= 0 && number != border.piece) return {};
      border.piece = number;
      ++border.edges;
      const Piece& piece = pieces_[number];
      for (const int v : {segment.triangles[t][k], segment.triangles[t][(k + 1) % 3]}) {
        const Triangle& ids = piece.vertex_ids[index];
        const auto at = std::ranges::find(ids, segment.vertex_ids[v]);
        if (at == ids.end()) return {};
        const int uv = piece.corners[index][at - ids.begin()];
        if (const auto [place, is_new] = border.uv_of.try_emplace(v, uv);
            !is_new && place->second != uv)
          return {};
      }
    }
  // As many vertices as edges: loops that do not touch. V - E + T of a disc, one of them.
  std::unordered_set<int> vertices;
  for (const int t : triangles)
    for (const int v : segment.triangles[t]) vertices.insert(v);
  const int edges = (3 * int(triangles.size()) + border.edges) / 2;
  if (border.piece < 0 || pieces_[border.piece].scale != scale_ ||
      std::ssize(border.uv_of) != border.edges ||
      int(vertices.size()) - edges + int(triangles.size()) != 1)
    return {};
  return border;
}

/// A part as something to lay into a hole, with the vertices of the segment that it has.
HolePatch RollingAtlas::patch_of(const std::vector<int>& triangles, const HoleBorder& border,
                                 std::vector<int>& vertices) const {
  const EvolvingSegment& segment = film_.segments[periods_[now_].segment];
  const Vector2 size(options_.unwrap.width, options_.unwrap.height);
  HolePatch patch;
  std::unordered_map<int, int> local;
  for (const int t : triangles) {
    Triangle corners;
    for (int k = 0; k < 3; ++k) {
      const int v = segment.triangles[t][k];
      const auto [place, is_new] = local.try_emplace(v, int(vertices.size()));
      corners[k] = place->second;
      if (!is_new) continue;
      vertices.push_back(v);
      const auto uv = border.uv_of.find(v);
      patch.fixed.push_back(uv != border.uv_of.end());
      patch.positions.push_back(positions_[v] * scale_);
      patch.places.push_back(Vector2::Zero());
      if (patch.fixed.back())
        patch.places.back() = pieces_[border.piece].uvs[uv->second].cwiseProduct(size);
    }
    patch.triangles.push_back(corners);
  }
  return patch;
}

/// Puts a part, a disc, into the hole of a piece; whether it fits there. All around it must be one piece.
bool RollingAtlas::refill_hole(const std::vector<int>& triangles,
                               const std::vector<HalfEdge>& twins, Taken& taken) {
  const Vector2 size(options_.unwrap.width, options_.unwrap.height);
  const std::optional<HoleBorder> border = border_of(triangles, twins);
  if (!border) return false;
  std::vector<int> vertices;
  const HolePatch patch = patch_of(triangles, *border, vertices);
  const auto filled = filled_hole(patch);
  if (!filled) return false;
  std::vector<std::vector<Vector2>> laid;
  for (const Triangle& t : patch.triangles)
    laid.push_back({(*filled)[t[0]], (*filled)[t[1]], (*filled)[t[2]]});
  if (any_overlap(laid, taken.polygons)) return false;
  Piece& piece = pieces_[border->piece];
  std::vector<int> uv_of_local;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (patch.fixed[i]) {
      uv_of_local.push_back(border->uv_of.at(vertices[i]));
      continue;
    }
    uv_of_local.push_back(int(piece.uvs.size()));
    piece.uvs.push_back((*filled)[i].cwiseQuotient(size));
  }
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    Triangle uvs;
    for (int k = 0; k < 3; ++k) uvs[k] = uv_of_local[patch.triangles[i][k]];
    add_triangle(border->piece, triangles[i], uvs, std::move(laid[i]), taken);
  }
  return true;
}

/// Puts what it can of charts all of whose triangles are new beside pieces that are there, and adds it to what
/// is taken. Returns what is left of all charts, by chains.
std::vector<std::pair<int, std::vector<int>>> RollingAtlas::refill(const std::vector<int>& charts,
                                                                   Taken& taken) {
  const EvolvingSegment& segment = film_.segments[periods_[now_].segment];
  const std::vector<HalfEdge> across = twins();
  std::unordered_map<int, int> triangle_of;
  for (int t = 0; t < segment.triangle_count(); ++t) triangle_of[segment.triangle_ids[t]] = t;
  std::vector<std::pair<int, std::vector<int>>> left;
  for (const int c : charts) {
    const std::vector<int>& chains = plan_->charting.charts[c].chains;
    std::vector<int> triangles;
    for (const int chain : chains)
      triangles.push_back(triangle_of.at(plan_->graph.chains[chain].triangle));
    const bool is_new = std::ranges::none_of(
        triangles, [&](int t) { return homes_.contains(segment.triangle_ids[t]); });
    if (!is_new) {
      left.emplace_back(c, chains);
      continue;
    }
    std::vector<int> rest;
    for (const std::vector<int>& part : parts_of(triangles, across))
      if (!take_in(part, across, taken))
        for (const int t : part) rest.push_back(plan_->chain_of.at(segment.triangle_ids[t]));
    std::ranges::sort(rest);
    if (!rest.empty()) left.emplace_back(c, std::move(rest));
  }
  return left;
}

}  // namespace mq
