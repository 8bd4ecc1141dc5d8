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

FlattenedChart flatten_charts(ReferenceChart section, double mean_area, double stretch) {
  FlattenedChart unrolled{std::move(section), {}};
  const Surface& surface = unrolled.section.surface;
  const double share = std::clamp(surface.area / mean_area, 1e-9, 1.0);
  const ChartSurfaceOptions options{
      .stretch = stretch,
      .seam_cost = whole_chart.seam_cost / std::sqrt(share),
      .largest = std::min(1.0, whole_chart.largest / share),
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
      for (int k = 0; k < 3; ++k) difference += std::abs(squares[i][t][k] - section.lengths[t][k]);
    if (difference < least) least = difference, mesh.positions = frames[i];
  }
  for (auto& edges : section.lengths)
    for (double& length : edges) length = std::sqrt(length);
  section.surface = make_surface(mesh, {.kind = WeldOptions::Kind::none});
  return section;
}

std::vector<Vector3> ReferenceCharts::positions(const std::vector<int>& vertex_ids,
                                                int frame) const {
  const int period =
      int(std::ranges::upper_bound(periods_, frame, {}, &Period::first) - periods_.begin()) - 1;
  std::vector<Vector3> result;
  result.reserve(vertex_ids.size());
  for (const int id : vertex_ids)
    result.push_back(evolving_.frames[frame].positions[vertex_of_[period].at(id)]);
  return result;
}

std::vector<FlattenedChart> flatten_charts(const std::vector<LifespanChart>& charts,
                                           const ReferenceCharts& reference_chart, double area,
                                           double stretch, const Progress& progress) {
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
        unrolled[order[i]] = flatten_charts(reference_chart(chart), area, stretch);
        progress.at(double(done += chart.chains.size()) / double(all));
      },
      1);
  return unrolled;
}

}  // namespace mq
