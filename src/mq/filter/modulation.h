#pragma once
/// How strongly a filter works where: a mask of one number per unknown, 0 (not at all) to 1
/// (fully), painted in a texture, at the vertices of a mesh, or sprayed on in spots. Below 0, to −1, it
/// smooths instead, so that one mask sharpens here and smooths there.

#include <cstdint>
#include <span>
#include <vector>

#include "mq/atlas/atlas.h"
#include "mq/base/progress.h"
#include "mq/fem/texels.h"
#include "mq/image/image.h"
#include "mq/mesh/mesh.h"

namespace mq {

/// The modulation β = 1 + (beta − 1)·m where the mask m is not below 0, and 1 + m where it is: 1 (no
/// change) where the mask is 0, `beta` exactly where it is 1 (thesis 5.9.1, local filtering), 0, which
/// smooths fully, where it is −1, whatever `beta`. (1 + (beta − 1)·m for both would turn gradients around
/// where m is below −1 / (beta − 1).) For `ScreenedPoisson::solve`; a new mask costs one pass
/// over the cells and a solve, the prepared solver stays.
std::vector<double> modulation(std::span<const double> mask, double beta);

/// What one picture of the mask below says at a texel (x, y) of a texture of this size.
double mask_at(const Image<float>& picture, const TextureSize& size, int x, int y, double least = 0);

/// The mask that pictures show, one for each texture of the atlas and painted in its coordinates:
/// the mean of the colour channels at each texel's centre, interpolated between the picture's
/// pixels where its size is not that of the texture; values below `least` and above 1 count as these.
/// Throws `InvalidInput` where there is not one picture for each texture, or one is empty or holds
/// a value that is not a number.
std::vector<double> mask_of_pictures(const Texels& texels, std::span<const TextureSize> textures,
                                     std::span<const Image<float>> pictures, double least = 0);

/// The mask given at the vertices of a mesh, one value each, at places near it: linear in the
/// triangle at the closest point. Clamped and refused as above.
std::vector<double> mask_of_vertices(const Mesh& mesh, std::span<const double> values,
                                     std::span<const Vector3> places, double least = 0,
                                     const Progress& progress = {});

/// A spray of paint: strength · (1 − t²)² at the distance d < radius in space, where t grows from 0 at
/// hardness · radius to 1 at the radius.
struct Spot {
  Vector3 center = Vector3::Zero();
  double radius = 0;
  double strength = 1;  ///< −1 to 1; negative takes away
  double hardness = 0;  ///< the part of the radius that gets all of the strength, from 0 to 1
};

/// What a spot adds at a place.
double paint_at(const Spot& spot, const Vector3& place);

/// Adds spots to a mask, in order, clamping to [0, 1] after each (what is below 0 is not taken lower);
/// `places` are those of the unknowns. Returns how many changes of a value that made. Throws
/// `InvalidInput` on a radius that is not positive or a number that is not finite.
std::int64_t add_spots(std::span<const Spot> spots, std::span<const Vector3> places,
                       std::vector<double>& mask);

}  // namespace mq
