#pragma once
/// Correspondences between two surfaces that lie close to each other, by colour.

#include <vector>

#include "mq/flow/surface_optical_flow.h"
#include "mq/mesh/closest_point.h"
#include "mq/mesh/surface_point.h"

namespace mq {

/// For each vertex of the source a point of the target.
struct ColourRegistration {
  std::vector<SurfacePoint> closest;  ///< Φ_G: the closest point
  std::vector<SurfacePoint> points;   ///< Φ_C: where the flow of colours takes it
  /// 0 to 1, a product: 1/(1 + d²/v), d the difference of the colours that meet and v the variance
  /// of those of the target; λ/(λ + λ̄), λ the smaller eigenvalue of Σ_c ∇φ_c ∇φ_cᵀ of the target
  /// around the point (what a line or a plain colour cannot say) and λ̄ its mean; and max(0, cos) of
  /// the angle between the surfaces.
  std::vector<double> confidences;
  MeshFlow flow;  ///< on the target
};

/// Steps 2 to 5 of the thesis' tracking (4.8.2): colours of the source, already deformed to lie on
/// the target, are looked up at the closest point of every vertex of the target; flow aligns them
/// to the target's own; and closest points move along it, Φ_C(p) = Φ_X(Φ_G(p), 1). To move the
/// source by them and to ask again is the caller's affair (the thesis does so twice).
///
/// Colours have a row per vertex of their surface, the same channels on both. The hierarchical
/// options are a good choice. Throws what `mesh_flow` and `ClosestPointFinder` throw.
ColourRegistration register_by_colour(const Surface& source, const Signal& source_colours,
                                      const Surface& target, const Signal& target_colours,
                                      const MeshFlowOptions& options = {},
                                      const Progress& progress = {});

/// The same against one target for sources that change, such as one that follows what it found:
/// whatever the target alone decides is made once. Surface must outlive it; colours are kept.
class ColourRegistrar {
 public:
  ColourRegistrar(const Surface& target, const Signal& target_colours,
                  const MeshFlowOptions& options = {}, const Progress& progress = {});

  ColourRegistration operator()(const Surface& source, const Signal& source_colours,
                                const Progress& progress = {}) const;

 private:
  std::vector<double> confidences(const Surface& source, const Signal& source_colours,
                                  const ColourRegistration& found) const;

  const Surface& target_;
  Signal colours_;
  MeshFlowFinder flow_;
  ClosestPointFinder on_target_;
  Signal slopes_;  ///< per vertex the smaller eigenvalue of Σ_c ∇φ_c ∇φ_cᵀ
  double mean_slope_ = 0, variance_ = 0;
};

}  // namespace mq
