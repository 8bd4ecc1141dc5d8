#pragma once
/// Paths of straight segments, as the thesis follows a field (3.4.1): the vector at a point is
/// carried on without turning, across as many triangles as the segment is long.

#include <limits>
#include <span>

#include "mq/base/progress.h"
#include "mq/linear/matrix.h"
#include "mq/trace/surface_flow.h"

namespace mq {

struct StraightOptions {
  /// Longest way, model units, before the vector is read again. The thesis takes the mean edge
  /// length; with infinity a path is one geodesic, with the vector at its start.
  double step = std::numeric_limits<double>::infinity();
};

/// dp/dt = X(p) in segments p + s·d, d = X(p), of length at most `step`. Across an edge the next
/// triangle is unfolded into the plane of the one before, so that d keeps its angle with the edge
/// (Figure 3.5). `field` is as in `SurfaceFlow::along`.
///
/// - **Vertices.** A segment that meets a vertex exactly ends there. At a vertex, also at a start,
/// the
///   vector is that of the triangle around into which it points, the longest of them; where none
///   does, and no boundary leads on, the path rests.
/// - **Boundaries** (also cuts and triangles without area): the rest of the segment runs along the
///   edge, with the part of d along it, to the edge's end at most; there the field is read again.
/// - **Opposing fields** are not noticed: where neighbours point at each other a path goes to and
/// fro by
///   less than a step until its time is over. `SurfaceFlow`, which needs no step, slides there.
/// - A start on an edge takes the vector of the triangle it is given in.
///
/// First order in the step for smooth fields. Throws `InvalidInput` as `SurfaceFlow` does, and on a
/// step that is not positive. Paths are stopped after 2²⁴ segments and crossings.
Traced straight_paths(const TraceMesh& mesh, const Vector& field,
                      std::span<const SurfacePoint> starts, double time,
                      const StraightOptions& options, const Progress& progress = {});

}  // namespace mq
