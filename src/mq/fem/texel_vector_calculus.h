#pragma once
/// Divergence, curl and the Hodge Laplacian of fields with a vector per texel.

#include "mq/fem/texel_vector_space.h"

namespace mq {

/// ∫ ⟨X, ∇φ_t⟩ dA per texel: the weak form of −div X, with the flux through boundaries. Sums to 0. By the rule that is
/// exact for products of two bilinear functions: of a linear field on a flat surface exact but for texels next to seams,
/// where it is off by about a hundredth of ∫ |∇φ_t|. Of ∇ψ, where it is in the space, it is S·ψ.
Vector divergence_moments(const TexelVectorSpace& vectors, const Vector& z);

/// ∫ ⟨X, J∇φ_t⟩ dA: the weak form of −curl X, J the quarter turn counter-clockwise seen from outside. Sums to 0.
Vector curl_moments(const TexelVectorSpace& vectors, const Vector& z);

/// ⟨z, H·z⟩ ≈ ∫ (div X)² + (curl X)² dA: with the complex gradients w_i of φ_i in the plane of each triangle
///
///     H_ij = Σ ∫ conj(r_i) r_j w_i conj(w_j) dA,
///
/// Hermitian and semidefinite piece by piece. It is `TexelVectorSpace::system(0, 1)` but for the products w_i × w_j, which
/// cancel inside flat parts and leave the curvature (Bochner) and what crosses boundaries. Null space: harmonic fields,
/// nearly, as X may step where the surface is curved. Fields are free at boundaries. Costs a look at every point of the
/// rule on one thread.
BlockMatrix<double> hodge_laplacian(const TexelVectorSpace& vectors);

}  // namespace mq
