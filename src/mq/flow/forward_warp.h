#pragma once
/// Fields that say where the pixels of a first image go, as they are found on the way.

#include "mq/image/image.h"

namespace mq {

/// What is at the pixels at some time on the way.
struct ForwardWarpedField {
  Image<float> field;  ///< two channels: u(p) of what is there, q = p + t·u(p)
  Image<char> seen;  ///< 0 where nothing of the first image comes to: there `field` is from around
};

/// The pixels p of a first image, which go straight to p + u(p) from time 0 to 1, at time t: the
/// triangles between them are drawn where they are by then, u linear in each, so that fields that
/// change smoothly are exact to their second differences. Where several meet, that of the least
/// `cost` (one channel, as large as u) is seen, as [baker2011database], section 3.3.2, decides it;
/// flipped triangles are not, and those torn apart, by more than two pixels between neighbours,
/// only where nothing else is and as not seen. Pixels that none comes to have u of the nearest that
/// has one.
///
/// Linear in the pixels, on one thread: 60 ns each. Throws `InvalidInput` where sizes differ or u
/// has other than two channels.
ForwardWarpedField forward_warp(const Image<float>& displacement, double time,
                                const Image<float>& cost);

/// A field with that of the nearest pixel where it is not known (NaN). Throws `InvalidInput` where
/// none is.
Image<float> completed(Image<float> field);

}  // namespace mq
