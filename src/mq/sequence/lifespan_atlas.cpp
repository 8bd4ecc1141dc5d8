// Charts begin and end with segments, so that within a segment texture coordinates are constant,
// and a chart's triangles are connected alike in all of its life.

#include "mq/sequence/lifespan_atlas.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <unordered_map>

#include "mq/base/parallel.h"
#include "mq/mesh/geometry.h"
#include "mq/sequence/flat_charts.h"
#include "mq/sequence/laps.h"

namespace mq {
namespace {

/// What unwraps a whole surface; a part of it gets its share.
constexpr ChartOptions whole_chart;

/// One chart's triangles at one moment, with vertices of their own.
struct CrossSection {
  Surface surface;
  EdgeLengths lengths;         // mean over time
  std::vector<int> triangles;  // of the chart's first segment
};

/// Indices of a segment's triangles by their ids.
std::unordered_map<int, int> index_of_ids(const std::vector<int>& ids) {
  std::unordered_map<int, int> index;
  for (int i = 0; i < int(ids.size()); ++i) index[ids[i]] = i;
  return index;
}

/// A triangle's corner with this vertex.
int corner(const EvolvingSegment& segment, int triangle, int vertex_id) {
  for (int k = 0; k < 3; ++k)
    if (segment.vertex_ids[segment.triangles[triangle][k]] == vertex_id) return k;
  return 0;
}

/// Squared lengths of edges at one frame.
std::vector<std::array<double, 3>> squared_lengths(const std::vector<Triangle>& triangles,
                                                   const std::vector<Vector3>& positions) {
  std::vector<std::array<double, 3>> result(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int k = 0; k < 3; ++k)
      result[t][k] =
          (positions[triangles[t][(k + 1) % 3]] - positions[triangles[t][k]]).squaredNorm();
  return result;
}

/// The chart where its frames resemble their mean most.
class CrossSections {
 public:
  CrossSections(const EvolvingMesh& evolving, const NeighbourGraph& graph,
                const std::vector<Period>& periods, int metric_frames)
      : evolving_(evolving), graph_(graph), periods_(periods), metric_frames_(metric_frames) {
    for (const Period& period : periods) {
      triangle_of_.push_back(index_of_ids(evolving.segments[period.segment].triangle_ids));
      vertex_of_.push_back(index_of_ids(evolving.segments[period.segment].vertex_ids));
    }
  }

  int triangle(int period, int id) const { return triangle_of_[period].at(id); }

  CrossSection operator()(const LifespanChart& chart) const {
    CrossSection section;
    const EvolvingSegment& segment = evolving_.segments[periods_[chart.first].segment];
    std::unordered_map<int, int> local;
    std::vector<int> vertex_ids;
    Mesh mesh;
    for (const int c : chart.chains) {
      const int t = triangle(chart.first, graph_.chains[c].triangle);
      section.triangles.push_back(t);
      Triangle corners;
      for (int k = 0; k < 3; ++k) {
        const int v = segment.triangles[t][k];
        const auto [place, is_new] = local.try_emplace(v, int(vertex_ids.size()));
        if (is_new) vertex_ids.push_back(segment.vertex_ids[v]);
        corners[k] = place->second;
      }
      mesh.triangles.push_back(corners);
    }
    const int first = periods_[chart.first].first, last = periods_[chart.last].last;
    const int count = std::min(last - first + 1, metric_frames_);
    std::vector<std::vector<Vector3>> frames;
    std::vector<std::vector<std::array<double, 3>>> squares;
    section.lengths.assign(mesh.triangles.size(), {});
    for (int i = 0; i < count; ++i) {
      const int f = first + int((2LL * i + 1) * (last - first + 1) / (2LL * count));
      frames.push_back(positions(vertex_ids, f));
      squares.push_back(squared_lengths(mesh.triangles, frames.back()));
      for (std::size_t t = 0; t < section.lengths.size(); ++t)
        for (int k = 0; k < 3; ++k) section.lengths[t][k] += squares.back()[t][k] / count;
    }
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < count; ++i) {
      double difference = 0;
      for (std::size_t t = 0; t < section.lengths.size(); ++t)
        for (int k = 0; k < 3; ++k)
          difference += std::abs(squares[i][t][k] - section.lengths[t][k]);
      if (difference < least) least = difference, mesh.positions = frames[i];
    }
    for (auto& edges : section.lengths)
      for (double& length : edges) length = std::sqrt(length);
    section.surface = make_surface(mesh, {.kind = WeldOptions::Kind::none});
    return section;
  }

 private:
  std::vector<Vector3> positions(const std::vector<int>& vertex_ids, int frame) const {
    const int period =
        int(std::ranges::upper_bound(periods_, frame, {}, &Period::first) - periods_.begin()) - 1;
    std::vector<Vector3> result;
    result.reserve(vertex_ids.size());
    for (const int id : vertex_ids)
      result.push_back(evolving_.frames[frame].positions[vertex_of_[period].at(id)]);
    return result;
  }

  const EvolvingMesh& evolving_;
  const NeighbourGraph& graph_;
  const std::vector<Period>& periods_;
  int metric_frames_;
  std::vector<std::unordered_map<int, int>> triangle_of_, vertex_of_;  // per period, by id
};

/// A chart of the charting, and the charts that unwrapping made of it.
struct Unrolled {
  CrossSection section;
  std::vector<FlatChart> charts;
};

Unrolled unroll(CrossSection section, double mean_area, double stretch, const Progress& progress) {
  Unrolled unrolled{std::move(section), {}};
  const Surface& surface = unrolled.section.surface;
  const double share = std::clamp(surface.area / mean_area, 1e-9, 1.0);
  const ChartOptions options{.stretch = stretch,
                             .seam_cost = whole_chart.seam_cost / std::sqrt(share),
                             .largest = std::min(1.0, whole_chart.largest / share),
                             .patches = std::max(1, int(std::ceil(whole_chart.patches * share))),
                             .triangles = std::max(100, int(whole_chart.triangles * share))};
  const ChartHistory history = find_charts(surface, options, progress.step("cut", 0.5));
  Patchwork patchwork(surface, history.patches.patch, history.patches.count);
  unrolled.charts = lay_flat(surface, history, stretch, &unrolled.section.lengths, patchwork,
                             progress.step("flatten", 0.5));
  for (FlatChart& flat : unrolled.charts) scale_for_stretch(flat);
  return unrolled;
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

/// What the atlas is in each frame, and over all.
void measure(const EvolvingMesh& evolving, const LifespanAtlasOptions& options,
             const Progress& progress, LifespanAtlas& atlas) {
  const int count = int(evolving.frames.size());
  atlas.frames.resize(count);
  double lives = 0, frames_lived = 0;
  for (const AtlasPrism& prism : atlas.charts) {
    const double triangles = double(prism.triangles.size());
    lives += triangles;
    frames_lived += triangles * (prism.last - prism.first + 1);
    if (prism.first > 0) atlas.frames[prism.first].renewed += int(prism.triangles.size());
    for (int f = prism.first; f <= prism.last; ++f) ++atlas.frames[f].charts;
  }
  atlas.lifespan = frames_lived / lives;
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
    progress.at(double(f + 1) / count);
  }
}

double mean_area(const EvolvingMesh& evolving) {
  double area = 0;
  for (int f = 0; f < int(evolving.frames.size()); ++f)
    for (const double a : triangle_areas(evolving.mesh(f))) area += a;
  return area / double(evolving.frames.size());
}

/// Every chart laid flat, the large ones first, so that none is left over for one thread at the
/// end.
std::vector<Unrolled> unroll_all(const std::vector<LifespanChart>& charts,
                                 const CrossSections& cross_section, double mean_area,
                                 double stretch, const Progress& progress) {
  std::vector<int> order(charts.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, std::ranges::greater{},
                           [&](int c) { return charts[c].chains.size(); });
  std::vector<Unrolled> unrolled(charts.size());
  std::atomic<std::size_t> done = 0;
  std::size_t all = 0;
  for (const LifespanChart& chart : charts) all += chart.chains.size();
  parallel_for(
      std::ssize(order),
      [&](std::int64_t i) {
        const LifespanChart& chart = charts[order[i]];
        progress.check();
        unrolled[order[i]] = unroll(cross_section(chart), mean_area, stretch, {});
        progress.at(double(done += chart.chains.size()) / double(all));
      },
      1);
  return unrolled;
}

/// Gives all segments of a chart's life its texture coordinates; returns the ids of its triangles.
std::vector<int> write_chart(const LifespanChart& chart, const Unrolled& unrolled,
                             const FlatChart& flat, const std::vector<Vector2>& uvs,
                             const CrossSections& cross_section, const std::vector<Period>& periods,
                             EvolvingMesh& evolving) {
  const EvolvingSegment& origin = evolving.segments[periods[chart.first].segment];
  std::vector<int> ids;
  for (const int t : flat.sheet.sources)
    ids.push_back(origin.triangle_ids[unrolled.section.triangles[t]]);
  for (int p = chart.first; p <= chart.last; ++p) {
    EvolvingSegment& segment = evolving.segments[periods[p].segment];
    const int base = int(segment.uvs.size());
    segment.uvs.insert(segment.uvs.end(), uvs.begin(), uvs.end());
    for (std::size_t i = 0; i < ids.size(); ++i) {
      const int t = cross_section.triangle(p, ids[i]);
      const Triangle& source = origin.triangles[unrolled.section.triangles[flat.sheet.sources[i]]];
      for (int k = 0; k < 3; ++k)
        segment.corner_uvs[t][corner(segment, t, origin.vertex_ids[source[k]])] =
            base + flat.sheet.triangles[i][k];
    }
  }
  return ids;
}

}  // namespace

LifespanAtlas lay_out(EvolvingMesh& evolving, const LifespanAtlasOptions& options,
                      const Progress& progress) {
  LifespanAtlas atlas;
  Laps lap(atlas.seconds);
  const EvolvingMesh unit = on_unit_grid(evolving);
  const std::vector<Period>& periods = atlas.periods = periods_of(unit);
  const NeighbourGraph graph = neighbour_graph(unit, progress.step("neighbours", 0.05));
  atlas.charting = find_lifespan_charts(graph, options.charting, progress.step("chart", 0.1));
  const std::vector<LifespanChart>& charts = atlas.charting.charts;
  lap("chart");

  const CrossSections cross_section(unit, graph, periods, options.metric_frames);
  const std::vector<Unrolled> unrolled =
      unroll_all(charts, cross_section, mean_area(unit), options.unwrap.stretch,
                 progress.step("flatten", 0.4));
  lap("flatten");

  std::vector<PackChart> outlines;
  for (std::size_t c = 0; c < charts.size(); ++c)
    for (const FlatChart& flat : unrolled[c].charts) {
      outlines.push_back(outline_of(flat));
      outlines.back().first = periods[charts[c].first].first;
      outlines.back().last = periods[charts[c].last].last;
    }
  const int width = options.unwrap.width, height = options.unwrap.height;
  const Packing packing = pack(outlines,
                               {.width = width,
                                .height = height,
                                .gutter = options.unwrap.gutter,
                                .trials = options.unwrap.trials},
                               progress.step("pack", 0.4));
  atlas.bound = packing.bound;
  lap("pack");

  for (EvolvingSegment& segment : evolving.segments) {
    segment.uvs.clear();
    segment.corner_uvs.assign(segment.triangles.size(), {-1, -1, -1});
  }
  std::size_t placed = 0;
  for (std::size_t c = 0; c < charts.size(); ++c)
    for (const FlatChart& flat : unrolled[c].charts) {
      std::vector<Vector2> uvs;
      append_uvs(flat, packing.places[placed], packing.scale, width, height, uvs);
      const PackChart& outline = outlines[placed++];
      AtlasPrism prism{
          outline.first, outline.last, {}, outline.area * packing.scale * packing.scale};
      prism.triangles =
          write_chart(charts[c], unrolled[c], flat, uvs, cross_section, periods, evolving);
      std::ranges::sort(prism.triangles);
      atlas.charts.push_back(std::move(prism));
    }
  for (const Period& period : periods) place_collapsed(evolving.segments[period.segment]);
  measure(evolving, options, progress.step("measure", 0.05), atlas);
  return atlas;
}

}  // namespace mq
