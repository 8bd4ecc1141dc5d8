#pragma once
/// What a `RollingAtlas` knows, and the charts that it has planned.

#include <algorithm>
#include <array>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "mq/evolving/detail/flattened_charts.h"
#include "mq/evolving/detail/rolling_atlas.h"

namespace mq {

/// What is known, and the charts that are planned for it.
struct RollingAtlas::Plan {
  int first_period = 0;  // of the film; the first of the window
  EvolvingMesh window;
  std::vector<Period> periods;
  NeighbourGraph graph;
  double area = 0;
  double largest = 1;  // chart, as a part of what `unwrap` lets it have
  LifespanCharts charting;
  std::optional<ReferenceCharts> reference_chart;
  std::unordered_map<int, int> chain_of;  // by triangle
  /// A flat chart of a planned one.
  struct Part {
    int chart = 0;
    int body = 0;                // number of what was laid flat together
    std::vector<int> triangles;  // of the sheet, indices in the chart's first segment
    FlatChart flat;
    Placement place;
  };
  std::vector<Part> parts;  // that have a place, by charts
  bool is_packed_together = false;

  /// Charts, each with some of its chains, as flat parts.
  std::vector<Part> lay_flat(const std::vector<std::pair<int, std::vector<int>>>& charts,
                             double stretch, int& bodies, const Progress& progress) const {
    std::vector<LifespanChart> chosen;
    for (const auto& [c, chains] : charts) {
      chosen.push_back(charting.charts[c]);
      chosen.back().chains = chains;
    }
    std::vector<FlattenedChart> unrolled =
        flatten_charts(chosen, *reference_chart, area, stretch, largest, progress);
    std::vector<Part> result;
    for (std::size_t i = 0; i < charts.size(); ++i) {
      for (FlatChart& flat : unrolled[i].charts) {
        Part part{.chart = charts[i].first,
                  .body = bodies,
                  .triangles = {},
                  .flat = std::move(flat),
                  .place = {}};
        for (const int t : part.flat.sheet.sources)
          part.triangles.push_back(unrolled[i].section.triangles[t]);
        result.push_back(std::move(part));
      }
      ++bodies;
    }
    return result;
  }

  /// The same of whole charts.
  std::vector<Part> lay_flat(const std::vector<int>& charts, double stretch, int& bodies,
                             const Progress& progress) const {
    std::vector<std::pair<int, std::vector<int>>> whole;
    for (const int c : charts) whole.emplace_back(c, charting.charts[c].chains);
    return lay_flat(whole, stretch, bodies, progress);
  }

  /// A part as something to place, with the frames of the window.
  PackChart outline(const Part& part) const {
    PackChart result = outline_of(part.flat);
    result.first = periods[charting.charts[part.chart].first].first;
    result.last = periods[charting.charts[part.chart].last].last;
    return result;
  }

  /// The chains of a part on either side of its middle, across where it is longest.
  std::array<std::vector<int>, 2> halves(const Part& part) const {
    Vector2 low = part.flat.x.front(), high = low;
    for (const Vector2& p : part.flat.x) low = low.cwiseMin(p), high = high.cwiseMax(p);
    const int axis = high.x() - low.x() >= high.y() - low.y() ? 0 : 1;
    std::vector<std::pair<double, int>> along;
    const auto& ids = window.segments[periods[charting.charts[part.chart].first].segment];
    for (std::size_t t = 0; t < part.triangles.size(); ++t) {
      double place = 0;
      for (const int v : part.flat.sheet.triangles[t]) place += part.flat.x[v][axis];
      along.emplace_back(place, chain_of.at(ids.triangle_ids[part.triangles[t]]));
    }
    std::ranges::sort(along);
    std::array<std::vector<int>, 2> result;
    for (std::size_t i = 0; i < along.size(); ++i)
      result[2 * i < along.size() ? 0 : 1].push_back(along[i].second);
    for (auto& chains : result) std::ranges::sort(chains);
    return result;
  }
};

}  // namespace mq
