#pragma once
/// The metric in which a vector field's lines lie close and all else is far (thesis 5.9.4).

#include <span>
#include <vector>

#include "mq/atlas/atlas.h"
#include "mq/fem/flat_triangle.h"

namespace mq {

/// Per triangle the metric
///
///     g_Y(A, B) = ⟨A, B⟩ + κ² ⟨A, JY⟩ ⟨B, JY⟩,      √|g_Y| = √(1 + κ²|Y|²) times that of the
///     surface,
///
/// which stretches distances across Y by √(1 + κ²|Y|²) and leaves those along it. Heat that spreads
/// over ℓ along Y in some time spreads over ℓ/√(1 + κ²|Y|²) across. Y is a vector in space per
/// triangle, of which the part tangent to it counts; |Y| has no unit, 1 for the full effect.
/// On texels or triangles that do not lie along the field heat spreads about one of them across
/// it besides, however large κ.
/// Throws `InvalidInput` on vectors that are not finite and on a count that does not fit.
///
/// For a texel space (`TexelSpaceOptions::metrics`); triangles without a chart have none.
std::vector<TexelMetric> texel_metrics_across(const Surface& surface, const Atlas& atlas,
                                              std::span<const Vector3> field, double kappa);

/// Per triangle the metric of the plane that its texture lies in, to compare with (thesis, Figure 5.6): all texels are squares of
/// one size, such that the area is that of the surface. Triangles without a chart have none.
std::vector<TexelMetric> texel_metrics_of_plane(const Atlas& atlas);

/// For a vertex space.
std::vector<FlatTriangle> shapes_across(const Surface& surface, std::span<const Vector3> field,
                                        double kappa);

/// Per triangle the metric of the surface with its normal beside it, p ↦ (p, length·N) in six
/// dimensions,
///
///     g(A, B) = ⟨A, B⟩ + length² ⟨dN(A), dN(B)⟩,
///
/// which stretches distances by √(1 + length²κ²) along a direction of principal curvature κ: what
/// spreads goes along creases, and across them hardly. N are unit normals at the vertices, linear
/// in each triangle (0: none is known there, and counts as no change). `length` in model units, 0:
/// the metric of the surface. As in Kazhdan's Shape Gradient Domain, whose ε is length².
/// Throws `InvalidInput` on normals that are not finite and on a count or a length that does not
/// fit.
std::vector<FlatTriangle> shapes_across_creases(const Surface& surface,
                                                std::span<const Vector3> normals, double length);

}  // namespace mq
