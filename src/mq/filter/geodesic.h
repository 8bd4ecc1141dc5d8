#pragma once
/// Distances along a surface by the heat method.

#include <memory>
#include <optional>
#include <vector>

#include "mq/base/progress.h"
#include "mq/fem/space.h"
#include "mq/linear/solver.h"
#include "mq/mesh/mesh.h"

namespace mq {

/// An unknown whose distance is given: 0 for a source, more where the source lies between unknowns.
struct GeodesicSource {
  int unknown = 0;
  double distance = 0;  ///< model units, not negative
  /// The point it is the distance from, if it is one point: the unknowns around it then get theirs,
  /// see `GeodesicDistance`.
  std::optional<Vector3> from = {};
};

struct GeodesicOptions {
  /// How long heat spreads, in squared mean spacings of the unknowns; in half the square of a texel's
  /// longer side, where these are more than twice as long as wide (`heat_spacing`). Longer rounds off
  /// the lines where paths from both sides meet; shorter makes distances follow the grid.
  double time = 4;
  double tolerance = 1e-3;  ///< sweeps end when rows of the equation miss by less, on average
  int max_sweeps = 200;
};

/// Distances and how they were found.
struct Geodesic {
  Vector distance;     ///< per unknown, model units; infinite where no path leads to a source
  int sweeps = 0;      ///< over all unknowns, for the spread of heat
  double change = 0;   ///< by how much rows of the equation missed in the last of them, mean
  int unreached = 0;   ///< unknowns at an infinite distance
  SolveReport report;  ///< of the Poisson equation
};

/// The distance φ to the nearest source, from two linear equations (thesis 5.9.3; Crane, Weischedel
/// and Wardetzky [crane2013heat]):
///
///     (M + t·S)·u = 0 except at sources,      u_i = exp(−distance_i/√t) at these,
///     S·φ = b,   b_i = ∫ ⟨X, ∇φ_i⟩ dA,      X = ∇w/|∇w|,   w = −√t·log u,
///
/// with M lumped and t = `time`·h², h the mean spacing or what stands for it on stretched texels.
/// X is minus the normalised gradient of u, taken of the logarithm
/// because that is nearly linear; |∇w| is the root mean square over an element, and at least 0.05.
/// φ is determined per component up to a constant, chosen such that the given distances are met on
/// average, and is then what is given where it is given; nothing is below 0.
///
/// Around a source that is a point, the unknowns within three spacings have their straight
/// distances from it, if all of them lie near a plane (a tenth of that radius): the error there,
/// which the distances of all others inherit, then does not depend on where between the unknowns it
/// lies.
///
/// Heat does not leave through boundaries, so near them ∇u runs along them, wherever the shortest
/// paths go. Within 3√t of a boundary w, brought to slope 1 by a function of w, is therefore
/// continued from what lies farther inside, by `fast_marching_distances`.
///
/// u falls by a factor e every √t, two spacings; `sweep_heat` finds it with every ratio accurate,
/// however far from a source, beginning with `fast_marching_distances`. Then one Poisson equation
/// is solved.
///
/// The error is of order h̄: on a square of 256² texels 0.13 % on average for a source near the
/// middle, wherever between texels it lies, 3 % at most beyond three texels; 0.2 % and 5 % for one
/// 25 texels from an edge. Largest near the source and where shortest paths meet.
class GeodesicDistance {
 public:
  /// Assembles and prepares both equations. `space` must outlive the object.
  explicit GeodesicDistance(const SignalSpace& space, const SolverFactory& factory = {},
                            const GeodesicOptions& options = {}, const Progress& progress = {});
  ~GeodesicDistance();

  /// Throws `InvalidInput` when there are no sources, or one is not an unknown or not finite.
  Geodesic from(const std::vector<GeodesicSource>& sources, const Progress& progress = {}) const;

  /// √t, model units.
  double diffusion_length() const;

  struct Parts;

 private:
  std::unique_ptr<Parts> parts_;
};

}  // namespace mq
