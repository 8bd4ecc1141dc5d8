#pragma once
/// Integral curves in the texture itself: over the cells between texels, and over seams.

#include <span>
#include <vector>

#include "mq/base/progress.h"
#include "mq/trace/path_counts.h"
#include "mq/trace/trace_atlas.h"

namespace mq {

/// Where paths end, and what they did on the way.
struct TracedTexels {
  std::vector<ChartPlace> ends;
  std::vector<char> circled;  ///< 1: went round at a border and rests there
  PathCounts counts;
};

/// A field on an atlas, prepared to be followed without steps: dp/dt = X(p), exact to rounding. Within charts it is
/// the automaton of `SurfaceFlow`, which says what happens at edges, vertices and where a field is 0, on the triangles
/// of `TraceAtlas`; X is constant on each of these.
///
/// **Seams.** Where a chart ends in a cell, a path goes on at the same point of the surface in the other chart, if the
/// field there leads away from the seam. Where it leads back, the path slides along the seam with the combination of
/// both vectors that has no part across it, until either side's field changes or one of them leads away. At a vertex
/// on a border it takes the fastest of the ways into the charts and along the seams around, of equally fast ones that of
/// the first triangle in the file, or comes to rest. Where the surface ends a path slides along with the part of X that
/// does.
///
/// For X = −∇P, P linear on the triangles (`downhill`), P falls strictly along every path within a chart, and paths come
/// to rest at texels that are minima of P among their neighbours, or on seams. From one chart to the next P may step, by
/// as much as its texels on both sides disagree about the seam: nearly nothing where P solves an equation on the surface
/// (`ScreenedPoisson`). A path that goes round because of this rests where it came to a border for the thousandth time.
class AtlasFlow {
 public:
  /// X = −∇P of values at the texels, size() of the space; gradients are those of the surface. The domain must outlive
  /// the flow. Throws `InvalidInput` where P has the wrong size or is not finite.
  static AtlasFlow downhill(const TraceAtlas& domain, const Vector& potential);

  /// Any field, constant on each cell: texels per unit of time to the right and down, one per cell of `TexelGrid`, as
  /// `TexelVectorSpace::velocities` has them; those of cells that no chart covers are not looked at.
  static AtlasFlow along(const TraceAtlas& domain, const std::vector<std::array<double, 2>>& field);

  /// Follows each start for `time` (not negative, may be infinite).
  TracedTexels trace(std::span<const ChartPlace> starts, double time, const Progress& progress = {}) const;

  const TraceAtlas& domain() const { return *domain_; }

  // What `walk::follow` asks for. Triangle 2·cell + s has its right angle in the cell's upper (s = 0) or lower (s = 1)
  // row; that is its corner 0.
  std::array<double, 3> rates(int t) const;
  std::int64_t across(int t, int k) const;
  std::int64_t leave(int t, int k) const;
  double slide_rate(int t, int k) const;
  std::int64_t exit(int t, int k) const;
  double speed(int t) const;
  void prefetch(int t) const { __builtin_prefetch(potential_.empty() ? (const void*)&field_[t >> 1] : &potential_[t >> 1]); }

  /// X in a triangle, texels per unit of time.
  Vector2 velocity(int t) const;
  /// Where corner k of a triangle is in its cell.
  Vector2 corner(int t, int k) const;

 private:
  explicit AtlasFlow(const TraceAtlas& domain) : domain_(&domain) {}
  double slide_rate_from(int t, int k) const;

  const TraceAtlas* domain_;
  std::vector<double> potential_;             ///< per node; empty where a field is given
  std::vector<std::array<double, 2>> field_;  ///< per cell
};

}  // namespace mq
