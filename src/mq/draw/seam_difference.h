#pragma once
/// How far a texture jumps across the seams of its atlas: the same point of the surface looked up
/// from both sides.

#include <functional>
#include <span>
#include <vector>

#include "mq/atlas/atlas.h"
#include "mq/image/image.h"
#include "mq/mesh/surface_point.h"

namespace mq {

/// One point of a seam.
struct SeamPlace {
  HalfEdge edge = -1;   ///< -1: there is no seam
  double fraction = 0;  ///< of the way along the half-edge
  Vector3 point = Vector3::Zero();
  Vector3 normal = Vector3::Zero();  ///< mean of the two triangles', unit
  double difference = 0;             ///< root mean square over the colour channels
  double weight = 0;                 ///< ∫ difference² along the whole edge, model units
  double shown = 0;  ///< how much of it a person sees: the same with differences beyond `clear` as if they were
                     ///< that, less beside charts of fewer than `enough_texels`, in proportion, and less the more the
                     ///< surface bends there, so that a person sees one side at a time

  static constexpr double clear = 0.15, enough_texels = 512;
  std::vector<float> here, there;    ///< values on the half-edge's side and on its twin's
};

struct SeamDifference {
  double rms = 0;             ///< √(∫ difference² / length) over all seams
  double length = 0;          ///< of all seams, model units
  double difference_p99 = 0;  ///< 99 of 100 seam places (by number) differ by less
  std::int64_t places =
      0;            ///< looked at: about two per texel along each seam, at most 4096 an edge
  SeamPlace worst;  ///< where the difference is largest; of equals the first
  std::vector<SeamPlace> edges;  ///< the edges of which most is `shown`, such first, at most 1000; each
                                 ///< at the centre of its weight
};

/// Makes of a value looked up at a point of the surface the one that is compared; called from any thread.
using SeenValue = std::function<void(const SurfacePoint& point, std::span<float> value)>;

/// Textures are those of the atlas, in its order and sizes; values are bilinear, wrapped as the
/// atlas says, and taken through `seen` where there is one. Where two textures differ in channels those both have are compared. Throws
/// `InvalidInput` when textures do not fit the atlas. Equal bits for any number of threads.
SeamDifference seam_difference(const Surface& surface, const Atlas& atlas,
                               const std::vector<const Image<float>*>& textures,
                               const SeenValue& seen = {});

}  // namespace mq
