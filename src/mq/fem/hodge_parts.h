#pragma once
/// A vector field taken apart: what flows out of places, what goes round them, and what is left.

#include "mq/base/progress.h"
#include "mq/fem/edges.h"
#include "mq/fem/tangent_fields.h"

namespace mq {

/// The Helmholtz–Hodge decomposition X = ∇u + J∇v + H of a field with a vector per triangle, J the quarter turn
/// counter-clockwise seen from outside. The three parts are orthogonal in ∫ ⟨X, Y⟩ dA and sum to X, both to rounding.
struct HodgeParts {
  TangentField gradient;  ///< ∇u: without curl
  TangentField curl;      ///< J∇v: without divergence, along boundaries
  TangentField harmonic;  ///< H: without either, along boundaries; 0 on a sphere and on a disc

  Vector potential;  ///< u per vertex, of mean 0 (of its values) on each component; units of X times length
  Vector stream;     ///< v at the middle of each of `edges`, linear in triangles; likewise, but 0 along boundaries
  Edges edges;
};

/// Finds the parts: u is continuous and linear in triangles, v continuous in the middles of edges alone (Crouzeix and
/// Raviart). With this pair the harmonic fields are as many as the topology asks for, 2·genus, and b − 1 more with b
/// boundaries, and are those of `harmonic_fields`. Polthier and Preuss, Identifying vector field singularities using a
/// discrete Hodge decomposition, 2003; Wardetzky, 2006. Solves
///
///     ∫ ⟨∇u, ∇φ_i⟩ = ∫ ⟨X, ∇φ_i⟩,    ∫ ⟨∇v, ∇ψ_e⟩ = ∫ ⟨X, J∇ψ_e⟩ dA
///
/// by one factorisation each, of a row per vertex and a row per edge. Of X the part tangent to each triangle counts, and
/// in triangles without area all is 0. Throws `InvalidInput` where the count does not fit or a vector is not finite.
HodgeParts hodge_parts(const Surface& surface, const TangentField& field, const Progress& progress = {});

/// v at the vertices, the mean over the edges at each by the area of the triangles there: to look at.
Vector stream_at_vertices(const Surface& surface, const HodgeParts& parts);

}  // namespace mq
