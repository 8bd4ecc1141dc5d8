#pragma once
/// How signals on a mesh are prepared before they are aligned.

#include "mq/flow/surface_levels.h"

namespace mq {

/// Smooth: (M + weight·S)⁻¹·M·φ.
Signal smoothed(const FlowMesh& mesh, const Signal& signal, double weight, double tolerance);

/// A signal less what varies slowly, φ − Smooth(φ, detail²); of the thesis exactly, otherwise found on
/// the coarsest mesh that shows it.
Signal without_light(const FlowMeshes& meshes, const Signal& signal, double detail, bool thesis);

/// The channels, and |∇φ_c| times `factor` behind them: the root mean square over the triangles
/// around each vertex.
Signal with_slopes(const FlowMesh& mesh, const Signal& signal, double factor);

/// To a variance of 1 over all channels; of the thesis, each channel to its variance in `original`.
void bring_to_scale(const FlowMesh& mesh, Signal& details, const Signal& original, bool thesis);

}  // namespace mq
