#pragma once
/// Images moved along vector fields. Pixel (i, j) is at (i, j); a field has two channels, to the
/// right and down, in pixels per unit of time.

#include <array>
#include <cstdint>

#include "mq/base/progress.h"
#include "mq/image/image.h"

namespace mq {

/// Rows of an image that are one piece of work.
inline constexpr std::int64_t row_block = 8;

/// What p + tX means where X changes from place to place.
enum class FlowPath {
  straight,   ///< p + t·X(p), as equation (4.10) of the thesis has it
  integrated  ///< Φ_X(p, t), the integral curve through p, as 4.4.3 has it for meshes
};

/// Φ_X(p, t) − p for every pixel p: two channels, pixels. X is bilinear between pixels and beyond
/// the border as at the nearest pixel of it, so that Φ_X(·, −t) is the inverse of Φ_X(·, t) up to
/// the error of the steps: classical Runge–Kutta, as many equal steps for all pixels as keep
/// z = step · max |∇X| ≤ 1 (4 at most), which leaves an error of about step · |X| · z⁴/120.
///
/// Throws `InvalidInput` where X has other than two channels or no pixels.
Image<float> displacement(const Image<float>& field, double time,
                          FlowPath path = FlowPath::integrated);

/// What becomes of values that a cubic goes through outside the range of the pixels it is made of.
enum class Overshoot {
  kept,  ///< the result changes smoothly with the place
  cut    ///< no value leaves the range of the 4 × 4 pixels around
};

/// φ(p + d(p)) for every pixel p of the displacement d, which may have another size than φ: the
/// cubic convolution of Keys [keys1981cubic] with a = −½, of third order. Beyond its border φ is as
/// at the nearest pixel of it. Places that are not finite are an error of the program.
Image<float> displaced(const Image<float>& signal, const Image<float>& displacement,
                       Overshoot overshoot = Overshoot::cut);

/// Advect(φ, X, t) of the thesis: φ(Φ_X(p, t)).
Image<float> advected(const Image<float>& signal, const Image<float>& field, double time,
                      FlowPath path = FlowPath::integrated);

/// A field at another size, bilinear between pixels; both cover the same area, and vectors keep
/// their length in it: they are scaled as the sides are.
Image<float> resized_field(const Image<float>& field, int width, int height);

/// Whether p + d(p) lies between the centres of the outermost pixels of an image of this size.
inline bool lands_inside(const Image<float>& d, int x, int y) {
  const float column = float(x) + d(x, y, 0), row = float(y) + d(x, y, 1);
  return column >= 0 && row >= 0 && column <= float(d.width() - 1) && row <= float(d.height() - 1);
}

}  // namespace mq
