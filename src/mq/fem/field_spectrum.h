#pragma once
/// The vector fields that change least on a surface: eigenfields of a smoothness operator.

#include <cmath>
#include <cstdint>
#include <vector>

#include "mq/base/progress.h"
#include "mq/fem/tangent_fields.h"
#include "mq/fem/vector_basis.h"
#include "mq/fem/vector_differences.h"

namespace mq {

/// In what fields are expanded, and what counts as change.
enum class FieldBasis {
  triangle,  ///< a vector per triangle; ∫ |∇X|² dA (`vector_differences`)
  gradient,  ///< gradients and turned gradients; ∫ (div X)² + (curl X)² dA (`curl_and_div`)
  whitney,   ///< a number per edge; the same (`hodge_laplacian` with the mass of Whitney forms)
  vertex     ///< a complex number per vertex; ∫ |∇X|² dA (`connection_laplacian`)
};

struct FieldSpectrumOptions {
  FieldBasis basis = FieldBasis::whitney;
  int count = 20;
  DualCentre centre = DualCentre::circumcentre;  ///< of the triangle basis
  WhitneyMass mass = WhitneyMass::exact;         ///< of the whitney basis
};

/// Eigenvalues and their fields.
struct FieldSpectrum {
  Vector values;                     ///< λ, ascending, 1 / (model units)²
  std::vector<TangentField> fields;  ///< of each, a vector per triangle, ∫ |X|² dA = 1
  std::int64_t unknowns = 0;         ///< of the basis: no more eigenvalues than that
  std::int64_t flips = 0;            ///< of edges, where operators want Delaunay triangles
  std::int64_t negative_weights = 0; ///< of edges, with `DualCentre::circumcentre_as_printed`
  std::int64_t massless = 0;         ///< fields left out, whose λ is infinite, with `WhitneyMass::one_point`
};

/// Whether an eigenvalue of a surface of this area is 0: λ·area is 1 or more for the first that is not,
/// and rounding leaves 10⁻⁹ of it.
inline bool is_zero_eigenvalue(double value, double area) { return std::abs(value * area) < 1e-6; }

/// The `count` smallest λ of S·X = λ·M·X, thesis (4.24), with S as above and M the mass of the basis,
/// and their fields. Multiple eigenvalues come with as many fields, orthonormal, but in no
/// particular order or direction among themselves. These are the operators as they are: the
/// thesis' Table 4.2 lists half of the eigenvalues, on the surface scaled to area 1.
///
/// On a closed surface of genus g the whitney basis has 2g harmonic fields per component, λ = 0; the
/// gradient basis has all the others, each λ that of a function and twice. Where the surface is
/// curved, ∫ |∇X|² = ∫ (div X)² + (curl X)² − K |X|² (Bochner), K the Gaussian curvature: so the
/// triangle and vertex bases see other eigenvalues, l(l+1) − 1 in place of l(l+1) on the unit sphere.
/// At a boundary whitney and gradient fields are tangent to it (turned gradients are those of
/// functions that are 0 there); triangle and vertex fields are free.
///
/// Triangle (with circumcentres) and vertex work on `intrinsic_delaunay`; their fields are brought
/// back by the directions at vertices, which of the triangle basis takes means around these (not
/// where no edge was flipped). With barycentres it is the mesh as it is, as in the thesis, and so it is with
/// circumcentres as printed: negative weights make for λ that are no smoothness, down to large negative ones. With the
/// one-point mass every λ of the whitney basis is as large or larger, as the same fields have less mass.
/// Triangles without area, and what only they use, take no part.
///
/// Costs a factorisation of S + σM and 3·count solves (`smallest_eigenpairs`), and 24 bytes per
/// triangle and field. Throws `InvalidInput` where fewer fields than `count` are in the basis, and
/// what `smallest_eigenpairs` throws.
FieldSpectrum field_spectrum(const Surface& surface, const FieldSpectrumOptions& options,
                             const Progress& progress = {});

}  // namespace mq
