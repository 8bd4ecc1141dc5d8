#pragma once
/// How far a template has drifted, where the true correspondence is known.

#include <vector>

#include "mq/mesh/mesh.h"

namespace mq {

/// A frame as it says where its material is: triangle for triangle the same surface in space, and in
/// coordinates that move with the material (places at rest, or texture coordinates that do not
/// change).
struct MaterialFrame {
  Mesh space;
  Mesh material;  ///< the same number of triangles
};

/// A frame whose texture coordinates are its material. Triangles without have none.
MaterialFrame material_from_uvs(const Mesh& mesh);

/// Distances |x_v − y_v| of vertices at x_v, y_v the place in the frame whose material is the
/// nearest to that of the vertex; −1 where the nearest is farther than `tolerance` in material
/// coordinates, so that the truth is not known. Throws `InvalidInput` where sizes do not agree.
std::vector<double> drift(const std::vector<Vector3>& positions,
                          const std::vector<Vector3>& material, const MaterialFrame& frame,
                          double tolerance);

/// Of those that are known.
struct DriftSummary {
  int known = 0;
  double mean = 0, p95 = 0, max = 0;  ///< model units
};
DriftSummary summary(const std::vector<double>& drifts);

}  // namespace mq
