#pragma once
/// Normals without their noise, by what other papers do: to compare the shock filter with.

#include <vector>

#include "mq/base/progress.h"
#include "mq/mesh/surface.h"

namespace mq {

struct BilateralNormalOptions {
  double place = 1;       ///< σ_c in mean distances of the centroids of neighbouring triangles
  double difference = 0.35;  ///< σ_s: |n_i − n_j|, about the angle in radians
  int iterations = 20;
};

/// Bilateral filtering of the normals of triangles, the local iterative scheme of Zheng, Fu, Au and
/// Tai [zheng2011bilateral]: in each iteration
///
///     n_i ← normalised Σ_j A_j exp(−|c_i − c_j|² / 2σ_c²) exp(−|n_i − n_j|² / 2σ_s²) n_j
///
/// over the triangles j within 3 σ_c of i that are joined to it through vertices of such triangles,
/// and i itself; A areas, c centroids. (Theirs are the triangles next to i; a σ_c of 1 leaves as
/// many.) A unit normal per triangle, 0 where it has no area. Positions: `NormalFit`. Costs
/// O(iterations × triangles × neighbours). Throws `InvalidInput` on options out of range.
std::vector<Vector3> bilateral_normals(const Surface& surface,
                                       const BilateralNormalOptions& options = {},
                                       const Progress& progress = {});

struct MeanShiftNormalOptions {
  double place = 2;          ///< bandwidth, as above
  double difference = 0.35;  ///< bandwidth, as above
  int most_steps = 50;      ///< of one triangle on its way to a mode
};

/// Mean shift of normals ([comaniciu2002mean]; on meshes [shamir2006geodesic,
/// solomon2014bilateral]): every triangle climbs, in place and normal together, to a mode of the
/// density of all pairs (c_j, n_j) of the input, and takes the normal found there. A step moves the
/// normal to the mean above, of the input's n_j, around the triangle where the path is, and the
/// place to the triangle whose centroid is closest to the mean of the c_j. It ends where the place
/// stays, or goes back, and the normal turns by less than 10⁻³, or after `most_steps`.
std::vector<Vector3> mean_shift_normals(const Surface& surface,
                                        const MeanShiftNormalOptions& options = {},
                                        const Progress& progress = {});

}  // namespace mq
