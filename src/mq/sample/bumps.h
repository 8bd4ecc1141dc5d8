#pragma once
/// Bumps on surfaces, as normals: what normal maps are made of.

#include "mq/sample/sample.h"

namespace mq {

struct Bumps {
  double length = 0.1;  ///< of a wave, model units
  double height = 0.4;  ///< how far a normal is moved at most before it is of unit length again, along each axis
};

/// The unit normal of bumps at a place of a surface whose normal there is n: (n + height · slope) normalised, with slope
/// a smooth function of the place alone, less its part along n.
Vector3 bumpy(const Vector3& n, const Vector3& place, const Bumps& bumps = {});

/// A normal map in the model's axes as colours (n + 1) / 2: bumps on the normals of vertices (`vertex_normals`),
/// interpolated over triangles. The two sides of a seam between triangles that share its vertices show the same.
/// Texels farther than `margin` from all charts show (0, 0, 1). Equal options give equal bits.
Image<float> paint_normals(const Surface& surface, const Atlas& atlas, const Bumps& bumps = {}, double margin = 3,
                           int texture = 0, const Progress& progress = {});
Image<float> paint_normals(const Sample& sample, const Progress& progress = {});

}  // namespace mq
