#pragma once
/// Shock filters of what a model shows, and of its shape.

#include <optional>
#include <vector>

#include "mq/base/length.h"
#include "mq/filter/geometry_shock.h"
#include "mq/filter/texture_shock.h"
#include "mq/model/model_signal.h"

namespace mq {

/// How systems of vertices are solved.
struct VertexSolverChoice {
  enum class Kind {
    automatic,  ///< a factorisation up to `most_for_factorisation` vertices, multigrid above
    direct,
    multigrid
  } kind = Kind::automatic;
  double tolerance = 1e-4;  ///< relative residual of multigrid: of the field to follow, not of values
};
VertexSolver vertex_solver(const VertexSolverChoice& choice = {});

struct ShockRequest {
  ShockTime time = {ShockTime::Unit::relative, 2};
  Length smooth = {0.3, Length::Unit::percent};            ///< of the signal, before edges are found
  Length smooth_potential = {0.3, Length::Unit::percent};  ///< of their strength
  VertexSolverChoice solver;

  /// Of the triangles that textures are sharpened on; nothing: `usual_longest_edge`.
  std::optional<double> longest_edge;

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

  /// The cut of textures' triangles; nothing at vertices.
  struct Cut {
    double longest_edge = 0;  ///< texels
    int vertices = 0;
  };
  std::optional<Cut> cut;
};

/// Values of this signal of the model sharpened: `texture_shock`, or `transport_shock` of colours at
/// vertices, which throw. `values` has a row per unknown.
ShockedModel shock_signal(const TexturedModel& model, const ModelSignal& signal,
                          const Signal& values, const ShockRequest& request = {},
                          const Progress& progress = {});

/// The shape sharpened: `sharpen_shape`. Lengths are not in texels.
SharpenedShape shock_shape(const TexturedModel& model, const ShockRequest& request = {},
                           const Progress& progress = {});

}  // namespace mq
