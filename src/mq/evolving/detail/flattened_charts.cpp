#include "mq/evolving/detail/flattened_charts.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>

#include "mq/base/parallel.h"

namespace mq {
namespace {

/// What unwraps a whole surface; a part of it gets its share.
constexpr ChartSurfaceOptions whole_chart;

/// Indices of a segment's triangles by their ids.
std::unordered_map<int, int> index_of_ids(const std::vector<int>& ids) {
  std::unordered_map<int, int> index;
  for (int i = 0; i < int(ids.size()); ++i) index[ids[i]] = i;
  return index;
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

FlattenedChart flatten_charts(ReferenceChart section, double mean_area, double stretch, double largest) {
  FlattenedChart unrolled{std::move(section), {}};
  const Surface& surface = unrolled.section.surface;
  const double share = std::clamp(surface.area / mean_area, 1e-9, 1.0);
  const ChartSurfaceOptions options{
      .stretch = stretch,
      .seam_cost = whole_chart.seam_cost / std::sqrt(share),
      .largest = std::min(1.0, largest * whole_chart.largest / share),
      .longest = whole_chart.longest / std::sqrt(share),
      .patches = std::max(1, int(std::ceil(whole_chart.patches * share))),
      .triangles = std::max(100, int(whole_chart.triangles * share))};
  const ChartHistory history = find_charts(surface, options);
  ChartMerging merging(surface, history.patches.patch, history.patches.count);
  unrolled.charts = lay_flat(surface, history, stretch, &unrolled.section.lengths, merging);
  for (FlatChart& flat : unrolled.charts) scale_for_stretch(flat);
  return unrolled;
}

}  // namespace

ReferenceCharts::ReferenceCharts(const EvolvingMesh& evolving, const NeighbourGraph& graph,
                                 const std::vector<Period>& periods, int metric_frames)
    : evolving_(evolving), graph_(graph), periods_(periods), metric_frames_(metric_frames) {
  for (const Period& period : periods) {
    triangle_of_.push_back(index_of_ids(evolving.segments[period.segment].triangle_ids));
    vertex_of_.push_back(index_of_ids(evolving.segments[period.segment].vertex_ids));
  }
}

ReferenceChart ReferenceCharts::operator()(const LifespanChart& chart) const {
  ReferenceChart section;
  const EvolvingSegment& segment = evolving_.segments[periods_[chart.first].segment];
  std::unordered_map<int, int> local;
  std::vector<int> vertex_ids;
  Mesh mesh;
  for (const int c : chart.chains) {
    const int t = triangle_of_[chart.first].at(graph_.chains[c].triangle);
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
  std::vector<Moment> moments;
  for (int i = 0; i < count; ++i)
    moments.push_back(moment(chart, mesh.triangles, vertex_ids,
                             first + int((2LL * i + 1) * (last - first + 1) / (2LL * count))));
  section.lengths = mean_squares(moments);
  if (std::ranges::none_of(moments, &Moment::is_whole) ||
      std::ranges::any_of(section.lengths, [](const auto& edges) { return edges[0] < 0; })) {
    // Some are gone before any of these frames.
    moments.push_back(moment(chart, mesh.triangles, vertex_ids, first));
    const auto begun = moments.back().squares;
    for (std::size_t t = 0; t < section.lengths.size(); ++t)
      if (section.lengths[t][0] < 0) section.lengths[t] = begun[t];
  }
  double least = std::numeric_limits<double>::infinity();
  for (const Moment& at : moments) {
    if (!at.is_whole) continue;
    double difference = 0;
    for (std::size_t t = 0; t < section.lengths.size(); ++t)
      for (int k = 0; k < 3; ++k) difference += std::abs(at.squares[t][k] - section.lengths[t][k]);
    if (difference < least) least = difference, mesh.positions = at.positions;
  }
  for (auto& edges : section.lengths)
    for (double& length : edges) length = std::sqrt(length);
  section.surface = make_surface(mesh, {.kind = WeldOptions::Kind::none});
  return section;
}

/// A chart's triangles, of these vertices, at one frame; those that are gone by then are left out.
ReferenceCharts::Moment ReferenceCharts::moment(const LifespanChart& chart,
                                                const std::vector<Triangle>& triangles,
                                                const std::vector<int>& vertex_ids,
                                                int frame) const {
  const int period =
      int(std::ranges::upper_bound(periods_, frame, {}, &Period::first) - periods_.begin()) - 1;
  Moment result;
  result.positions.reserve(vertex_ids.size());
  for (const int id : vertex_ids) {
    const auto v = vertex_of_[period].find(id);
    result.positions.push_back(v != vertex_of_[period].end()
                                   ? evolving_.frames[frame].positions[v->second]
                                   : Vector3::Zero());
  }
  result.squares = squared_lengths(triangles, result.positions);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (!triangle_of_[period].contains(graph_.chains[chart.chains[t]].triangle)) {
      result.squares[t].fill(-1);
      result.is_whole = false;
    }
  return result;
}

/// Of each triangle over the moments that have it; −1 where none does.
EdgeLengths ReferenceCharts::mean_squares(const std::vector<Moment>& moments) {
  EdgeLengths result(moments.front().squares.size());
  for (std::size_t t = 0; t < result.size(); ++t) {
    const auto count = std::ranges::count_if(moments, [&](const Moment& at) { return at.squares[t][0] >= 0; });
    result[t].fill(count > 0 ? 0 : -1);
    for (const Moment& at : moments)
      for (int k = 0; k < 3 && at.squares[t][0] >= 0; ++k) result[t][k] += at.squares[t][k] / double(count);
  }
  return result;
}

std::vector<FlattenedChart> flatten_charts(const std::vector<LifespanChart>& charts,
                                           const ReferenceCharts& reference_chart, double area,
                                           double stretch, double largest, const Progress& progress) {
  // The large ones first, so that none is left over for one thread at the end.
  std::vector<int> order(charts.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, std::ranges::greater{},
                           [&](int c) { return charts[c].chains.size(); });
  std::vector<FlattenedChart> unrolled(charts.size());
  std::atomic<std::size_t> done = 0;
  std::size_t all = 0;
  for (const LifespanChart& chart : charts) all += chart.chains.size();
  parallel_for(
      std::ssize(order),
      [&](std::int64_t i) {
        const LifespanChart& chart = charts[order[i]];
        progress.check();
        unrolled[order[i]] = flatten_charts(reference_chart(chart), area, stretch, largest);
        progress.at(double(done += chart.chains.size()) / double(all));
      },
      1);
  return unrolled;
}

}  // namespace mq
