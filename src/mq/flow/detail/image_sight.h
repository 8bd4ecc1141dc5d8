#pragma once
/// What of two images is seen at the pixels between them.

#include "mq/flow/detail/field_claims.h"
#include "mq/flow/image_flow.h"

namespace mq {

/// How a picture at time t is made of two images, pixel by pixel.
struct ImageSight {
  FieldWays ways;       ///< to where both are looked up
  Image<float> target;  ///< the part of the target, 0 to 1; the rest is the source's
  Image<float> unfit;   ///< the part of the plain blend (1 − t) : t, 0 to 1, in place of both
};

/// For a flow with `fit`. Where a pixel's place lies outside one image, or is hidden there by what moves otherwise and
/// fits better (`claimed`; of fields that jump only), the other alone counts. Where both are, and where both are seen
/// but unlike, and no nearer than they lie, nothing fits. Fields that jump are carried along to time t.
ImageSight image_sight(const SignalPair& signals, const ImageFlow& flow, double t);

}  // namespace mq
