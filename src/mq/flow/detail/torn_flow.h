#pragma once
/// A field for images in which small things move a little beside others that move far.

#include "mq/base/progress.h"
#include "mq/flow/image_flow.h"

namespace mq {

/// A straight field that may jump from pixel to pixel, at the size of the images. At the first scale, that of the grid
/// of `searched_motions`, each pixel has the best of what these say, of what differential steps find from 0, and of
/// `smooth`, a straight field from elsewhere (`fused`). At each further one borders between motions move by a few
/// pixels, and X is corrected as `coarse_to_fine` does, with smoothness that ends where X jumps; pixels that are
/// hidden in one image or unlike in both have no voice.
///
/// Swapped signals give −X of −`smooth`, bit for bit. Takes about as long as the way from large scales. `smooth` where
/// the images are too small to search.
Image<float> torn_field(const SignalPair& signals, const Image<float>& smooth, const ImageFlowOptions& options,
                        const Progress& progress);

/// The field as a straight one, X ≈ Φ_X(p, ½) − Φ_X(p, −½).
Image<float> straightened(const Image<float>& field, FlowPath path);

}  // namespace mq
