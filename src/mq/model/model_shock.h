#pragma once
/// Shock filters of what a model shows, and of its shape.

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "mq/base/length.h"
#include "mq/filter/geometry_shock.h"
#include "mq/filter/texture_shock.h"
#include "mq/model/model_field.h"
#include "mq/model/model_signal.h"

namespace mq {

/// How systems of vertices and texels are solved.
struct ShockSolverChoice {
  enum class Kind {
    automatic,  ///< a factorisation up to `most_for_factorisation` unknowns, multigrid above
    direct,
    multigrid
  } kind = Kind::automatic;
  double tolerance = 1e-4;  ///< relative residual of multigrid: of the field to follow, not of values
};

/// Makes a solver for systems of vertices at these places.
using VertexSolver = std::function<SolverFactory(std::span<const Vector3> positions)>;
VertexSolver vertex_solver(const ShockSolverChoice& choice = {});

/// A solver for systems of this space.
SolverFactory texel_solver(const ShockSolverChoice& choice, const TexelSpace& space);

/// How far to smooth where nobody says: 1.5 texels, as what is narrower than three times that may go, print above all;
/// 0.3 % where there are no texels.
Length usual_shock_smoothing(const SurfaceScale& scale);

/// `ShockTime::Unit::relative` of shapes where nobody says: what is small on them is no print, which a longer time closes.
inline constexpr double usual_shock_time_of_shapes = 1;

struct ShockRequest {
  ShockTime time = {ShockTime::Unit::relative, 0.3};  ///< of shapes see above
  std::optional<Length> smooth;            ///< of the signal, before edges are found; none: `usual_shock_smoothing`
  std::optional<Length> smooth_potential;  ///< of their strength; the same
  ShockSolverChoice solver;

  /// Of shapes, see `GeometryShockOptions`.
  Length smooth_normals;
  double fit_alpha = GeometryShockOptions{}.fit_alpha;
  int fit_steps = GeometryShockOptions{}.fit_steps;

  ShockWeights weights(const SurfaceScale& scale) const;
};

/// A sharpened signal and how it came about.
struct ShockedModel {
  Signal signal;
  double rate = 0;  ///< Λ, see `potential_rate`
  double time = 0;  ///< for which paths ran
  PathCounts counts;
  double path_seconds = 0;
  std::vector<SolveReport> solves;
  Vector potential;  ///< P per unknown, see `shock_potential`
};

/// Values of this signal of the model sharpened: `texture_shock`, or `transport_shock` of colours at
/// vertices, which throw. `values` has a row per unknown.
ShockedModel shock_signal(const TexturedModel& model, const ModelSignal& signal,
                          const Signal& values, const ShockRequest& request = {},
                          const Progress& progress = {});

/// −∇P of a potential per unknown of this signal, along which paths run (thesis 3.4.1), in its unit over length. At
/// vertices constant on each triangle, as paths have it. Of texels a vector around each, the mean of those in its
/// cells, which are what paths follow; and per triangle the mean of these.
ModelField downhill_field(const TexturedModel& model, const ModelSignal& signal, const Vector& potential);

/// The shape sharpened: `sharpen_shape`. Lengths are not in texels.
SharpenedShape shock_shape(const TexturedModel& model, const ShockRequest& request = {},
                           const Progress& progress = {});

}  // namespace mq
