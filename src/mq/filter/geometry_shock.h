#pragma once
/// Shapes with sharper edges: the shock filter of normals, and a fit of the vertices to them.

#include <vector>

#include "mq/filter/normal_fit.h"
#include "mq/filter/shock.h"

namespace mq {

struct GeometryShockOptions {
  double normal_alpha = 1e-4;     ///< smoothing of the normals before everything else
  double signal_alpha = 1e-4;     ///< of those that the potential is taken of
  double potential_alpha = 1e-4;  ///< and of the potential; all on the surface of unit area
  ShockTime time = {};
  double fit_alpha = NormalFit::default_alpha;
  int fit_steps = 1;  ///< see `NormalFit::fit`
};

/// A sharpened shape and how it came about.
struct SharpenedShape {
  std::vector<Vector3> positions;
  std::vector<Vector3> normals;  ///< unit, at the vertices: those the shape was fitted to
  double rate = 0;               ///< Λ of the potential, see `potential_rate`
  double time = 0;               ///< for which paths ran
  PathCounts counts;
  std::vector<SolveReport> solves;  ///< in the order of the work; the last is the fit's
  struct Seconds {
    double smooth = 0, potential = 0, paths = 0, prepare_fit = 0, fit = 0;
    double solver = 0;  ///< of all these, in making solvers and solving
  } seconds;
};

/// The Gauss map N: S → S² is sharpened as a signal of three channels (`transport_shock`, potential
/// P = ½|∇N|² = ½(κ₁² + κ₂²)), its values scaled to length 1, and the vertices fitted to it
/// (`NormalFit`): flat regions between sharper creases (thesis 3.4.2). N is that of
/// `vertex_normals`, smoothed by `normal_alpha` for noise. For times without end N is piecewise
/// constant, so that the shape comes to be of planes. A time of 0 leaves the shape as it is, to the
/// bit. Any other smooths, however short it is, by `normal_alpha` and because a fit is no identity.
///
/// Turning and moving the shape turns and moves the result; with relative times, so does a change of
/// unit. A plane stays. Boundaries, vertices that are not manifold and triangles without area are
/// treated as `SurfaceFlow` and `NormalFit` say; nothing is ever infinite. Throws `InvalidInput` on
/// weights or times that are negative or not finite.
SharpenedShape sharpen_shape(const Surface& surface, const GeometryShockOptions& options,
                             const SolverFactory& factory = direct_solver(),
                             const Progress& progress = {});

}  // namespace mq
