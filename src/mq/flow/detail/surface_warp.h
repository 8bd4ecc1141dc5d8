#pragma once
/// Signals as they are found along a field.

#include <vector>

#include "mq/flow/surface_levels.h"
#include "mq/flow/surface_optical_flow.h"
#include "mq/trace/surface_flow.h"

namespace mq {

/// Where the source and the target are looked up for each vertex. Empty: at the vertex itself.
struct WarpEnds {
  std::vector<SurfacePoint> source, target;
};

/// Ends of paths along −X and X for ½ each, or along X for 1 (`FlowAlignment::forward`), from every
/// vertex; with `starts` from these points instead.
WarpEnds warp_ends(const TraceMesh& mesh, const Vector& field, FlowAlignment alignment,
                   const std::vector<SurfacePoint>* starts = nullptr,
                   const Progress& progress = {});

/// A signal at these points, linear in triangles; as it is where there are none. At a point without
/// a triangle, which only the i-th of as many points as vertices may be, its i-th value.
Signal sampled(const Mesh& mesh, const Signal& signal, const std::vector<SurfacePoint>& points);

/// ∫ Σ_c |a − b|² dA / (area · channels), with the lumped mass.
double mean_square_difference(const Vector& lumped_mass, const Signal& a, const Signal& b);

}  // namespace mq
