// marquetry denoise MESH [TEXTURE...] -o OUT: smooth a texture on its surface, but not over edges.
#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "verbs/shared/input_pictures.h"
#include "mq/base/error.h"
#include "mq/filter/denoise.h"
#include "shell/arguments.h"
#include "shell/results.h"
#include "options/signal_options.h"
#include "options/solver_options.h"
#include "shell/verb.h"

namespace mq::app {
namespace {

/// The pictures of --guide, a set for each guide.
std::vector<Guide> asked_guides(const OptionValues& options, const TexturedModel& scene,
                                const ModelSignal& target) {
  const std::vector<std::string> files = options.texts("guide");
  if (files.empty()) return {};
  const auto* textures = dynamic_cast<const TextureSignal*>(&target);
  require(textures != nullptr, files.front() + ": --guide is for textures, not for colours at vertices");
  const std::size_t count = scene.texture_sizes.size();
  std::vector<Guide> guides;
  for (std::size_t first = 0; first < files.size(); first += count) {
    std::vector<Image<float>> pictures;
    for (std::size_t i = 0; i < count; ++i) {
      pictures.push_back(read_texture(files[first + i]).pixels);
      require_size(files[first + i], pictures[i].width(), pictures[i].height(), scene, i);
    }
    guides.push_back({textures->gather(pictures), options.number("guide-edge")});
  }
  return guides;
}

/// Which edges were kept, where nobody said.
void say_measured(Run& run, double edge) {
  if (edge > 0)
    run.print(fmt::format("edges kept above {:.3g} from texel to texel, as the noise was measured (--edge)\n",
                          edge));
  else
    run.terminal().warning("no noise was found: a quarter of the signal and more is constant, and nothing was changed; "
             "--edge, such as 0.01, says what is noise");
}

Exit denoise_verb_run(Run& run) {
  const OptionValues& options = run.options();
  TexturedModel scene = read_usable_model(
      run, options.flag("vertices") ? MissingPictures::unneeded : MissingPictures::refuse, 0.2);
  if (at_vertices(options, scene)) refuse_pictures(options);
  const Outputs outputs(
      options.text("output"), scene.model,
      at_vertices(options, scene) ? Outputs::Kind::model : Outputs::Kind::pictures);
  run.will_write(outputs.paths(), outputs.folders());
  check_pictures(options, scene,
                 {"guide", InputPictures::Count::many_sets, InputPictures::Size::of_the_texture});
  if (run.dry_run()) return Exit::done;

  std::unique_ptr<ModelSignal> target;
  {
    const Step step(run, "assemble", 0.2);
    target = make_signal(run, scene, step);
  }
  const bool spread_given = options.given("alpha") || options.given("length");
  DenoiseOptions wanted{.weight = spread_given ? spread_weight(options, target->space().scale())
                                               : usual_denoise_weight(target->space()),
                        .steps = int(options.integer("steps"))};
  if (options.has("edge")) {
    const double edge = options.number("edge");
    wanted.edge = edge > 0 ? edge : std::numeric_limits<double>::infinity();
  }
  Signal before;
  Denoised found;
  about(scene.model, [&] {
    const std::vector<Guide> guides = asked_guides(options, scene, *target);
    before = target->values();
    solve_as_asked(run, *target,
                   [&](const SolverFactory& factory, const SolvingShares& shares) {
                     const Step step(run, "solve", shares.prepare + shares.solve + 0.1);
                     found = denoise(target->space(), before, guides, wanted, factory, step);
                     return found.report;
                   });
  });
  run.result.update(change_json(before, found.signal, value_space(run.options()).space));
  run.result["length"] = std::sqrt(wanted.weight);
  run.result["edge"] = number_json(found.edge);
  if (!wanted.edge) say_measured(run, found.edge);

  const Step step(run, "write", 0.1);
  target->put(before, found.signal, scene.model);
  set_depth(options, scene.model);
  write_outputs(run, outputs, std::move(scene.model), step);
  return Exit::done;
}

}  // namespace

Verb denoise_verb() {
  using Type = Option::Type;
  OptionTable table("denoise",
                    "Take noise off a texture, a bake or a lightmap on the surface and keep its "
                    "edges, across the seams of the texture.");
  table.example("scan.obj -o calm.obj", "noise off a texture, edges kept");
  table.example("scan.obj bake.exr --guide albedo.png -o clean.exr", "baked light, with edges of the albedo");
  add_model_options(table);
  add_model_output_option(table);
  add_spread_options(table, usual_denoise_length, "Denoise",
                     "how far values spread where no edge is: on the surface scaled to unit area");
  table.add({.name = "edge",
             .letter = 'e',
             .type = Type::number,
             .least = 0,
             .most = 1e30,
             .group = "Denoise",
             .help = "change of the values from texel to texel at which they spread half as well",
             .details = "Of all channels together, in the values of --space. Without it by the noise that "
                        "is measured. 0: its own edges do not count, only those of guides."});
  table.add({.name = "guide",
             .type = Type::path,
             .count = Option::Count::many,
             .group = "Denoise",
             .help = "a picture per texture whose edges are kept too: normals, albedo",
             .details = "Of the texture's size. Several guides follow one another, each with a "
                        "picture for every texture."});
  table.add({.name = "guide-edge",
             .type = Type::number,
             .default_value = as_typed(Guide{}.edge),
             .least = 1e-30,
             .most = 1e30,
             .group = "Denoise",
             .help = "the same as --edge of the guides"});
  table.add({.name = "steps",
             .type = Type::integer,
             .default_value = as_typed(DenoiseOptions{}.steps),
             .least = 1,
             .most = 1000,
             .group = "Denoise",
             .help = "solutions, each with the edges of the one before, after a first slight one"});
  add_solver_options(table);
  add_space_option(table);
  add_normals_option(table);
  add_vertices_option(table, "colours at vertices, though there are textures");
  add_depth_option(table);
  table.exclusive({"normals", "vertices"});
  table.exclusive({"normal-space", "vertices"});
  add_frames_option(table);
  return {table, denoise_verb_run,
          {{.what = "smoothing that keeps edges"}},
          {},
          Slots::several};
}

}  // namespace mq::app
