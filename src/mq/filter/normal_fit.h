#pragma once
/// Shapes that have given normals.

#include <memory>
#include <span>
#include <vector>

#include "mq/fem/vertex_space.h"
#include "mq/filter/screened_poisson.h"

namespace mq {

/// Positions for the vertices of a surface, and how the solve went.
struct Reshaped {
  std::vector<Vector3> positions;  ///< one per vertex; those no triangle reaches stay
  SolveReport report;
};

/// Normals at vertices, unit, before and after a filter of weight w and factor beta on gradients.
struct NormalChange {
  std::span<const Vector3> before, after;
  double weight = 0;
  double beta = 0;
};

/// What that filter makes of the own normals n of triangles:
///
///     n' = mean(after) + g·(n − mean(before)), scaled to length 1,    g = (1 + β·w·λ) / (1 + w·λ),
///
/// the means over the three corners. What vertices cannot hold of a field that is constant on
/// triangles, creases above all, fades (or grows) as the filter has it for waves of a triangle's
/// size: λ = 3/2 · Σ |e|² / area², the mean of the two rates at which linear functions of mean 0 fade
/// on the triangle (24/h² for equal sides h). So a filter that changes nothing, by beta = 1 or
/// w = 0, leaves n as it is, bit for bit; one that reaches further than triangles are long has
/// mean(after) as its result. n stays where the sum is nearly 0, and where it is 0.
std::vector<Vector3> filtered_with(const VertexSpace& space, std::vector<Vector3> own,
                                   const NormalChange& change);

/// Minimises over positions p of the vertices, with normals n constant per triangle,
///
///     ∫ |p − p₀|² dA + w ∫ |∇p − (∇p₀ − ⟨∇p₀, n⟩ n)|² dA,        w = alpha · area:
///
/// gradients as before, but tangent to the planes that n asks for ([yu2004mesh]; thesis 3.4.2,
/// (3.9), which leaves N per triangle and alpha open). In matrices, with G the gradient of each
/// coordinate and M₁ the areas of triangles,
///
///     (M + w·S)·(p − p₀) = −w·Gᵀ M₁ ⟨∇p₀, n⟩ n.
///
/// The sign of n does not matter, only its plane. A triangle whose n is its own (`triangle_normal`),
/// or 0, or which has no area, asks for no change; where all are like that the shape stays bit for
/// bit. Rigid motions of the input (n turned with it) are those of the result; so is a change of
/// unit, as alpha is for unit area. Each component keeps its centre of mass. The area never grows
/// (but for 1/alpha): a triangle that is to turn by an angle θ is seen foreshortened by cos θ.
/// Vertices that `make_surface` took apart because their triangles form several fans stay one.
///
/// Set-up is a factorisation (see `DirectSolver`), each fit a solve of three channels.
class NormalFit {
 public:
  /// Of wave lengths up to 2π·√alpha·√area = 63 √area more than half follows the normals: all of
  /// the shape does, and values only say where it lies. The authors' later program has the same.
  static constexpr double default_alpha = 100;

  /// Throws `InvalidInput` on an alpha that is negative or not finite, and on a surface without
  /// area. The surface is not referred to afterwards.
  explicit NormalFit(const Surface& surface, double alpha = default_alpha,
                     const SolverFactory& factory = {},
                     const Progress& progress = {});

  /// The fit to a normal per triangle, of any length. With more `steps` than one, the gradients of
  /// each are those of the last result, p₀ where values are kept: it comes nearer to the normals
  /// where they turn by much. Throws `InvalidInput` on a normal that is not finite, on a count that
  /// does not fit and on fewer steps than 1.
  Reshaped fit(std::span<const Vector3> normals, int steps = 1,
               const Progress& progress = {}) const;

 private:
  std::vector<int> joined_;  ///< per vertex the one that stands for it
  Signal positions_;         ///< p₀
  std::vector<Vector3> own_;  ///< normals of p₀
  std::unique_ptr<VertexSpace> space_;
  std::unique_ptr<ScreenedPoisson> equation_;
};

/// Per vertex the one that stands for it: where a vertex of the file became several, the file's.
std::vector<int> joined_fans(const Surface& surface);

/// The surface with them joined again, for functions on vertices that are to stay whole; only its
/// triangles, positions, areas and `degenerate` mean anything.
Surface with_fans_joined(const Surface& surface);

}  // namespace mq
