#pragma once
/// The same surface with fewer vertices, for what varies slowly.

#include <vector>

#include "mq/base/progress.h"
#include "mq/mesh/closest_point.h"
#include "mq/mesh/surface.h"

namespace mq {

/// A coarser surface whose vertices are some of the finer one's.
struct CoarsenedSurface {
  Surface surface;          ///< positions and triangles only
  std::vector<int> source;  ///< per vertex here its vertex on the finer surface
  /// Per vertex of the finer surface where it lies on this one: its own vertex where it stayed,
  /// else the nearest point of the triangles around; triangle −1 where no triangle uses it.
  std::vector<ClosestPoint> places;
};

/// Removes vertices until those that are left are about `spacing` (model units) apart; where they
/// already are, nothing changes. A vertex goes by collapsing the edge to that neighbour which
/// leaves the best triangles around it (Hoppe [hoppe1996progressive]), densest places first, no two
/// neighbours in one round. Never changed: the topology, boundary corners of more than 37°. No
/// triangle flips, and none becomes a sliver where there was none; so places that are strongly
/// bent may stay finer.
///
/// About 3 µs per vertex, of which a third runs on one thread only.
CoarsenedSurface coarsen(const Surface& surface, double spacing, const Progress& progress = {});

}  // namespace mq
