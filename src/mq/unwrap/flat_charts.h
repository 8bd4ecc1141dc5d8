#pragma once
/// Charts of a surface, laid flat one by one.

#include <vector>

#include "mq/base/progress.h"
#include "mq/mesh/surface.h"
#include "mq/unwrap/detail/chart_surface.h"
#include "mq/unwrap/detail/pack.h"
#include "mq/unwrap/detail/parametrize.h"

namespace mq {

struct FlatChart {
  Sheet sheet;
  Points x;            ///< per vertex of the sheet, in units of the surface
  double stretch = 0;  ///< L²
  std::vector<std::array<HalfEdge, 2>> crossings;  ///< of its boundary; none in a chart returned
};

/// Every chart that gluing as in `history` makes, each without a flipped triangle and without
/// overlap: gluings after which a chart cannot be, or has more stretch than the bound allows, are
/// refused, and patches that cannot be are halved. `merging` receives what was glued. With
/// `lengths`, of every triangle its edges from each corner to the next, charts are laid out as
/// isometric to these as can be, not to the surface itself.
std::vector<FlatChart> lay_flat(const Surface& surface, ChartHistory history, double stretch,
                                const EdgeLengths* lengths, ChartMerging& merging,
                                const Progress& progress = {});

/// Scales a chart so that it has the density at which charts together have the least L² stretch.
void scale_for_stretch(FlatChart& flat);

/// The chart as something to place.
PackChart outline_of(const FlatChart& flat);

/// Appends the texture coordinates of a placed chart, one per vertex of the sheet, in a texture of
/// this size.
void append_uvs(const FlatChart& flat, const Placement& place, double scale, int width, int height,
                std::vector<Vector2>& uvs);

}  // namespace mq
