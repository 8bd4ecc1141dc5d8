#pragma once
/// How much a field with a vector per triangle (basis T) changes from triangle to triangle.

#include <cstdint>

#include "mq/fem/flat_triangle.h"
#include "mq/linear/matrix.h"

namespace mq {

/// Where a triangle has its dual vertex.
enum class DualCentre {
  circumcentre,  ///< dual edges cross the primal ones at right angles: consistent, order 2
  barycentre,    ///< the thesis' own choice; inconsistent: 4 to 7 % off however fine the mesh
  circumcentre_as_printed  ///< the same as the first without a bound, so that the form may be indefinite
};

/// The weights 1/(cot α + cot β) of edges between triangles with area.
struct DualWeights {
  std::int64_t edges = 0;
  std::int64_t negative = 0;     ///< not Delaunay: the circumcentres lie the wrong way round
  std::int64_t on_a_circle = 0;  ///< of no length to rounding (10⁻⁹ of the edge): infinite
};
DualWeights dual_weights(const Surface& surface, const std::vector<FlatTriangle>& shapes);

/// VectorDifferences, 2·triangles × 2·triangles, with the rotation L_ij that lays triangle j beside
/// i flat, the distance l_ij of their centres, and A_ij the area of the edge's part of the dual:
///
///     ⟨X, S·X⟩ = Σ_i Σ_{j ∈ N(i)} A_ij |X_i − L_ij·X_j|² / |l_ij|²  ≈  ∫ |∇X|² dA,
///
/// each edge twice, as the sum is written. Symmetric positive semidefinite; no unit. Null space:
/// parallel fields, none where there is curvature, and any value in triangles without area. As printed between
/// circumcentres it is indefinite where weights are negative.
///
/// Between circumcentres A/|l|² is 1/(cot α + cot β), negative where an edge is not Delaunay and
/// infinite on a circle: |l| is taken as no less than a two-hundredth of the edge (the first 20
/// eigenvalues of a flat torus of 64² cells moved by 0.2 are then off by less than 0.3 %; with a
/// twentieth, by 0.9 %); as printed it is what it is, and infinite weights throw `InvalidInput`. Exact operators want a Delaunay triangulation (`intrinsic_delaunay`).
/// The mass is `triangle_mass` (vector_basis.h). Thesis 4.5.1, equation (4.14); its Table 4.2 has
/// half of the spectrum.
SparseMatrix vector_differences(const Surface& surface, const std::vector<FlatTriangle>& shapes,
                                DualCentre centre = DualCentre::circumcentre);

}  // namespace mq
