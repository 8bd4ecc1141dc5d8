#pragma once
/// Shapes with sharper edges: the shock filter of normals, and a fit of the vertices to them.

#include <vector>

#include "mq/filter/normal_fit.h"
#include "mq/filter/shock.h"

namespace mq {

struct GeometryShockOptions {
  double normal_alpha = 0;        ///< smoothing of the normals before everything else
  double signal_alpha = 1e-4;     ///< of those that the potential is taken of
  double potential_alpha = 1e-4;  ///< and of the potential; all on the surface of unit area
  ShockTime time = {};
  double fit_alpha = NormalFit::default_alpha;
  int fit_steps = 1;  ///< see `NormalFit::fit`
};

/// A sharpened shape and how it came about.
struct SharpenedShape {
  std::vector<Vector3> positions;
  std::vector<Vector3> normals;  ///< unit, of the triangles: those the shape was fitted to
  Vector potential;              ///< P at the vertices of the surface as it was
  double rate = 0;               ///< Λ of the potential, see `potential_rate`
  double time = 0;               ///< for which paths ran
  PathCounts counts;
  std::vector<SolveReport> solves;  ///< in the order of the work; the last is the fit's
  struct Seconds {
    double smooth = 0, potential = 0, paths = 0, prepare_fit = 0, fit = 0;
    double solver = 0;  ///< of all these, in making solvers and solving
  } seconds;
};

/// The Gauss map N: S → S² is sharpened as a signal of three channels, and the vertices fitted to it
/// (`NormalFit`): flat regions between sharper creases (thesis 3.4.2).
///
/// The potential P = ½|∇N|² = ½(κ₁² + κ₂²) is that of N at the vertices (`vertex_normals`, smoothed
/// by `normal_alpha` against noise, then `signal_alpha`; see `shock_potential`). What is carried are
/// the normals of the triangles: their own, filtered as `filtered_with` says where `normal_alpha` is
/// not 0. From the middle of each third of a triangle a path runs down P; the triangle's new normal is
/// the mean of the three found, of length 1. Where triangles meet at the end of a path, the normal
/// nearest to that of its beginning counts, so that a path does not cross the crease it ends on;
/// normals at 90° or more, to which (3.9) shrinks a triangle to nothing, do not count. For times without end N is piecewise constant, so that the shape comes to be of planes.
///
/// A time of 0 without `normal_alpha` leaves the shape as it is, bit for bit; so does any time where
/// paths do not leave flat faces, as of a cube. Turning and moving the shape turns and moves the
/// result; with relative times, so does a change of unit. Boundaries, vertices that are not manifold
/// and triangles without area are treated as `SurfaceFlow` and `NormalFit` say; nothing is ever
/// infinite. Throws `InvalidInput` on weights or times that are negative or not finite.
SharpenedShape sharpen_shape(const Surface& surface, const GeometryShockOptions& options,
                             const SolverFactory& factory = {},
                             const Progress& progress = {});

}  // namespace mq
