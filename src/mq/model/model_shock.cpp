#include "mq/model/model_shock.h"

#include "mq/fem/texel_vector_space.h"
#include "mq/fem/vertex_multigrid.h"
#include "mq/linear/direct_solver.h"

namespace mq {

VertexSolver vertex_solver(const ShockSolverChoice& choice) {
  using Kind = ShockSolverChoice::Kind;
  return [choice](std::span<const Vector3> places) {
    const bool few = std::ssize(places) <= most_for_factorisation;
    if (choice.kind == Kind::direct || (choice.kind == Kind::automatic && few))
      return direct_solver();
    MultigridOptions when;
    when.tolerance = choice.tolerance;
    return vertex_multigrid_solver(places, when);
  };
}

SolverFactory texel_solver(const ShockSolverChoice& choice, const TexelSpace& space) {
  using Kind = ShockSolverChoice::Kind;
  const StoppingRule stop{.tolerance = choice.tolerance};
  switch (choice.kind) {
    case Kind::direct: return direct_solver();
    case Kind::multigrid: return space.multigrid(stop);
    case Kind::automatic: break;
  }
  return space.solver(stop);
}

Length usual_shock_smoothing(const SurfaceScale& scale) {
  if (scale.texel_spacing > 0) return {1.5, Length::Unit::texels};
  return {0.3, Length::Unit::percent};
}

ShockWeights ShockRequest::weights(const SurfaceScale& scale) const {
  const Length usual = usual_shock_smoothing(scale);
  return {.signal = weight_from_length(smooth.value_or(usual), scale),
          .potential = weight_from_length(smooth_potential.value_or(usual), scale)};
}

ShockedModel shock_signal(const TexturedModel& model, const ModelSignal& signal,
                          const Signal& values, const ShockRequest& request,
                          const Progress& progress) {
  const ShockWeights weights = request.weights(signal.space().scale());
  const VertexSolver solver = vertex_solver(request.solver);
  if (const VertexSpace* space = signal.vertex_space()) {
    const TraceMesh mesh(model.surface, progress.step("order triangles", 0.1));
    Shocked found = transport_shock(mesh, *space, values, weights, request.time,
                                    solver(model.surface.mesh.positions),
                                    progress.step("filter", 0.9));
    return {std::move(found.signal), found.rate,   found.time, found.counts,
            found.path_seconds,      found.solves, std::move(found.potential)};
  }
  const TexelSpace& space = *signal.texel_space();
  const TextureShock shock(model.surface, *signal.texel_atlas(), space, values,
                           {.weights = weights, .time = request.time, .solver = texel_solver(request.solver, space)},
                           progress);
  ShockedTexture found = shock.at(request.time, progress);
  return {std::move(found.signal), found.rate,         found.time,
          found.counts,            found.path_seconds, std::move(found.solves), shock.potential()};
}

ModelField downhill_field(const TexturedModel& model, const ModelSignal& signal, const Vector& potential) {
  if (!signal.texel_space()) return {gradient_field(model.surface, -potential), {}, {}};
  const TexelVectorSpace vectors(model.surface, *signal.texel_atlas(), *signal.texel_space());
  Vector z = vectors.gradient(-potential);
  TangentField field = vectors.on_triangles(z);
  return {std::move(field), std::move(z), {}};
}

SharpenedShape shock_shape(const TexturedModel& model, const ShockRequest& request,
                           const Progress& progress) {
  const SurfaceScale scale{.area = model.surface.area};
  const auto alpha = [&](const std::optional<Length>& length) {
    return alpha_from_length(length.value_or(usual_shock_smoothing(scale)), scale);
  };
  return sharpen_shape(model.surface,
                       {.normal_alpha = alpha(request.smooth_normals),
                        .signal_alpha = alpha(request.smooth),
                        .potential_alpha = alpha(request.smooth_potential),
                        .time = request.time,
                        .fit_alpha = request.fit_alpha,
                        .fit_steps = request.fit_steps},
                       vertex_solver(request.solver)(model.surface.mesh.positions), progress);
}

}  // namespace mq
