#pragma once
/// A surface cut into discs, which are glued to each other one seam at a time.
///
/// Two discs glued along one connected piece of their boundaries are a disc; what else they have in
/// common stays a cut inside the new chart, so that a leg becomes one chart with a slit, whatever
/// the topology of the surface. A chart may also be glued to itself along such a cut: that closes
/// it, or leaves a hole.

#include <array>
#include <vector>

#include "mq/mesh/surface.h"

namespace mq {

/// A connected piece of the boundary between two charts, or between two sides of one.
struct ChartSeam {
  std::array<int, 2> charts{-1, -1};  ///< equal for a cut inside a chart
  std::vector<HalfEdge> edges;        ///< of charts[0], one after the other along its boundary
  double length = 0;                  ///< model units
};

class ChartMerging {
 public:
  /// `patches` per triangle, each a disc; -1: a triangle of no chart. `count` patches.
  ChartMerging(const Surface& surface, const std::vector<int>& patches, int count);

  /// Charts ever made: the patches, then one per merge.
  int chart_count() const { return int(members_.size()); }
  bool is_whole(int chart) const { return parents_[chart] < 0; }  ///< not glued to another since
  const std::vector<int>& triangles(int chart) const { return members_[chart]; }
  int chart(int triangle) const { return charts_[triangle]; }
  const std::vector<char>& merged() const { return merged_; }  ///< per half-edge
  /// What it was made of: two charts, one that was glued to itself (and -1), nothing (-1, -1:
  /// patches).
  std::array<int, 2> parts(int chart) const { return parts_[chart]; }

  /// The gluing that joined two triangles of a whole chart, as the chart that it made.
  int joint(int chart, int triangle, int other) const;

  /// Seams with all neighbours and with itself, as long as they can be.
  std::vector<ChartSeam> seams(int chart) const;

  /// Whether gluing along it would leave no boundary: what is closed does not lie flat.
  bool closes(const ChartSeam& seam) const;

  /// Those half-edges that gluing along a seam joins, both sides.
  std::vector<HalfEdge> joined(const ChartSeam& seam) const;

  /// The chart made by gluing.
  int merge(const ChartSeam& seam);

 private:
  std::vector<std::vector<HalfEdge>> loops(int chart) const;
  void add_seams(int chart, const std::vector<HalfEdge>& loop, std::vector<ChartSeam>& seams) const;
  HalfEdge next_at_boundary(HalfEdge h) const;
  bool follows(HalfEdge h, HalfEdge after) const;

  const Surface* surface_;
  std::vector<int> charts_;
  std::vector<char> merged_;
  std::vector<std::vector<int>> members_;
  std::vector<int> parents_;
  std::vector<std::array<int, 2>> parts_;
};

}  // namespace mq
