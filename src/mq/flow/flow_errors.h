#pragma once
/// A field beside the true one.

#include <cstdint>

#include "mq/image/image.h"

namespace mq {

/// Means over the pixels at which the true field û is known, as the benchmarks have them
/// [baker2011database].
struct FlowErrors {
  std::int64_t pixels = 0;  ///< compared
  double endpoint = 0;      ///< mean |u − û|, pixels
  double endpoint_root_mean_square = 0;
  double angular = 0;   ///< mean angle between (u, 1) and (û, 1), degrees
  double outliers = 0;  ///< share with |u − û| above 3 pixels and above 5 % of |û| (KITTI)
};

/// Throws `InvalidInput` where sizes differ, a field has other than two channels or the true one is
/// known (finite) nowhere. Pixels at which only u is not finite count as u = 0.
FlowErrors flow_errors(const Image<float>& field, const Image<float>& truth);

/// |u − û| per pixel, NaN where û is not known.
Image<float> endpoint_errors(const Image<float>& field, const Image<float>& truth);

}  // namespace mq
