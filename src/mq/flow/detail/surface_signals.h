#pragma once
/// How signals on a mesh are prepared before they are aligned.

#include "mq/flow/surface_levels.h"

namespace mq {

/// Smooth: (M + weight·S)⁻¹·M·φ.
Signal smoothed(const FlowMesh& mesh, const Signal& signal, double weight, double tolerance);

/// Where what varies slowly is found.
enum class LightOn {
  finest,       ///< the mesh itself, exactly (the thesis)
  coarser_mesh  ///< the coarsest that shows it
};

/// A signal less what varies slowly, φ − Smooth(φ, detail²).
Signal without_light(const FlowMeshes& meshes, const Signal& signal, double detail, LightOn where);

/// The channels, and |∇φ_c| times `factor` behind them: the root mean square over the triangles
/// around each vertex.
Signal with_slopes(const FlowMesh& mesh, const Signal& signal, double factor);

/// Each to a variance of 1 over all channels, less the mean of both, channel by channel. Not each less
/// its own: what moves over a boundary changes it.
void bring_to_scale(const FlowMesh& mesh, Signal& source, Signal& target);

/// Each channel to its variance in `original`, as the thesis' program does.
void bring_to_scale_of(const FlowMesh& mesh, Signal& details, const Signal& original);

}  // namespace mq
