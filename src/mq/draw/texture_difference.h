#pragma once
/// Where two versions of a model's textures differ most, as a person sees it who looks at the surface.
///
///     TextureDifference d = texture_difference(surface, atlas, {&before}, {&after});
///     Sight sight = renderer.sight_of(d.places[0].point, d.places[0].normal, 64 * atlas.texel_spacing());

#include <cstdint>
#include <vector>

#include "mq/atlas/atlas.h"
#include "mq/base/progress.h"
#include "mq/image/image.h"
#include "mq/mesh/surface_point.h"

namespace mq {

/// A place of the surface around which the textures differ.
struct DifferencePlace {
  SurfacePoint at;
  Vector3 point = Vector3::Zero();   ///< of the texel, or small triangle, that differs most there
  Vector3 normal = Vector3::Zero();  ///< of its triangle, unit
  int texture = 0;
  double column = 0, row = 0;  ///< in texels, the centre of texel (i, j) at (i, j)
  double difference = 0;       ///< root mean square over colour channels and over the surface around
};

struct TextureDifference {
  double rms = 0;           ///< √(∫ difference² / area) over all that has texture coordinates
  std::int64_t looked = 0;  ///< at how many texels and small triangles
  std::vector<DifferencePlace> places;  ///< that which differs most first; none where nothing differs
};

/// Lengths in mean texel spacings of the atlas.
struct TextureDifferenceOptions {
  double around = 8;  ///< what `DifferencePlace::difference` is the mean over: with a weight that falls from 1 to
                      ///< 0 over one and a half times this along each axis. A single wrong texel counts for little,
                      ///< a spot that a person sees for much.
  double apart = 64;  ///< places of one side of the surface are farther from each other than this
  int most = 100;     ///< of the places
};

/// Squared differences, mean over the colour channels that both have, at each texel whose centre a triangle covers
/// and at the middle of triangles that cover none; those of a triangle share its area equally. They are summed over
/// the surface around, so that a place at a seam, or of a chart of a few texels, is seen whole; where less than half
/// of a plane would be around, the mean is as if the rest of that half were equal. Then the largest is taken, again
/// and again, from what is apart from those before.
///
/// Textures are those of the atlas, in its order and sizes, values as stored. Throws `InvalidInput` where they do not
/// fit the atlas, where a value looked at is not finite, or where a length or count is not above 0. Linear in texels;
/// equal bits for any number of threads.
TextureDifference texture_difference(const Surface& surface, const Atlas& atlas,
                                     const std::vector<const Image<float>*>& before,
                                     const std::vector<const Image<float>*>& after,
                                     const TextureDifferenceOptions& options = {},
                                     const Progress& progress = {});

}  // namespace mq
