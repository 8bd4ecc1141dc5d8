// Charts begin and end with segments, so that within a segment texture coordinates are constant,
// and a chart's triangles are connected alike in all of its life.
//
// Of the past a plan needs one frame: a chart that is split has its caps once more, however long it
// has lived, and its sides are parted. All that charts which begin now can collide with is there
// now, so that time is no matter where they are placed; only where nothing is there yet are charts
// packed together with those planned for later.

#include "mq/evolving/detail/rolling_atlas.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <unordered_set>

#include "mq/evolving/detail/flattened_charts.h"
#include "mq/evolving/detail/rolling_plan.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

/// Of the texture's height, left free for what is to come.
constexpr double headroom = 1.0 / 32;

/// Of half a chart for which there was no room, at least.
constexpr std::size_t least_triangles = 8;

/// The frames from one to another, and the segments that they have.
EvolvingMesh window_of(const EvolvingMesh& film, const std::vector<Period>& periods, int first,
                       int last) {
  EvolvingMesh window;
  for (const Period& period : periods) {
    if (period.last < first || period.first > last) continue;
    EvolvingSegment segment = film.segments[period.segment];
    segment.uvs.clear();
    segment.corner_uvs.clear();
    window.segments.push_back(std::move(segment));
    for (int f = std::max(first, period.first); f <= std::min(last, period.last); ++f)
      window.frames.push_back(
          {film.frames[f].number, int(window.segments.size()) - 1, film.frames[f].positions});
  }
  return window;
}

double mean_area(const EvolvingMesh& evolving) {
  double area = 0;
  for (int f = 0; f < int(evolving.frames.size()); ++f)
    for (const double a : triangle_areas(evolving.mesh(f))) area += a;
  return area / double(evolving.frames.size());
}

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
    : film_(film), periods_(periods), options_(options) {}
RollingAtlas::~RollingAtlas() = default;

const LifespanCharts& RollingAtlas::planned() const { return plan_->charting; }

void RollingAtlas::lap(const char* step) {
  const double now = watch_.seconds();
  for (UnwrapFigures::Seconds& one : seconds_)
    if (one.step == step) one.seconds += now - before_;
  before_ = now;
}

/// Plans all that is not over, with charts of the past or without.
void RollingAtlas::plan(Past past, const Progress& progress) {
  const int first = periods_[now_].first, last = periods_.back().last;
  auto plan = std::make_unique<Plan>();
  const bool has_past = now_ > 0 && past == Past::goes_on;
  plan->first_period = has_past ? now_ - 1 : now_;
  plan->known = int(std::min<std::int64_t>(last, std::int64_t(first) + options_.look_ahead));
  plan->window = window_of(film_, periods_, has_past ? first - 1 : first, plan->known);
  if (now_ == 0) grid_ = unit_grid(plan->window);
  plan->window = on_unit_grid(std::move(plan->window), grid_);
  plan->periods = periods_of(plan->window);
  plan->area = mean_area(plan->window);
  plan->graph = neighbour_graph(plan->window, progress.step("neighbours", 0.2));
  ChartingOptions charting = options_.charting;
  charting.frames = plan->known + 1;
  if (has_past) {
    charting.past = 1;
    for (const NeighbourGraph::Chain& chain : plan->graph.chains) {
      const auto home = chain.first <= 1 ? homes_.find(chain.triangle) : homes_.end();
      charting.chart_of.push_back(home != homes_.end() ? pieces_[home->second.piece].chart : -1);
    }
  }
  plan->charting = find_lifespan_charts(plan->graph, charting, progress.step("chart", 0.2));
  for (int c = 0; c < int(plan->graph.chains.size()); ++c)
    plan->chain_of[plan->graph.chains[c].triangle] = c;
  plan->reference_chart.emplace(plan->window, plan->graph, plan->periods, options_.metric_frames);
  plan_ = std::move(plan);
  ++plans_;
  edits_ += plan_->charting.edits;
  lap("chart");
  if (!has_past) pack_all(progress.step("pack", 0.6));
}

/// All charts of the plan, where nothing is there yet.
void RollingAtlas::pack_all(const Progress& progress) {
  std::vector<int> charts(plan_->charting.charts.size());
  std::iota(charts.begin(), charts.end(), 0);
  const UnwrapOptions& unwrap = options_.unwrap;
  plan_->parts = plan_->lay_flat(charts, unwrap.stretch, bodies_, progress.step("flatten", 0.5));
  lap("flatten");
  std::vector<PackChart> outlines;
  for (const Plan::Part& part : plan_->parts) outlines.push_back(plan_->outline(part));
  const bool ends = plan_->known == periods_.back().last;
  const int free = ends ? 0 : int(headroom * unwrap.height);
  const Packing packing = pack(outlines,
                               {.width = unwrap.width,
                                .height = unwrap.height - free,
                                .gutter = unwrap.gutter,
                                .trials = unwrap.trials},
                               progress.step("pack", 0.5));
  scale_ = packing.scale;
  for (std::size_t i = 0; i < plan_->parts.size(); ++i) plan_->parts[i].place = packing.places[i];
  plan_->is_packed_together = true;
  lap("pack");
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

/// Places for the charts that begin now. What finds no room is halved; false: it is too small for
/// that.
bool RollingAtlas::place_new(const Progress& progress) {
  const std::vector<int> charts = new_charts();
  if (plan_->is_packed_together || charts.empty()) return true;
  const UnwrapOptions& unwrap = options_.unwrap;
  const Vector2 size(unwrap.width, unwrap.height);
  Taken taken = taken_without_new();
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
  const std::int64_t seen = std::int64_t(periods_[now_].first) + options_.look_ahead;
  if (now_ > 0) {
    EvolvingMesh one;
    one.frames.push_back(film_.frames[periods_[now_].first]);
    positions_ = std::move(on_unit_grid(std::move(one), grid_).frames[0].positions);
  }
  if (!plan_ || std::min<std::int64_t>(periods_.back().last, seen) > plan_->known) {
    if (now_ > 0) extend_pieces();
    plan(Past::goes_on, progress.step("plan", 0.8));
  }
  if (!place_new(progress.step("place", 0.1))) {
    cleared_.push_back(periods_[now_].first);
    plan(Past::forgotten, progress.step("clear", 0.1));
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
