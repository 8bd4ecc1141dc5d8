// Charts begin and end with segments, so that within a segment texture coordinates are constant,
// and a chart's triangles are connected alike in all of its life.

#include "mq/evolving/detail/rolling_atlas.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <unordered_set>

#include "mq/evolving/detail/flattened_charts.h"
#include "mq/evolving/detail/free_texels.h"
#include "mq/evolving/detail/rolling_plan.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

/// Of half a chart for which there was no room, at least.
constexpr std::size_t least_triangles = 8;

double area(const Triangle& t, const Points& x) {
  const Vector2 a = x[t[1]] - x[t[0]], b = x[t[2]] - x[t[0]];
  return (a.x() * b.y() - a.y() * b.x()) / 2;
}

/// A triangle's corner with this vertex.
int corner(const EvolvingSegment& segment, int triangle, int vertex_id) {
  for (int k = 0; k < 3; ++k)
    if (segment.vertex_ids[segment.triangles[triangle][k]] == vertex_id) return k;
  return 0;
}

/// Triangles with two equal vertices, at a corner that a chart has.
void place_collapsed(EvolvingSegment& segment) {
  std::vector<int> at_vertex(segment.vertex_ids.size(), -1);
  for (int t = 0; t < segment.triangle_count(); ++t)
    for (int k = 0; k < 3; ++k)
      if (segment.corner_uvs[t][k] >= 0)
        at_vertex[segment.triangles[t][k]] = segment.corner_uvs[t][k];
  for (int t = 0; t < segment.triangle_count(); ++t) {
    if (segment.corner_uvs[t][0] >= 0) continue;
    int uv = 0;
    for (const int v : segment.triangles[t]) uv = std::max(uv, at_vertex[v]);
    segment.corner_uvs[t] = {uv, uv, uv};
  }
}

/// How many parts triangles have that hang together by edges.
int connected_parts(const std::vector<Triangle>& triangles) {
  std::vector<int> parent(triangles.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int t) {
    while (parent[t] != t) t = parent[t] = parent[parent[t]];
    return t;
  };
  int parts = int(triangles.size());
  std::map<std::pair<int, int>, int> edges;
  for (int t = 0; t < int(triangles.size()); ++t)
    for (int k = 0; k < 3; ++k) {
      const auto [place, is_new] =
          edges.try_emplace(std::minmax({triangles[t][k], triangles[t][(k + 1) % 3]}), t);
      if (is_new) continue;
      const int a = root(t), b = root(place->second);
      parts -= a != b;
      parent[a] = b;
    }
  return parts;
}

}  // namespace

RollingAtlas::RollingAtlas(EvolvingMesh& film, const std::vector<Period>& periods,
                           const LifespanAtlasOptions& options)
    : film_(film),
      periods_(periods),
      options_(options),
      knows_all_(options.look_ahead >= int(film.frames.size()) - 1) {}
RollingAtlas::~RollingAtlas() = default;

const LifespanCharts& RollingAtlas::planned() const { return plan_->charting; }

void RollingAtlas::lap(const char* step) {
  const double now = watch_.seconds();
  for (UnwrapFigures::Seconds& one : seconds_)
    if (one.step == step) one.seconds += now - before_;
  before_ = now;
}

/// Charts of the plan that begin now.
std::vector<int> RollingAtlas::new_charts() const {
  std::vector<int> result;
  for (int c = 0; c < int(plan_->charting.charts.size()); ++c) {
    const LifespanChart& chart = plan_->charting.charts[c];
    if (chart.goes_on < 0 && chart.first == now_ - plan_->first_period) result.push_back(c);
  }
  return result;
}

/// The triangles that have a place, but for these.
RollingAtlas::Taken RollingAtlas::taken_without(const std::unordered_set<int>& ids) const {
  const Vector2 size(options_.unwrap.width, options_.unwrap.height);
  Taken result;
  for (const int id : film_.segments[periods_[now_].segment].triangle_ids) {
    const auto home = homes_.find(id);
    if (home == homes_.end() || ids.contains(id)) continue;
    const Piece& piece = pieces_[home->second.piece];
    result.polygons.emplace_back();
    for (const int uv : piece.corners[home->second.index])
      result.polygons.back().push_back(piece.uvs[uv].cwiseProduct(size));
    result.pieces.push_back(home->second.piece);
  }
  return result;
}

/// The triangles whose texture coordinates stay.
RollingAtlas::Taken RollingAtlas::taken_without_new() const {
  std::unordered_set<int> fresh;
  for (const int c : new_charts())
    for (const int chain : plan_->charting.charts[c].chains)
      fresh.insert(plan_->graph.chains[chain].triangle);
  return taken_without(fresh);
}

/// Leaves the triangles of a planned part that have a place where they are, if nothing that was laid since (all that is
/// taken from `since` on) is there. Returns the chains of all others; nothing: they cannot stay, or there are none.
std::optional<std::vector<int>> RollingAtlas::leave(const std::vector<int>& ids, std::size_t since, Taken& taken) const {
  const UnwrapOptions& unwrap = options_.unwrap;
  const Vector2 size(unwrap.width, unwrap.height);
  std::vector<int> others, pieces;
  std::vector<std::vector<Vector2>> polygons;
  std::vector<Vector2> all;
  for (const int id : ids) {
    const auto home = homes_.find(id);
    if (home == homes_.end()) {
      others.push_back(plan_->chain_of.at(id));
      continue;
    }
    const Piece& piece = pieces_[home->second.piece];
    if (piece.scale != scale_) return {};
    pieces.push_back(home->second.piece);
    polygons.emplace_back();
    for (const int uv : piece.corners[home->second.index]) polygons.back().push_back(piece.uvs[uv].cwiseProduct(size));
    all.insert(all.end(), polygons.back().begin(), polygons.back().end());
  }
  if (polygons.empty()) return {};
  const std::vector<std::vector<Vector2>> laid(taken.polygons.begin() + std::ptrdiff_t(since), taken.polygons.end());
  const FreeTexels free(laid, std::vector<char>(laid.size(), 0), all, unwrap.width, unwrap.height, unwrap.gutter);
  if (!std::ranges::all_of(polygons, [&](const auto& polygon) { return free.fits(polygon); })) return {};
  taken.polygons.insert(taken.polygons.end(), polygons.begin(), polygons.end());
  taken.pieces.insert(taken.pieces.end(), pieces.begin(), pieces.end());
  std::ranges::sort(others);
  return others;
}

/// Places for the charts that begin now. Of what finds no room triangles that have a place stay there, and others
/// are halved; false: they are too few for that.
bool RollingAtlas::place_new(const Progress& progress) {
  const std::vector<int> charts = new_charts();
  if (plan_->is_packed_together || charts.empty()) return true;
  const EvolvingSegment& segment = film_.segments[periods_[now_].segment];
  const UnwrapOptions& unwrap = options_.unwrap;
  const Vector2 size(unwrap.width, unwrap.height);
  Taken taken = taken_without_new();
  const std::size_t stayed = taken.polygons.size();
  std::vector<Plan::Part> open =
      plan_->lay_flat(refill(charts, taken), unwrap.stretch, bodies_, progress);
  plan_->parts.clear();
  while (!open.empty()) {
    lap("flatten");
    std::vector<PackChart> outlines;
    for (const Plan::Part& part : open) {
      outlines.push_back(outline_of(part.flat));
    }
    const auto places = pack_beside(
        outlines, scale_, taken.polygons,
        {.width = unwrap.width, .height = unwrap.height, .gutter = unwrap.gutter}, progress);
    lap("pack");
    std::vector<std::pair<int, std::vector<int>>> halves;
    for (std::size_t i = 0; i < open.size(); ++i) {
      Plan::Part& part = open[i];
      if (places[i]) {
        part.place = *places[i];
        std::vector<Vector2> uvs;
        append_uvs(part.flat, part.place, scale_, unwrap.width, unwrap.height, uvs);
        for (const Triangle& t : part.flat.sheet.triangles) {
          taken.polygons.push_back({uvs[t[0]].cwiseProduct(size), uvs[t[1]].cwiseProduct(size),
                                    uvs[t[2]].cwiseProduct(size)});
          taken.pieces.push_back(-1);
        }
        plan_->parts.push_back(std::move(part));
      }
    }
    for (std::size_t i = 0; i < open.size(); ++i) {
      const Plan::Part& part = open[i];
      if (places[i]) continue;
      std::vector<int> ids;
      for (const int t : part.triangles) ids.push_back(segment.triangle_ids[t]);
      if (auto others = leave(ids, stayed, taken)) {
        if (!others->empty()) halves.emplace_back(part.chart, std::move(*others));
        continue;
      }
      if (part.triangles.size() < 2 * least_triangles) return false;
      for (auto& chains : plan_->halves(part)) halves.emplace_back(part.chart, std::move(chains));
    }
    open = plan_->lay_flat(halves, unwrap.stretch, bodies_, progress);
  }
  lap("flatten");
  std::ranges::stable_sort(plan_->parts, {}, &Plan::Part::chart);
  return true;
}

/// From now on the charts that begin now are where they are.
void RollingAtlas::settle() {
  const EvolvingSegment& segment = film_.segments[periods_[now_].segment];
  for (const int c : new_charts()) {
    for (const Plan::Part& part : plan_->parts) {
      if (part.chart != c) continue;
      Piece piece{.chart = charts_, .body = part.body, .first = now_, .scale = scale_};
      append_uvs(part.flat, part.place, scale_, options_.unwrap.width, options_.unwrap.height,
                 piece.uvs);
      for (std::size_t t = 0; t < part.triangles.size(); ++t) {
        const Triangle& corners = part.flat.sheet.triangles[t];
        const int source = part.triangles[t], id = segment.triangle_ids[source];
        Triangle vertex_ids;
        for (int k = 0; k < 3; ++k)
          vertex_ids[k] = segment.vertex_ids[segment.triangles[source][k]];
        homes_[id] = {int(pieces_.size()), int(t)};
        piece.ids.push_back(id);
        piece.vertex_ids.push_back(vertex_ids);
        piece.corners.push_back(corners);
        piece.areas.push_back(area(corners, part.flat.x));
      }
      piece.since.assign(piece.ids.size(), now_);
      piece.last.assign(piece.ids.size(), now_);
      pieces_.push_back(std::move(piece));
    }
    ++charts_;
  }
}

/// The texture coordinates of all triangles there are, and what goes on of them.
void RollingAtlas::write() {
  EvolvingSegment& segment = film_.segments[periods_[now_].segment];
  segment.uvs.clear();
  segment.corner_uvs.assign(segment.triangles.size(), {-1, -1, -1});
  std::unordered_map<int, Home> homes;
  std::map<int, std::vector<std::pair<int, int>>> alive;  // per piece: index there, triangle
  for (int t = 0; t < segment.triangle_count(); ++t) {
    const auto home = homes_.find(segment.triangle_ids[t]);
    if (home == homes_.end()) continue;  // collapsed
    homes.insert(*home);
    alive[home->second.piece].push_back({home->second.index, t});
  }
  homes_ = std::move(homes);
  int parts = 0;
  for (const auto& [number, triangles] : alive) {
    Piece& piece = pieces_[number];
    std::vector<int> place(piece.uvs.size(), -1);
    std::vector<Triangle> corners;
    for (const auto& [i, t] : triangles) {
      piece.last[i] = now_;
      corners.push_back(piece.corners[i]);
      for (const int uv : piece.corners[i]) place[uv] = 0;
    }
    for (std::size_t uv = 0; uv < place.size(); ++uv)
      if (place[uv] == 0) {
        place[uv] = int(segment.uvs.size());
        segment.uvs.push_back(piece.uvs[uv]);
      }
    for (const auto& [i, t] : triangles)
      for (int k = 0; k < 3; ++k)
        segment.corner_uvs[t][corner(segment, t, piece.vertex_ids[i][k])] =
            place[piece.corners[i][k]];
    parts += triangles.size() == piece.ids.size() ? 1 : connected_parts(corners);
  }
  pieces_of_period_.push_back(parts);
  place_collapsed(segment);
}

void RollingAtlas::add_period(const Progress& progress) {
  ++now_;
  if (now_ > 0) {
    EvolvingMesh one;
    one.frames.push_back(film_.frames[periods_[now_].first]);
    positions_ = std::move(on_unit_grid(std::move(one), grid_).frames[0].positions);
  }
  if (!knows_all_) {
    if (now_ > 0) extend_pieces();
    plan_now(Past::goes_on, progress.step("plan", 0.8));
  } else if (now_ == 0) {
    plan_whole(progress.step("plan", 0.8));
  }
  if (!place_new(progress.step("place", 0.1))) {
    cleared_.push_back(periods_[now_].first);
    plan_now(Past::forgotten, progress.step("clear", 0.1));
  }
  settle();
  write();
  progress.at(1);
}

std::vector<AtlasPrism> RollingAtlas::prisms() const {
  std::vector<AtlasPrism> result;
  for (const Piece& piece : pieces_) {
    std::map<std::pair<int, int>, AtlasPrism> by_life;
    for (std::size_t t = 0; t < piece.ids.size(); ++t) {
      if (piece.last[t] < piece.since[t]) continue;
      AtlasPrism& prism = by_life[{piece.since[t], piece.last[t]}];
      prism.first = periods_[piece.since[t]].first;
      prism.last = periods_[piece.last[t]].last;
      prism.triangles.push_back(piece.ids[t]);
      prism.area += piece.areas[t] * piece.scale * piece.scale;
    }
    for (auto& [life, prism] : by_life) {
      std::ranges::sort(prism.triangles);
      result.push_back(std::move(prism));
    }
  }
  return result;
}

/// What was put into a chart's holes later counts for itself.
std::vector<RollingAtlas::Lived> RollingAtlas::lived() const {
  std::map<std::pair<int, int>, Lived> bodies;
  for (const Piece& piece : pieces_)
    for (std::size_t t = 0; t < piece.ids.size(); ++t) {
      if (piece.last[t] < piece.since[t]) continue;
      Lived& body = bodies[{piece.body, piece.since[t]}];
      body.first = piece.since[t];
      body.triangles.push_back(piece.ids[t]);
      body.last.push_back(piece.last[t]);
    }
  std::vector<Lived> result;
  for (auto& [number, body] : bodies) result.push_back(std::move(body));
  return result;
}

}  // namespace mq
