#include "mq/flow/detail/surface_scales.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "mq/base/error.h"

namespace mq {

namespace {

constexpr double length_rounding = 1e-9;  // of lengths that users give as they read them

}  // namespace

void require_options(const MeshFlowOptions& options) {
  require(options.levels >= 0 && options.levels <= 64 && options.steps > 0,
          fmt::format("{} levels of {} steps were wanted; 0 to 64 levels of at least one step are "
                      "possible",
                      options.levels, options.steps));
  for (const double value :
       {options.robust_data, options.robust_smoothness, options.gradient_weight})
    require(value >= 0 && std::isfinite(value),
            fmt::format("a weight of {} was given; one that is not negative was wanted", value));
}

double flow_length(const Length& length, const SurfaceScale& scale, const char* what) {
  require(std::isfinite(length.value) && length.value >= 0,
          fmt::format("{} of {} was given; a length that is not negative was wanted", what,
                      length.value));
  return std::sqrt(weight_from_length(length, scale));
}

std::vector<FlowScale> surface_scales(const MeshFlowOptions& options, const SurfaceScale& scale, double spacing,
                                      double last) {
  const double largest = flow_length(options.largest, scale, "a largest length");
  require(largest > 0, "the largest length must be positive");
  double smallest = flow_length(options.smallest, scale, "a smallest length");
  require(
      smallest <= largest,
      fmt::format("the smallest length, {:.4g}, is above the largest, {:.4g}", smallest, largest));
  if (options.levels > 0) return halved_scales(largest, (1 - length_rounding) * smallest, options.levels);
  if (smallest == 0) smallest = last * spacing;
  const double shown = std::max(1.5 * smallest, 2.5 * spacing);
  std::vector<FlowScale> scales = halved_scales(largest, shown);
  scales.push_back({std::min(largest, smallest), FlowScale::Signals::unsmoothed});
  return scales;
}

}  // namespace mq
