#include "verbs/shared/shock_geometry.h"

#include <fmt/format.h>

#include "verbs/shared/geometry.h"
#include "verbs/shared/shock_outputs.h"
#include "mq/base/error.h"
#include "options/signal_options.h"
#include "options/solver_options.h"
#include "shell/arguments.h"

namespace mq::app {
namespace {

void report_shape(Run& run, const SharpenedShape& shape) {
  run.result["time"] = shape.time;
  run.result["relative_time"] = shape.time * shape.rate;
  run.result["paths"] = {{"triangles_crossed", shape.counts.triangles},
                         {"edges_slid_along", shape.counts.edges},
                         {"at_rest", shape.counts.resting}};
  const SharpenedShape::Seconds& took = shape.seconds;
  run.result["steps"] = {{"smooth_normals", took.smooth},
                         {"potential", took.potential},
                         {"paths", took.paths},
                         {"fit", took.prepare_fit + took.fit},
                         {"of_these_solver", took.solver}};
}

}  // namespace

void add_shock_geometry_options(OptionTable& table) {
  table.add({.name = "geometry",
             .letter = 'g',
             .group = "Shape",
             .help = "sharpen the shape: its normals, to which vertices are then fitted"});
  table.add({.name = "smooth-normals",
             .type = Option::Type::length,
             .default_value = as_typed(ShockRequest{}.smooth_normals),
             .group = "Shape",
             .help = "how far normals are spread before everything else",
             .details = "Against noise, of which it takes off waves shorter than 6 times as long. 0 "
                        "leaves a clean model its detail."});
  add_fit_options(table, "Shape");
}

Exit shock_geometry(Run& run, const ShockRequest& request) {
  const OptionValues& options = run.options();
  refuse_pictures_of_shape(options);
  TexturedModel scene = read_shape(run, 0.15);
  const Outputs outputs = shape_outputs(options, scene);
  run.will_write(outputs.paths(), outputs.folders());
  const ShockOutputs beside_it(run, scene.model, ShockOutputs::At::vertices, outputs.paths());
  if (run.dry_run()) return Exit::done;

  SharpenedShape shape;
  about(scene.model, [&] {
    const Step step(run, "sharpen", 0.75);
    shape = shock_shape(scene, request, step);
  });
  const SolveReport worst = worst_of(shape.solves);
  run.solve = solve_json(worst);
  if (!worst.converged)
    run.terminal().warning(fmt::format(
        "{} stopped at a relative residual of {:.1e}: the result is less accurate than asked for; "
        "--solver direct has no such limit",
        worst.method, worst.residuals.empty() ? 1 : worst.residuals.back()));
  report_shape(run, shape);
  const Step step(run, "write", 0.1);
  if (beside_it.wanted()) beside_it.write(run, scene, VertexColourSignal(scene), shape.potential);
  put_positions(run, scene, shape.positions,
                "less --time or --smooth-potential keeps more of it");
  write_outputs(run, outputs, std::move(scene.model), step);
  beside_it.report(run);
  return Exit::done;
}

}  // namespace mq::app
