#pragma once
/// The smoothest vector field that goes as it is told in a few places: strokes on a surface become a field all over it.

#include <limits>
#include <span>

#include "mq/base/progress.h"
#include "mq/fem/tangent_fields.h"
#include "mq/fem/texel_vector_space.h"
#include "mq/linear/solver.h"
#include "mq/mesh/surface_point.h"

namespace mq {

/// What the field should be at a place.
struct WishedVector {
  SurfacePoint at;
  Vector3 vector;     ///< in space; its part tangent to the triangle counts
  double weight = 1;  ///< against other wishes there
};

struct SmoothestFieldOptions {
  double hold = 100;  ///< of a wish, beside ∫ |∇X|² (both without unit): how little the field bends away from it
  /// How far from wishes vectors fade, model units; infinite: they hardly do.
  double reach = std::numeric_limits<double>::infinity();
  double tolerance = 1e-5;  ///< relative residual at which multigrid stops
};

/// The X with the least
///
///     ∫ |∇X|² dA + hold·Σ_w Σ_i φ_i(p_w)·weight_w·|z_i − r_i·d_w|² + reach⁻² ∫ |X|² dA,
///
/// z_i the unknowns around the place p_w and r_i·d_w the wish carried to each. ∇ is the connection of the surface (Knöppel
/// et al. [knoppel2013globally]), so X turns as little as curvature allows, and vanishes where it must (on a sphere twice
/// at least). A reach of 10 √area is used where it is infinite, so that pieces of the surface without a wish have X = 0.
///
/// A complex number per vertex, on Delaunay triangles of the surface; one factorisation. A vector per triangle. Throws
/// `InvalidInput` without wishes, and where one is not finite or in a triangle without area.
TangentField smoothest_field(const Surface& surface, std::span<const WishedVector> wishes,
                             const SmoothestFieldOptions& options = {}, const Progress& progress = {});

/// Of a texture.
struct SmoothestTexels {
  Vector field;  ///< two components per texel, see `TexelVectorSpace`
  SolveReport report;
};

/// The same with a vector per texel, by multigrid: details of strokes are as fine as texels, however large the triangles.
/// Wishes in triangles without a chart do not count.
SmoothestTexels smoothest_field(const TexelVectorSpace& vectors, std::span<const WishedVector> wishes,
                                const SmoothestFieldOptions& options = {}, const Progress& progress = {});

}  // namespace mq
