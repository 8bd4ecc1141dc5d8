// Where all is known charts are prisms, planned once. Where it is not, what begins now is planned, and nothing
// else: charts here may lose triangles and gain some, so that a life that ends before its neighbour's is no
// reason to part them, and what begins later is laid beside what is there by then. Of the past a plan needs one
// frame: a chart that is split has its caps once more, however long it has lived, and its sides are parted. All
// that charts which begin now can collide with is there now, so that time is no matter where they are placed.

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <unordered_map>

#include "mq/evolving/detail/rolling_atlas.h"
#include "mq/evolving/detail/rolling_plan.h"
#include "mq/evolving/detail/survival.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

/// Of the texture's height, left free for what is to come.
constexpr double headroom = 1.0 / 32;

/// Where less of the texture is filled at first, charts are cut to all of these parts of what they may have.
constexpr double enough_filled = 0.62;
constexpr std::array largest_tried = {1.0, 0.9, 0.8};

/// Of all triangles, those of a chart that may end for another one.
constexpr double largest_to_end = 1.0 / 50;

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

double flat_area(const Triangle& t, const Points& x) {
  const Vector2 a = x[t[1]] - x[t[0]], b = x[t[2]] - x[t[0]];
  return (a.x() * b.y() - a.y() * b.x()) / 2;
}

/// Lets sides of the last period count for as long as triangles live on, those of two for as long as both do; and those
/// of a period before for nothing, as they are as they are.
void weigh_by_lives(const std::vector<double>& lives, NeighbourGraph& graph) {
  const int now = int(graph.frame_counts.size()) - 1;
  const auto weigh = [&](int first, double life, std::vector<std::int64_t>& sums) {
    for (std::size_t i = 0; i < sums.size(); ++i)
      sums[i] = first + int(i) == now ? std::int64_t(std::nearbyint(double(sums[i]) * life)) : 0;
  };
  for (std::size_t c = 0; c < lives.size(); ++c) weigh(graph.chains[c].first, lives[c], graph.chains[c].perimeter);
  for (NeighbourGraph::Contact& contact : graph.contacts)
    weigh(contact.first, std::min(lives[contact.one], lives[contact.other]), contact.length);
}

/// The graph of those chains alone of which `keeps` is 1.
NeighbourGraph part_of(const NeighbourGraph& graph, const std::vector<char>& keeps) {
  NeighbourGraph result{.frame_counts = graph.frame_counts, .chains = {}, .contacts = {}, .radius = graph.radius};
  std::vector<int> number(graph.chains.size(), -1);
  for (std::size_t c = 0; c < graph.chains.size(); ++c) {
    if (!keeps[c]) continue;
    number[c] = int(result.chains.size());
    result.chains.push_back(graph.chains[c]);
  }
  for (const NeighbourGraph::Contact& contact : graph.contacts) {
    if (!keeps[contact.one] || !keeps[contact.other]) continue;
    result.contacts.push_back(contact);
    result.contacts.back().one = number[contact.one];
    result.contacts.back().other = number[contact.other];
  }
  return result;
}

}  // namespace

/// Without the charts that stay whatever comes: large ones.
NeighbourGraph RollingAtlas::without_large(const NeighbourGraph& graph) const {
  std::unordered_map<int, int> triangles;  // by chart
  for (const auto& [id, home] : homes_) ++triangles[pieces_[home.piece].chart];
  std::vector<char> keeps;
  for (const NeighbourGraph::Chain& chain : graph.chains) {
    const auto home = homes_.find(chain.triangle);
    keeps.push_back(home == homes_.end() ||
                    triangles[pieces_[home->second.piece].chart] <= largest_to_end * double(homes_.size()));
  }
  return part_of(graph, keeps);
}

void RollingAtlas::set_plan(std::unique_ptr<Plan> plan) {
  for (int c = 0; c < int(plan->graph.chains.size()); ++c)
    plan->chain_of[plan->graph.chains[c].triangle] = c;
  plan->reference_chart.emplace(plan->window, plan->graph, plan->periods, options_.metric_frames);
  plan_ = std::move(plan);
  ++plans_;
  edits_ += plan_->charting.edits;
  lap("chart");
}

/// Plans all charts there will be.
void RollingAtlas::plan_whole(const Progress& progress) {
  auto plan = std::make_unique<Plan>();
  plan->window = window_of(film_, periods_, 0, periods_.back().last);
  grid_ = unit_grid(plan->window);
  plan->window = on_unit_grid(std::move(plan->window), grid_);
  plan->periods = periods_of(plan->window);
  plan->area = mean_area(plan->window);
  plan->graph = neighbour_graph(plan->window, progress.step("neighbours", 0.2));
  plan->charting = find_lifespan_charts(plan->graph, options_.charting, progress.step("chart", 0.2));
  set_plan(std::move(plan));
  pack_all(progress.step("pack", 0.6));
}

/// For what share of a sequence that goes on for as long again as is known each triangle of now will probably be
/// there from now on.
std::vector<double> RollingAtlas::expected_lives(const NeighbourGraph& graph, int known) {
  const int first = periods_[now_].first, horizon = known + 1;
  for (int p = now_; p < int(periods_.size()) && periods_[p].first <= known; ++p)
    for (const int id : film_.segments[periods_[p].segment].triangle_ids)
      lives_.try_emplace(id, Lifespan{id, periods_[p].first, 0}).first->second.last = std::min(periods_[p].last, known);
  std::vector<KnownLife> all;
  for (const auto& [id, life] : lives_)
    all.push_back({life.last - life.first + 1, life.last < known ? KnownLife::End::seen : KnownLife::End::to_come});
  const Survival survival(all);
  std::unordered_map<int, double> to_come;  // by frames so far
  std::vector<double> result;
  for (const NeighbourGraph::Chain& chain : graph.chains) {
    const Lifespan& life = lives_.at(chain.triangle);
    double frames = life.last - first + 1;
    if (life.last == known && known < periods_.back().last) {
      const int so_far = life.last - life.first + 1;
      const auto [place, is_new] = to_come.try_emplace(so_far, 0);
      if (is_new) place->second = survival.expected_after(so_far, horizon);
      frames += place->second;
    }
    result.push_back(frames / (known + 1 + horizon));
  }
  return result;
}

/// Plans what begins now, with charts of the past or without.
void RollingAtlas::plan_now(Past past, const Progress& progress) {
  const int first = periods_[now_].first, last = periods_.back().last;
  auto plan = std::make_unique<Plan>();
  const bool has_past = now_ > 0 && past == Past::goes_on;
  const int begin = has_past ? first - 1 : first, now = has_past ? 1 : 0;
  const int known = int(std::min<std::int64_t>(last, std::int64_t(first) + options_.look_ahead));
  plan->first_period = now_ - now;
  plan->window = window_of(film_, periods_, begin, known);
  if (now_ == 0) grid_ = unit_grid(plan->window);
  plan->window = on_unit_grid(std::move(plan->window), grid_);
  plan->periods = periods_of(plan->window);
  plan->area = mean_area(plan->window);
  plan->graph = neighbour_graph(on_unit_grid(window_of(film_, periods_, begin, first), grid_),
                                progress.step("neighbours", 0.2));
  if (has_past) plan->graph = without_large(plan->graph);
  ChartingOptions charting = options_.charting;
  charting.frames = 1;  // of which lives are shares
  weigh_by_lives(expected_lives(plan->graph, known), plan->graph);
  if (has_past) {
    charting.past = 1;
    for (const NeighbourGraph::Chain& chain : plan->graph.chains) {
      const auto home = homes_.find(chain.triangle);
      charting.chart_of.push_back(home != homes_.end() ? pieces_[home->second.piece].chart : -1);
    }
  }
  plan->charting = find_lifespan_charts(plan->graph, charting, progress.step("chart", 0.2));
  for (LifespanChart& chart : plan->charting.charts)
    if (chart.last == now) chart.last = int(plan->periods.size()) - 1;
  set_plan(std::move(plan));
  if (!has_past) pack_all(progress.step("pack", 0.6));
}

/// All charts of the plan, where nothing is there yet. With a look-ahead they stay as they are for long, and so does what
/// they leave free: where that is much they are cut smaller, too, and what fills most is taken.
void RollingAtlas::pack_all(const Progress& progress) {
  std::vector<int> charts(plan_->charting.charts.size());
  std::iota(charts.begin(), charts.end(), 0);
  const UnwrapOptions& unwrap = options_.unwrap;
  const int free = knows_all_ ? 0 : int(headroom * unwrap.height);
  const int bodies = bodies_;
  std::size_t cuts = knows_all_ ? 1 : largest_tried.size();
  double most = 0;
  std::vector<Plan::Part> best;
  for (std::size_t i = 0; i < cuts; ++i) {
    plan_->largest = largest_tried[i];
    bodies_ = bodies;
    const Progress step = progress.step("cut", 1.0 / double(largest_tried.size()));
    std::vector<Plan::Part> parts = plan_->lay_flat(charts, unwrap.stretch, bodies_, step.step("flatten", 0.5));
    lap("flatten");
    std::vector<PackChart> outlines;
    for (const Plan::Part& part : parts) outlines.push_back(plan_->outline(part));
    const Packing packing = pack(outlines,
                                 {.width = unwrap.width,
                                  .height = unwrap.height - free,
                                  .gutter = unwrap.gutter,
                                  .trials = unwrap.trials},
                                 step.step("pack", 0.5));
    lap("pack");
    double area = 0;
    for (std::size_t p = 0; p < parts.size(); ++p) {
      parts[p].place = packing.places[p];
      for (const Triangle& t : parts[p].flat.sheet.triangles) area += flat_area(t, parts[p].flat.x);
    }
    const double filled = area * packing.scale * packing.scale / (double(unwrap.width) * unwrap.height);
    if (i == 0 && filled >= enough_filled) cuts = 1;
    if (i > 0 && filled <= most) continue;
    most = filled;
    best = std::move(parts);
    scale_ = packing.scale;
  }
  plan_->largest = 1;
  plan_->parts = std::move(best);
  plan_->is_packed_together = true;
}

}  // namespace mq
