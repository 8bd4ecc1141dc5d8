#pragma once
/// Photographs as they are looked at: reduced, as brightness, and with how much detail they show.

#include "mq/image/image.h"

namespace mq {

/// Means over about `factor` pixels; the picture itself where that is 1 or less.
Image<float> reduced(const Image<float>& image, double factor);

/// Display brightness, at no more than about a pixel per texel and so many pixels.
Image<float> picture_to_align(const Image<float>& light, double pixels_per_texel, double most_pixels);

/// |∇|² of brightness, per texel, of a picture with `step` pixels per texel.
Image<float> squared_detail(const Image<float>& grey, double step);

/// Channels of `picture_to_look_at`: light, `squared_detail`, alpha.
inline constexpr int channel_of_detail = 3, channel_of_alpha = 4;

/// What is looked at to choose: means over about two texels.
Image<float> picture_to_look_at(const Image<float>& light, double pixels_per_texel);

}  // namespace mq
