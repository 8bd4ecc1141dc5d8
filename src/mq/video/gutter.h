#pragma once
/// What a texture video shows outside of charts, where nobody looks.

#include "mq/fem/texels.h"
#include "mq/image/image.h"

namespace mq {

/// How far from a chart bilinear lookup in colours stored at half the resolution reaches, in
/// texels.
inline constexpr double seen_margin = 2.5;

/// Gives texels of `picture` that are farther than `margin` texels from all that are `inside` what
/// `before`, the picture of the frame before, shows there: what does not change costs a video
/// nothing. All three of one size, both pictures of as many channels; else throws `InvalidInput`.
/// Linear in the texels.
void hold_gutter(const Image<char>& inside, double margin, const Image<float>& before,
                 Image<float>& picture);

/// Gives texels of one picture that are outside of charts the values of the nearest ones inside,
/// which it returns: 1 where there is a texel.
Image<char> spread_from_charts(const Texels& texels, Image<float>& picture);

}  // namespace mq
