#pragma once
/// Discrete exterior calculus: forms on vertices, edges and triangles.
///
/// A 0-form has a value per vertex, a 1-form ω per edge (the integral of a vector field along it,
/// ω_ij = ∫_i^j ⟨X, ds⟩), a 2-form per triangle (the integral over it). Thesis 2.3.2.4, where the
/// sign of d₀ is reversed.

#include <vector>

#include "mq/fem/edges.h"
#include "mq/linear/matrix.h"

namespace mq {

/// (d₀φ)_ij = φ_j − φ_i: edges × vertices. d₀ of a signal holds the integrals of its gradient.
SparseMatrix d0(const Edges& edges, int vertex_count);

/// (d₁ω)_t = Σ ±ω over the edges of t, + where the edge runs counter-clockwise around it: triangles
/// × edges. d₁·d₀ = 0 exactly. Rows of triangles without area are empty.
SparseMatrix d1(const Edges& edges);

/// The diagonals of the Hodge stars, which turn primal into dual forms.
struct HodgeStars {
  Vector zero;  ///< per vertex the area around it, > 0, model units squared; sums to the area
  Vector one;   ///< per edge ½(cot α + cot β), no unit; negative where the edge is not Delaunay
  Vector two;   ///< per triangle 1 / area; 0 where it has none
};

/// How the area of a triangle is shared among its vertices.
enum class VertexArea {
  barycentric,  ///< a third each
  mixed         ///< the circumcentric cell in acute triangles; in obtuse ones half to the obtuse
                ///< corner and a quarter to the others, which keeps all positive (Meyer et al. 2003)
};

HodgeStars hodge_stars(const Edges& edges, const std::vector<Triangle>& triangles,
                       const std::vector<FlatTriangle>& shapes, int vertex_count,
                       VertexArea area = VertexArea::mixed);

/// The Hodge Laplacian of 1-forms in weak form, edges × edges,
///
///     S₁ = d₁ᵀ⋆₂d₁ + ⋆₁d₀⋆₀⁻¹d₀ᵀ⋆₁ :    ⟨ω, S₁ω⟩ = ∫ (curl X)² + (div X)² dA,
///
/// symmetric positive semidefinite; on a closed surface its null space are the harmonic fields, of
/// dimension 2·genus per component (with a boundary: b − 1 + 2·genus, the fields tangent to it).
/// `star_one` may be the diagonal ⋆₁ or the mass of Whitney forms (`whitney_mass`), which is nearer
/// to the true spectrum (flat torus, 64² cells moved by 0.15: 0.33 % against 0.49 %). The
/// spectrum is that of S₁ω = λ·M·ω with M the Whitney mass; the thesis (4.5.2.2) lists half of it in
/// Table 4.2.
SparseMatrix hodge_laplacian(const Edges& edges, const HodgeStars& stars,
                             const SparseMatrix& star_one);

/// A vector as a diagonal matrix.
SparseMatrix diagonal_matrix(const Vector& diagonal);

/// ⋆₀ for each of the two components of a vector at a vertex, 2·vertices × 2·vertices: the mass for
/// `connection_laplacian` (vertex_frames.h). Vertices that no area reaches have 1.
SparseMatrix vertex_area_mass(const Vector& star_zero);

}  // namespace mq
