#pragma once
/// Few charts of little stretch.

#include <vector>

#include "mq/base/progress.h"
#include "mq/unwrap/detail/chart_merging.h"
#include "mq/unwrap/detail/chart_patches.h"

namespace mq {

struct ChartSurfaceOptions {
  double stretch = 1.06;    ///< the most L² stretch that gluing may give a chart
  double seam_cost = 0.15;  ///< energy that is worth a seam of length √area, per area
  /// No union may have more of the area, nor in the plane a box whose diagonal is longer, in √area:
  /// what is smaller packs better.
  double largest = 0.2, longest = 1.2;
  int patches = 80;      ///< about so many discs at the start
  int triangles = 2500;  ///< of the coarsened surface on which unions are tried
};

/// Discs on a surface and the order in which they are glued to charts.
struct ChartHistory {
  struct Step {
    std::array<int, 2> charts{-1, -1};  ///< patches, then steps from `patches.count` on; equal for
                                        ///< a chart that is glued to itself
    Vector3 middle = Vector3::Zero();   ///< of the seam that goes
  };
  SurfacePatches patches;
  std::vector<Step> steps;
};

/// Glues patches to charts, two neighbours at a time, those first whose union is laid flat with the
/// least energy less the worth of the seam that goes, as long as there are two whose union stays
/// below the bound, does not fold and does not overlap itself. Each union is tried: it is laid out
/// from its two parts, turned to fit along the seam, and relaxed as rigidly as possible. Cuts
/// inside a chart close where they are worth less than the energy it takes. All this on a coarser
/// surface where there is one; the patches found are those of the given surface.
///
/// The same for every scale of the surface. About 1 ms per union of 300 triangles.
ChartHistory find_charts(const Surface& surface, const ChartSurfaceOptions& options = {},
                         const Progress& progress = {});

/// The charts after all steps that are not `refused` (1 per step; empty: none is). A step whose
/// parts are not there, or have no seam, is left out; so is what builds on the lesser part of a
/// refused one. `step_of` says which step made each chart, -1 for patches.
ChartMerging replay(const Surface& surface, const ChartHistory& history,
                    const std::vector<char>& refused, std::vector<int>& step_of);

}  // namespace mq
