#pragma once
/// The half-edges where charts end, at seams and at the boundary of the surface, cell by cell.

#include <span>
#include <vector>

#include "mq/mesh/geometry.h"
#include "mq/trace/trace_atlas.h"

namespace mq {

/// The part of a half-edge in the coordinates of a cell it runs through.
struct BorderSegment {
  HalfEdge half_edge;
  int chart;
  Vector2 from, edge;  ///< its source in the cell, and the way to its end
  double turn;         ///< ±1: a point p is inside where turn · cross(edge, p − from) > 0
};

class AtlasBorders {
 public:
  AtlasBorders(const Surface& surface, const Atlas& atlas, const TraceAtlas& domain);

  const Surface& surface() const { return surface_; }
  const Atlas& atlas() const { return atlas_; }

  bool is_border(HalfEdge h) const {
    return atlas_.chart[std::size_t(h / 3)] >= 0 && !surface_.degenerate[std::size_t(h / 3)] &&
           atlas_.edges[std::size_t(h)] != EdgeKind::inside;
  }
  /// Across a seam; −1 where the surface ends, or its part with a chart.
  HalfEdge across(HalfEdge h) const;

  /// The segments of a cell; empty where none runs through it.
  std::span<const BorderSegment> of(int cell) const;
  /// All cells with segments.
  const std::vector<int>& cells() const { return cells_; }

  int chart(HalfEdge h) const { return atlas_.chart[std::size_t(h / 3)]; }
  int texture(HalfEdge h) const { return atlas_.charts[std::size_t(chart(h))].texture; }
  /// Its source in its texture, in texels.
  Vector2 source(HalfEdge h) const;
  Vector2 edge(HalfEdge h) const { return source(next(h)) - source(h); }
  Vector2 at(HalfEdge h, double s) const { return source(h) + s * edge(h); }
  double turn(HalfEdge h) const;
  double length(HalfEdge h) const;  ///< on the surface

 private:
  const Surface& surface_;
  const Atlas& atlas_;
  std::vector<int> cells_, offsets_;
  std::vector<BorderSegment> segments_;
};

}  // namespace mq
