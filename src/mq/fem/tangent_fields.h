#pragma once
/// Vector fields that a surface has by itself or gets from a signal: a vector in space per
/// triangle, tangent to it, 0 where the triangle has no area.

#include <vector>

#include "mq/base/progress.h"
#include "mq/linear/matrix.h"
#include "mq/mesh/surface.h"

namespace mq {

using TangentField = std::vector<Vector3>;

/// v, orthogonal to the unit vector `from`, turned by the least rotation that takes this to the unit vector `to`. Between
/// opposite ones, for which there is none, v itself.
inline Vector3 carried(const Vector3& v, const Vector3& from, const Vector3& to) {
  const double c = 1 + from.dot(to);
  return c > 1e-9 ? Vector3(v - (to.dot(v) / c) * (from + to)) : v;
}

/// Which principal direction: of the larger or of the smaller curvature (with sign; outward bumps
/// count positive).
enum class Principal { max, min };

/// The direction times |κ₁ − κ₂|, in 1/length. It has no sign of its own: neighbours may point
/// opposite ways, which `texel_metrics_across` does not notice.
TangentField curvature_field(const Surface& surface, Principal which, int rings = 2,
                             const Progress& progress = {});

/// ∇ψ of values at the vertices of the surface.
TangentField gradient_field(const Surface& surface, const Vector& psi);

/// The vectors at the vertices, averaged over each triangle and made tangent.
TangentField field_from_vertices(const Surface& surface, const std::vector<Vector3>& vertices);

/// All fields without curl and divergence, tangent to boundaries: a basis, orthonormal in
/// ∫ ⟨X, Y⟩ dA. Their number is 2·genus per closed component, 2·genus + b − 1 with b boundaries: it
/// is counted, not found among eigenvalues. One for each edge that is neither in a spanning tree of
/// the vertices nor crossed by one of the triangles that avoids it (Eppstein, Dynamic generators of
/// topologically embedded graphs, 2003); each begins as 1 along a loop of triangles, and what is
/// the gradient of something is taken off by one factorisation for all of them. Exactly of constant
/// curl 0; div is 0 in the weak sense, to the accuracy of the factorisation.
///
/// A triangle that degenerates to a line cuts the surface open.
std::vector<TangentField> harmonic_fields(const Surface& surface, const Progress& progress = {});

/// The given quantile of |Y| by area. Where Y vanishes on so much of the surface that this is 0, it is the quantile on
/// the rest; 0 where it vanishes everywhere.
double strength_of(const Surface& surface, const TangentField& field, double quantile = 0.9);

/// Y / q with q its `strength_of`, and vectors longer than 1 cut to 1. A field that vanishes everywhere stays.
TangentField scaled_to_one(const Surface& surface, TangentField field, double quantile = 0.9);

/// Y / |Y|, and 0 where |Y| is less than 10⁻⁶ of its mean.
TangentField normalised(const Surface& surface, TangentField field);

}  // namespace mq
