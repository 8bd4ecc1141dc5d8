#include "mq/model/model_shock.h"

#include "mq/fem/vertex_multigrid.h"
#include "mq/linear/direct_solver.h"

namespace mq {

VertexSolver vertex_solver(const VertexSolverChoice& choice) {
  using Kind = VertexSolverChoice::Kind;
  return [choice](std::span<const Vector3> places) {
    const bool few = std::ssize(places) <= most_for_factorisation;
    if (choice.kind == Kind::direct || (choice.kind == Kind::automatic && few))
      return direct_solver();
    MultigridOptions when;
    when.tolerance = choice.tolerance;
    return vertex_multigrid_solver(places, when);
  };
}

ShockWeights ShockRequest::weights(const SurfaceScale& scale) const {
  return {.signal = weight_from_length(smooth, scale),
          .potential = weight_from_length(smooth_potential, scale)};
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
            found.path_seconds,      found.solves, {}};
  }
  const TexelSpace& space = *signal.texel_space();
  const double edge = request.longest_edge.value_or(usual_longest_edge(space.size()));
  ShockedTexture found = texture_shock(
      model.surface, *signal.texel_atlas(), space, values,
      {.weights = weights, .time = request.time, .longest_edge = edge, .solver = solver}, progress);
  return {std::move(found.signal), found.rate,   found.time,
          found.counts,            found.path_seconds, found.solves,
          ShockedModel::Cut{edge, found.vertices}};
}

SharpenedShape shock_shape(const TexturedModel& model, const ShockRequest& request,
                           const Progress& progress) {
  const auto alpha = [&](const Length& length) {
    return alpha_from_length(length, {.area = model.surface.area});
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
