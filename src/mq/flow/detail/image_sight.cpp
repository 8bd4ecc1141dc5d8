#include "mq/flow/detail/image_sight.h"

#include <algorithm>

#include "mq/base/parallel.h"
#include "mq/flow/detail/field_fusion.h"
#include "mq/flow/forward_warp.h"

namespace mq {
namespace {

/// The mean over 3 × 3 pixels, so that borders are not jagged.
Image<float> softened(const Image<float>& values) {
  const int width = values.width(), height = values.height();
  Image<float> result(width, height, 1);
  parallel_for(
      height,
      [&](std::int64_t row) {
        for (int x = 0; x < width; ++x) {
          float sum = 0;
          for (int j = -1; j <= 1; ++j)
            for (int i = -1; i <= 1; ++i)
              sum += values(std::clamp(x + i, 0, width - 1), std::clamp(int(row) + j, 0, height - 1));
          result(x, int(row)) = sum / 9;
        }
      },
      row_block);
  return result;
}

/// Which of the two images has a pixel to itself: its part of the target at time t.
float part_of_target(bool in_source, bool in_target, double t) {
  return in_source == in_target ? float(t) : in_target ? 1.0F : 0.0F;
}

}  // namespace

ImageSight image_sight(const SignalPair& signals, const ImageFlow& flow, double t) {
  const bool torn = flow.fit->torn;
  const Image<float> X = torn && t != 0.5 ? forward_warp(flow.field, t - 0.5, flow.fit->misfit).field : flow.field;
  const int width = X.width(), height = X.height();
  ImageSight sight{ways_along(X, t, flow.path), Image<float>(width, height, 1), Image<float>(width, height, 1)};
  const Image<float> still(width, height, 2);
  const Image<float> costs = misfit(signals, X, sight.ways, {});
  const Image<float> before = misfit(signals, still, ways_along(still, t, FlowPath::straight), {});
  const FieldClaims claims = torn ? claimed(X, t, costs) : FieldClaims();
  parallel_for(
      height,
      [&](std::int64_t row) {
        const int y = int(row);
        for (int x = 0; x < width; ++x) {
          const bool in_source = !is_hidden(X, sight.ways.back, claims.source, x, y);
          const bool in_target = !is_hidden(X, sight.ways.forth, claims.target, x, y);
          sight.target(x, y) = part_of_target(in_source, in_target, t);
          const bool apart = costs(x, y) > unlike_misfit && costs(x, y) >= before(x, y);
          sight.unfit(x, y) = in_source == in_target && (!in_source || apart) ? 1.0F : 0.0F;
        }
      },
      row_block);
  if (torn) sight.target = softened(sight.target);
  sight.unfit = softened(sight.unfit);
  return sight;
}

}  // namespace mq
