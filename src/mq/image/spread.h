#pragma once
/// Values carried from pixels that have one to all others.

#include "mq/image/image.h"

namespace mq {

/// For every pixel the number (row · width + column) of the nearest one whose `known` is above 0
/// (of equally near ones the first met going down, then right), -1 where there is none; distances
/// are between centres and exact (Felzenszwalb and Huttenlocher, Distance transforms of sampled
/// functions, 2012). Linear in the pixels.
Image<int> nearest_known(const Image<char>& known);

/// Gives every pixel that is not known, and not farther than `distance` pixels from one that is,
/// the values of the nearest known one.
void spread(const Image<char>& known, double distance, Image<float>& picture);

/// The same where only some known pixels, the `source`, give their values away: what is not known
/// gets those of the nearest of them, or where there is none, of the nearest known one.
void spread(const Image<char>& source, const Image<char>& known, double distance,
            Image<float>& picture);

}  // namespace mq
