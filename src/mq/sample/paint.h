#pragma once
/// Pictures for models: a colour at every texel from where it lies on the surface.

#include <cstdint>
#include <functional>

#include "mq/atlas/atlas.h"
#include "mq/base/progress.h"
#include "mq/image/image.h"

namespace mq {

/// Red, green and blue, 0 to 1, at a place in space; a chart may see it its own way. Continuous in
/// space, so that a seam has one true value, seen from both sides. Called from any thread.
using ColorField = std::function<Vector3(const Vector3& position, int chart)>;

/// The same at a point of a triangle, by the weights of its corners (below 0 in the margin).
using SurfaceField = std::function<Vector3(int triangle, const Vector3& weights)>;

struct PaintOptions {
  double margin = 3;                     ///< texels painted around each chart
  Vector3 background{0.20, 0.20, 0.22};  ///< of texels farther away
};

/// The picture of one texture: texel (i, j) shows field(π(i, j)), where π is the affine map of the
/// triangle that contains its centre or, up to `margin` outside all charts, of the nearest triangle
/// at a chart's boundary (so bilinear interpolation at a seam gives the field's value to the second
/// order in the texel, from both sides). Values are clamped to [0, 1].
Image<float> paint(const Surface& surface, const Atlas& atlas, const ColorField& field,
                   const PaintOptions& options = {}, int texture = 0,
                   const Progress& progress = {});
Image<float> paint(const Surface& surface, const Atlas& atlas, const SurfaceField& field,
                   const PaintOptions& options = {}, int texture = 0,
                   const Progress& progress = {});

/// Several octaves of noise over a palette, with bands, dots and sharp-edged islands: what a
/// photograph of something colourful has. `scale` is the size of its largest features.
ColorField colorful(double scale, std::uint64_t seed = 1);

struct MisalignOptions {
  double exposure = 0.25;       ///< charts are brighter or darker by up to this factor
  double white_balance = 0.06;  ///< and each channel by up to this
  double shift = 0;             ///< and show a place up to this far away, model units
  std::uint64_t seed = 1;
};

/// The field as a scanner's badly joined photographs show it, a different one on every chart.
ColorField misaligned(ColorField field, const MisalignOptions& options);

}  // namespace mq
