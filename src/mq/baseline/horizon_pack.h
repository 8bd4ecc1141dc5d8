#pragma once
/// Charts packed by horizons, as the thesis does it (6.4.4, after [levy2002least]), to compare `pack` with.

#include <vector>

#include "mq/base/progress.h"
#include "mq/unwrap/flat_charts.h"

namespace mq {

struct HorizonPackOptions {
  int width = 1024, height = 1024;  ///< texels
  int gutter = 2;                   ///< texels that stay free between charts that live together
  int lines = 16;                   ///< horizontal ones, and as many vertical ones
  int directions = 1;               ///< in which a chart may lie, of a full turn
};

/// Places all charts at the largest scale found. Charts are placed by falling area. Of those that are placed and live
/// at the same time as the next one all texels are taken; around each of `lines` evenly spaced horizontal lines the
/// texture's horizon is, per column, the free texels around the line. The chart's horizon is the lowest and highest
/// texel that it touches in each of its columns, the gutter added. Wherever one fits into the other there is room; and
/// likewise for vertical lines and rows. Of all such places the chart gets the one whose middle (mean of the texels
/// touched) is nearest to that of all the charts placed so far; the first chart, to the middle of the texture.
///
/// The thesis does not say in which direction charts lie: they stand with their longest diameter upright, as in
/// [levy2002least], or are turned from there by multiples of 360° / `directions`. Nor does it say where the first chart
/// goes, nor how the scale is found: it is halved down to a thousandth.
///
/// Texels, gutters and borders are those of `pack`, and so are the results. Costs, per chart and scale, a few passes
/// over the texture, and per place that is tried the columns up to the first that does not fit. Throws `InvalidInput`
/// where there is no chart with area, a chart ends before it begins, an option is out of range, or charts do not fit
/// at any scale.
Packing horizon_pack(const std::vector<PackChart>& charts, const HorizonPackOptions& options = {},
                     const Progress& progress = {});

}  // namespace mq
