#pragma once
/// The scales of flow on surfaces, at vertices and at texels.

#include <vector>

#include "mq/flow/detail/coarse_to_fine.h"
#include "mq/flow/surface_optical_flow.h"

namespace mq {

/// How often α* is halved on surfaces before a correction is given up.
inline constexpr int surface_halvings = 2;

/// Throws `InvalidInput` where numbers of options make no sense.
void require_options(const MeshFlowOptions& options);

/// A length in model units. Throws `InvalidInput` where it is negative or not finite; `what` names it.
double flow_length(const Length& length, const SurfaceScale& scale, const char* what);

/// From the largest length on halved, down to the smallest, where none is given to so many spacings, on a domain whose
/// unknowns lie so far apart.
std::vector<FlowScale> surface_scales(const MeshFlowOptions& options, const SurfaceScale& scale, double spacing,
                                      double last);

/// What `coarse_to_fine` makes of an aligner on a surface: its field and levels, with the errors that these have.
template <class Aligner>
MeshFlow surface_flow(Aligner& aligner, const std::vector<FlowScale>& scales, const FlowOptions& options,
                      const Progress& progress) {
  aligner.begin(scales);
  const std::vector<double> errors =
      coarse_to_fine(aligner, scales, options,
                     {.halvings = surface_halvings, .after_worse = FlowPolicy::AfterWorse::better}, progress);
  MeshFlow flow;
  flow.blend_error = errors.front();
  flow.levels = aligner.take_levels();
  for (std::size_t l = 0; l < flow.levels.size(); ++l) flow.levels[l].error = errors[l + 1];
  flow.field = aligner.take_field();
  return flow;
}

}  // namespace mq
