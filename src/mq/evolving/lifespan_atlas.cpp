// What is known makes the difference between an atlas for a whole sequence and one for a sequence
// that goes on: `RollingAtlas` makes both.

#include "mq/evolving/lifespan_atlas.h"

#include <algorithm>
#include <unordered_map>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/evolving/detail/rolling_atlas.h"
#include "mq/unwrap/atlas_stretch.h"

namespace mq {
namespace {

/// What lived, as charts of the graph.
std::vector<WaningChart> charts_of(const std::vector<RollingAtlas::Lived>& lives,
                                   const NeighbourGraph& graph) {
  std::unordered_map<int, int> chain_of;
  for (int c = 0; c < int(graph.chains.size()); ++c) chain_of[graph.chains[c].triangle] = c;
  std::vector<WaningChart> charts;
  for (const RollingAtlas::Lived& life : lives) {
    if (life.triangles.empty()) continue;  // planned, and dropped with its plan
    charts.push_back({life.first, {}, life.last});
    for (const int id : life.triangles) charts.back().chains.push_back(chain_of.at(id));
  }
  return charts;
}

/// The charts that there were, and what they are worth beside those found when all is known.
void compare_with_whole(const EvolvingMesh& evolving, const ChartingOptions& options,
                        const RollingAtlas& rolling, const Progress& progress,
                        LifespanAtlas& atlas) {
  const NeighbourGraph graph = neighbour_graph(evolving, progress.step("neighbours", 0.5));
  const LifespanCharts whole = find_lifespan_charts(graph, options, progress.step("chart", 0.5));
  atlas.charting.energy = charting_energy(graph, charts_of(rolling.lived(), graph), options.beta);
  atlas.charting.first_charts = whole.first_charts;
  atlas.charting.first_energy = whole.first_energy;
  atlas.charting.edits = rolling.edits();
  atlas.energy_of_whole = whole.energy;
}

/// What the atlas is in each frame, and over all.
void measure(const EvolvingMesh& evolving, const LifespanAtlasOptions& options,
             const std::vector<int>& pieces_of_period, const Progress& progress,
             LifespanAtlas& atlas) {
  const int count = int(evolving.frames.size());
  atlas.frames.resize(count);
  double lives = 0, frames_lived = 0;
  std::vector<double> area(count);
  for (const AtlasPrism& prism : atlas.charts) {
    const double triangles = double(prism.triangles.size());
    lives += triangles;
    frames_lived += triangles * (prism.last - prism.first + 1);
    if (prism.first > 0) atlas.frames[prism.first].renewed += int(prism.triangles.size());
    for (int f = prism.first; f <= prism.last; ++f) area[f] += prism.area;
  }
  atlas.lifespan = frames_lived / lives;
  atlas.bound =
      double(options.unwrap.width) * options.unwrap.height / *std::ranges::max_element(area);
  for (std::size_t p = 0; p < atlas.periods.size(); ++p) {
    const Period& period = atlas.periods[p];
    for (int f = period.first; f <= period.last; ++f) atlas.frames[f].charts = pieces_of_period[p];
    if (p > 0)
      atlas.frames[period.first].added =
          change(evolving.segments[atlas.periods[p - 1].segment], evolving.segments[period.segment])
              .added;
  }
  for (int f = 0; f < count; ++f) {
    LifespanAtlasFrame& frame = atlas.frames[f];
    const EvolvingSegment& segment = evolving.segments[evolving.frames[f].segment];
    const Surface surface = make_surface(evolving.mesh(f), {.kind = WeldOptions::Kind::none});
    const AtlasStretch stretch = atlas_stretch(surface, segment.uvs, segment.corner_uvs,
                                               options.unwrap.width, options.unwrap.height);
    frame.occupancy = stretch.occupancy;
    frame.stretch = stretch.l2_stretch;
    frame.flipped = stretch.flipped;
    atlas.occupancy += frame.occupancy / count;
    atlas.charts_per_frame += double(frame.charts) / count;
    atlas.stretch = std::max(atlas.stretch, frame.stretch);
    atlas.flipped += frame.flipped;
    atlas.moved += frame.renewed - frame.added;
    progress.at(double(f + 1) / count);
  }
}

}  // namespace

LifespanAtlas lay_out(EvolvingMesh& evolving, const LifespanAtlasOptions& options,
                      const Progress& progress) {
  require(options.look_ahead >= 0,
          fmt::format("a look-ahead of {} frames: wanted 0 or more", options.look_ahead));
  check(evolving);
  triangle_lifespans(evolving);  // throws where some come back
  LifespanAtlas atlas;
  atlas.periods = periods_of(evolving);
  require(!atlas.periods.empty(), "the evolving mesh has no frame to lay out");
  for (EvolvingSegment& segment : evolving.segments) {
    segment.uvs.clear();
    segment.corner_uvs.assign(segment.triangles.size(), {-1, -1, -1});
  }
  RollingAtlas rolling(evolving, atlas.periods, options);
  const bool knows_all = options.look_ahead >= int(evolving.frames.size()) - 1;
  const Progress making = progress.step("lay out", knows_all ? 0.95 : 0.85);
  for (std::size_t p = 0; p < atlas.periods.size(); ++p)
    rolling.add_period(
        making.step(fmt::format("frame {}", evolving.frames[atlas.periods[p].first].number),
                    !knows_all ? 1.0 / double(atlas.periods.size())
                    : p == 0   ? 0.95
                               : 0.05 / double(atlas.periods.size())));
  atlas.plans = rolling.plans();
  atlas.cleared = rolling.cleared();
  atlas.seconds = rolling.seconds();
  atlas.charts = rolling.prisms();
  if (knows_all) {
    atlas.charting = rolling.planned();
    atlas.energy_of_whole = atlas.charting.energy;
  } else {
    compare_with_whole(evolving, options.charting, rolling, progress.step("compare", 0.1), atlas);
  }
  measure(evolving, options, rolling.pieces_of_period(), progress.step("measure", 0.05), atlas);
  return atlas;
}

}  // namespace mq
