#pragma once
/// Where on the surface each texel with an unknown lies.

#include <vector>

#include "mq/atlas/coverage.h"
#include "mq/fem/texels.h"
#include "mq/mesh/surface_point.h"

namespace mq {

/// A `SurfacePoint` in 12 bytes; weights below 0 are outside the triangle.
struct TexelPlace {
  int triangle = -1;  ///< −1: no triangle is near
  float second = 0, third = 0;

  SurfacePoint point() const {
    return {triangle, Vector3(1 - double(second) - double(third), second, third)};
  }
};

/// Per texel of a space on the atlas the triangle that covers its centre (of several one of the texel's
/// chart), and where in it. Of texels outside all charts: the nearest triangle whose lookups read it, its
/// map continued; where that leads farther than twice the triangle's size, its nearest point. `coverage`
/// is that of the atlas (`texel_coverage`).
std::vector<TexelPlace> texel_places(const Surface& surface, const Atlas& atlas,
                                     const Texels& texels,
                                     const std::vector<Coverage>& coverage);

}  // namespace mq
