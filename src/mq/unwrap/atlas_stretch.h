#pragma once
/// What an atlas does to a surface.

#include <vector>

#include "mq/mesh/surface.h"

namespace mq {

/// The distortion of one triangle whose Jacobian from the surface, scaled to the area of the atlas,
/// to the texture has singular values σ₁ ≥ σ₂ (thesis 5.8.4).
struct TriangleStretch {
  double area = 0;       ///< on the surface
  double ratio = 1;      ///< σ₁ / σ₂
  double authalic = 0;   ///< ½ log²(σ₁ σ₂)
  double conformal = 0;  ///< ½ log²(σ₁ / σ₂)
};

struct AtlasStretch {
  int flipped = 0;        ///< triangles flipped in the texture; collapsed ones are not counted
  double occupancy = 0;   ///< area of the charts / area of the texture
  double l2_stretch = 1;  ///< of the whole [sander2001texture], at least 1
  std::vector<TriangleStretch> triangles;  ///< of those with area on the surface
};

/// The stretch of a surface in a texture of this size; `corner_uvs` of every triangle, indices into
/// `uvs`.
AtlasStretch atlas_stretch(const Surface& surface, const std::vector<Vector2>& uvs,
                           const std::vector<Triangle>& corner_uvs, int width, int height);

}  // namespace mq
