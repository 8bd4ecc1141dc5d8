#pragma once
/// Charts cut where they share texels with themselves.

#include <vector>

#include "mq/atlas/atlas.h"
#include "mq/atlas/footprint.h"
#include "mq/base/progress.h"

namespace mq {

/// Connected parts of charts in which every texel stands for one place of the surface: the
/// triangles of a sheet that come closer to the texel than one column and one row hang together, at
/// edges or corners not farther off than two, and none lies flipped on another. (Around one
/// vertex nothing is told apart, even where corners wind around it by more than a full turn.)
struct InjectiveParts {
  std::vector<int> part;   ///< per triangle; -1 where there is no chart
  std::vector<int> chart;  ///< per sheet; a chart that needs no cut is one sheet

  int count() const { return int(chart.size()); }
};

/// Sheets grow triangle by triangle over edges inside charts and stop where a texel would come to
/// stand for two places. Numbered by chart, the largest of a chart first. Linear in the texels
/// along the borders of charts, and in those of the footprints.
InjectiveParts find_injective_parts(const Surface& surface, const Atlas& atlas,
                                    const Footprints& footprints, const Progress& progress = {});

}  // namespace mq
