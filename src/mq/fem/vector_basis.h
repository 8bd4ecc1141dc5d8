#pragma once
/// The three bases of vector fields on a mesh: T (a vector per triangle), C (gradients and rotated
/// gradients), W (Whitney 1-forms).
///
/// A field in T has two components per triangle in the triangle's frame (`flat_triangle.h`). A
/// prolongation P turns coefficients of C or W into T; a mass is ∫ ⟨X, Y⟩ dA of coefficients, model
/// units squared. Thesis 2.3.2.3.

#include "mq/fem/edges.h"
#include "mq/fem/vertex_space.h"

namespace mq {

/// T: the area of each triangle, twice. Diagonal, 0 for triangles without area. (The thesis' (2.16),
/// ½√|g|·g, is the same in coordinates along two edges.)
SparseMatrix triangle_mass(const std::vector<FlatTriangle>& shapes);

/// C: coefficients κ then ξ, one of each per vertex, X = Σκ_i ∇φ_i + Σξ_i J∇φ_i.
/// P is 2·triangles × 2·vertices, exact, as C lies in T. Its kernel is constant κ and constant ξ, per
/// component: every system in this basis is singular until one vertex is held.
SparseMatrix gradient_prolongation(const VertexSpace& space);

/// C: Pᵀ·M_T·P = (S, K; Kᵀ, S). K_ij = ∫ ⟨∇φ_i, J∇φ_j⟩ vanishes on a closed surface; with a boundary
/// it couples neighbours along it.
SparseMatrix gradient_mass(const VertexSpace& space);

/// C: κᵀ(S·M⁻¹·S)κ + ξᵀ(S·M⁻¹·S)ξ ≈ ∫ (div X)² + (curl X)² dA, M the lumped mass `star_zero`;
/// closed surfaces only. Against `gradient_mass` its spectrum is that of S·φ = λ·M·φ without 0, each
/// value twice. Thesis 4.5.2.1.
SparseMatrix curl_and_div(const VertexSpace& space, const Vector& star_zero);

/// W: X = Σ ω_e (φ_i ∇φ_j − φ_j ∇φ_i) over edges e = ij, with ω_e = ∫_i^j ⟨X, ds⟩.
/// P is 2·triangles × edges, the value at the barycentre, and exact for fields constant per triangle.
SparseMatrix whitney_prolongation(const Edges& edges, const std::vector<FlatTriangle>& shapes);

/// How ∫ ⟨X_e, X_f⟩ dA is found.
enum class WhitneyMass {
  exact,     ///< in closed form, positive definite
  one_point  ///< PᵀM_T·P, by the value in the middle of each triangle, as the thesis has it
};

/// W: ∫ ⟨X_e, X_f⟩ dA, edges × edges. In a triangle of sides a, b, c a field is its value in the middle and a rotation
/// about it by half its curl, so that
///
///     ⟨ω, M_exact·ω⟩ − ⟨ω, M_one·ω⟩ = Σ_t (a² + b² + c²)/(144 |t|) (d₁ω)_t²:
///
/// the one-point rule is exact for fields constant in triangles, and what it loses is (a² + b² + c²)/144 times curl²,
/// of the second order. It is singular where fields do nothing but rotate (`massless_rotations`).
SparseMatrix whitney_mass(const Edges& edges, const std::vector<FlatTriangle>& shapes,
                          WhitneyMass how = WhitneyMass::exact);

/// The dimension of the null space of `WhitneyMass::one_point`: ω is ±c_t on the edges of triangle t and vanishes in
/// its middle, so that neighbours turn opposite ways; one for each component (joined through edges) whose triangles can be
/// coloured black and white such that no two of one colour share an edge. All grids cut along diagonals can; no surface
/// with an inner vertex of odd degree.
int massless_rotations(const Edges& edges, const std::vector<FlatTriangle>& shapes);

/// W: the field at a point of a triangle, in the triangle's frame; it is linear inside.
Vector2 whitney_value(const Edges& edges, const FlatTriangle& shape, int triangle,
                      const Vector3& barycentric, const Vector& omega);

}  // namespace mq
