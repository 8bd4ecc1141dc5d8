#pragma once
/// Normal maps: unit vectors n stored as colours c = (n + 1) / 2.

#include "mq/image/image.h"

namespace mq {

/// n = 2c − 1, not normalised; channels beyond the third are copied. Throws `InvalidInput` when the
/// picture has fewer than three.
Image<float> normals_from_colours(const Image<float>& colours);

/// c = (n / |n| + 1) / 2; a zero vector becomes (0, 0, 1), the undisturbed normal.
Image<float> colours_from_normals(const Image<float>& normals);

/// The share of pixels whose third component is above 0.5 (normals within 60° of the z axis). Near
/// 1 in a map of tangent space, whose normals stand on the surface; well below where normals are
/// those of a closed object. Pixels are those with coverage above 0 (one channel, same size).
double share_upright(const Image<float>& normals, const Image<float>& coverage);

}  // namespace mq
