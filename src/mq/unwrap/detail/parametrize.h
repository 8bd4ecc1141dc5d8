#pragma once
/// One chart on its way to the plane: connected triangles with vertices of their own, and the maps
/// that lay them flat.
///
/// For a triangle with rest shape P (isometric in the plane) and gradients Gᵢ of its hat functions
/// the map x has the Jacobian J = Σ xᵢ Gᵢᵀ with singular values σ₁ ≥ σ₂; J maps the surface to the
/// plane. All lengths are in the units of the positions given.

#include <array>
#include <vector>

#include "mq/base/progress.h"
#include "mq/linear/direct.h"
#include "mq/mesh/surface.h"

namespace mq {

using Points = std::vector<Vector2>;

/// Some triangles of a surface, joined where they are glued.
struct Sheet {
  std::vector<int> sources;         ///< of each triangle, its triangle on the surface
  std::vector<Triangle> triangles;  ///< of vertices of the sheet
  std::vector<double> areas;        ///< of the rest shapes
  std::vector<Eigen::Matrix<double, 3, 2>> gradients;  ///< per triangle, a row per corner
  std::vector<std::vector<int>> loops;  ///< vertices along each boundary, the chart on the left
  std::vector<std::vector<HalfEdge>> edges;  ///< of the surface, from each of them to the next
  int vertex_count = 0;
  double area = 0;

  /// Whether it is one, with V − E + T = 1 and a single loop.
  bool is_disc() const;
};

/// Of every triangle the lengths of its edges, from each corner to the next.
using EdgeLengths = std::vector<std::array<double, 3>>;

/// The sheet of the surface's `triangles`; half-edges h with `merged[h]` are joined to their twins,
/// which must be among the triangles. A triangle thinner than 1 : 10⁴ gets a rest shape of that
/// height, so that every one has an area to lose. With `lengths` of all triangles of the surface
/// the rest shapes are those, not the surface's own. Throws `InvalidInput` when a boundary meets
/// itself in a vertex (never where every glued fan is whole).
Sheet make_sheet(const Surface& surface, const std::vector<int>& triangles,
                 const std::vector<char>& merged, const EdgeLengths* lengths = nullptr);

/// ½ (σ₁² + σ₂² + σ₁⁻² + σ₂⁻²) − 2 over the sheet's area: the symmetric Dirichlet energy
/// ([smith2015bijective]), 0 for isometries, infinite where a triangle is flipped or has no area.
double isometric_energy(const Sheet& sheet, const Points& x);

/// The L² stretch [sander2001texture] of the inverse map, √(Σ A ½(σ₁⁻² + σ₂⁻²) · Σ A σ₁σ₂) / Σ A:
/// at least 1, the same for every scale of x. Infinite where a triangle is flipped.
double l2_stretch(const Sheet& sheet, const Points& x);

/// Pairs of boundary edges that cross or touch, as half-edges of the surface, at most `most`.
std::vector<std::array<HalfEdge, 2>> crossings(const Sheet& sheet, const Points& x, int most);

/// Whether there is one.
inline bool boundary_crosses(const Sheet& sheet, const Points& x) {
  return !crossings(sheet, x, 1).empty();
}

/// Whether a map that flips no triangle covers nothing twice: no crossings, and one loop alone runs
/// counter-clockwise, so that no point is inside two. (Without a flipped triangle a map can still
/// wind around a vertex twice.)
bool is_injective(const Sheet& sheet, const Points& x);

/// Tutte's embedding [tutte1963draw] on a circle of the sheet's area, without a fold up to
/// rounding. The sheet must be a disc.
Points tutte_embedding(const Sheet& sheet, Factorisation kind = Factorisation::automatic);

/// The least squares conformal map [levy2002least] with two far vertices of a boundary, of which
/// there must be one, pinned, at the scale of the surface. It may fold.
Points conformal_map(const Sheet& sheet, Factorisation kind = Factorisation::automatic);

/// As rigid as possible: lowers Σ A |J − R|² over x and rotations R in turn from a first guess,
/// which may fold [liu2008local]. The result may fold too.
Points as_rigid_as_possible(const Sheet& sheet, Points x, int iterations,
                            Factorisation kind = Factorisation::automatic);

struct LowerOptions {
  int iterations = 12;      ///< at most
  double tolerance = 2e-3;  ///< stops where two in a row lower the energy by less each, relative to
                            ///< it and a twentieth of the area
  enum class Crossing {
    allowed,
    refused  ///< no step that lets the boundary cross itself
  } crossing = Crossing::allowed;
  Factorisation factorisation = Factorisation::automatic;
};

/// Lowers the isometric energy by reweighted quadratic models [rabinovich2017scalable] from `x`,
/// which must not fold; nor does the result. Cost: a factorisation of 2 V unknowns per iteration.
Points lower_energy(const Sheet& sheet, Points x, const LowerOptions& options = {},
                    const Progress& progress = {});

/// The map of least energy found: from the conformal map made more rigid, where that does not fold,
/// else from Tutte's embedding of a disc. Empty where all fold, and
/// for a sheet without a boundary.
Points parametrize(const Sheet& sheet, const LowerOptions& options = {},
                   const Progress& progress = {});

}  // namespace mq
