// marquetry filter MESH [TEXTURE...] -o OUT --beta B: smooth or sharpen a signal on its surface.
//
// The verb finds the signal (textures, or colours at vertices), takes it into the space of values
// asked for, lets ScreenedPoisson work, and puts the result back. A texel that the filter leaves
// alone, or that no chart touches, keeps its bits.
#include <cmath>
#include <memory>

#include "mask_options.h"
#include "mq/filter/modulation.h"
#include "outputs.h"
#include "run.h"
#include "scene.h"
#include "signal_options.h"
#include "signal_target.h"
#include "solving.h"
#include "verb.h"

namespace mq::app {
namespace {

Exit filter(Run& run) {
  const OptionValues& options = run.options();
  Scene scene = read_usable_scene(run, MissingPictures::refuse, 0.2);
  const Outputs outputs(
      options.text("output"), scene.model,
      at_vertices(options, scene) ? Outputs::Kind::model : Outputs::Kind::pictures);
  run.will_write(outputs.paths(), outputs.folder());
  if (run.dry_run()) return Exit::done;

  std::unique_ptr<Target> target;
  std::optional<std::vector<double>> mask;
  {
    const Step step(run, "assemble", 0.2);
    target = make_target(run, scene, step.progress().step("space", 0.9));
    mask = asked_mask(run, scene, *target, step.progress().step("mask", 0.1));
  }
  const SurfaceScale scale = target->space().scale();
  const double weight = spread_weight(options, scale), beta = options.number("beta");
  Solution solution;
  about(scene.model, [&] {
    solution = solve_poisson(
        run, *target, weight,
        [&](const ScreenedPoisson& equation, const Signal& before, const Progress& progress) {
          if (!mask) return equation.solve(before, beta, progress);
          return equation.solve(before, modulation(*mask, beta), progress);
        });
  });
  run.result.update(change_json(solution.before, solution.filtered.signal));
  run.result["alpha"] = weight / scale.area;
  run.result["length"] = std::sqrt(weight);

  const Step step(run, "write", 0.1);
  target->put(solution.before, solution.filtered.signal, scene.model);
  set_depth(options, scene.model);
  write_outputs(run, outputs, std::move(scene.model), step);
  return Exit::done;
}

}  // namespace

Verb filter_verb() {
  OptionTable table("filter",
                    "Smooth or sharpen a texture, or colours at vertices, on the surface, across "
                    "the seams of the texture.");
  add_scene_options(table);
  add_output_option(table);
  table.add({.name = "beta",
             .letter = 'b',
             .type = Option::Type::number,
             .required = true,
             .least = 0,
             .most = 1000,
             .group = "Filter",
             .help = "factor on the gradients: 0 smooths, 1 changes nothing, more sharpens"});
  add_mask_options(table, "Filter");
  add_spread_options(table, "0.001", "Filter",
                     "how far it reaches: weight of gradients on the surface scaled to unit area");
  add_solver_options(table);
  add_space_option(table);
  add_normals_option(table);
  add_vertices_option(table, "filter the colours at vertices, though there are textures");
  add_depth_option(table);
  table.exclusive({"normals", "vertices"});
  add_frames_option(table);
  return {table, filter};
}

}  // namespace mq::app
