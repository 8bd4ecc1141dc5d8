#pragma once
/// Charts in space and time, laid flat by the mean of their lengths over time.

#include <unordered_map>
#include <vector>

#include "mq/base/progress.h"
#include "mq/evolving/lifespan_charts.h"
#include "mq/unwrap/flat_charts.h"

namespace mq {

/// One chart's triangles at one moment, with vertices of their own.
struct ReferenceChart {
  Surface surface;
  EdgeLengths lengths;         ///< mean over time
  std::vector<int> triangles;  ///< of the chart's first segment
};

/// Of charts, each where its frames resemble their mean most.
class ReferenceCharts {
 public:
  /// Of charts of this graph; lengths are the mean over up to `metric_frames` frames of a chart's
  /// life, of a triangle that ends before its chart over those that have it. All must live as long.
  ReferenceCharts(const EvolvingMesh& evolving, const NeighbourGraph& graph,
                  const std::vector<Period>& periods, int metric_frames);

  ReferenceChart operator()(const LifespanChart& chart) const;

 private:
  struct Moment {
    std::vector<Vector3> positions;  // per vertex
    EdgeLengths squares;             // per triangle; −1: it is gone
    bool is_whole = true;
  };
  Moment moment(const LifespanChart& chart, const std::vector<Triangle>& triangles,
                const std::vector<int>& vertex_ids, int frame) const;
  static EdgeLengths mean_squares(const std::vector<Moment>& moments);

  const EvolvingMesh& evolving_;
  const NeighbourGraph& graph_;
  const std::vector<Period>& periods_;
  int metric_frames_;
  std::vector<std::unordered_map<int, int>> triangle_of_, vertex_of_;  // per period, by id
};

/// A chart of the charting, and the charts that unwrapping made of it.
struct FlattenedChart {
  ReferenceChart section;
  std::vector<FlatChart> charts;
};

/// Each of the charts as by `unwrap`, with its share of what a whole surface of `area` is given; `largest` is the most
/// that one may have in the plane, as a part of what `unwrap` lets it have.
std::vector<FlattenedChart> flatten_charts(const std::vector<LifespanChart>& charts,
                                           const ReferenceCharts& reference_chart, double area,
                                           double stretch, double largest, const Progress& progress = {});

}  // namespace mq
