// marquetry denoise MESH [TEXTURE...] -o OUT: take noise off a texture on its surface, by what its patches have in
// common, or by smoothing that stops at edges.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "verbs/shared/denoise_options.h"
#include "verbs/shared/input_pictures.h"
#include "mq/base/error.h"
#include "mq/filter/denoise.h"
#include "mq/filter/patch_denoise.h"
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

/// A mean change of values in 0 to 1 that nobody sees: a quarter of a step of 8 bits.
constexpr double unseen_change = 0.001;

/// What is there to be taken off may not be noise.
void say_that_it_hardly_changes(Run& run, double deviation) {
  run.terminal().remark(fmt::format("noise of deviation {:.3g} is less than 8 bits hold, so hardly anything was changed: blocks of "
                                    "JPEG and a few stray texels are no noise; where you see some, --edge 0.03 smooths up to "
                                    "edges of that height",
                                    deviation));
}

/// What only smoothing up to edges goes by.
constexpr std::array<const char*, 9> of_edges = {"edge",  "guide",  "guide-edge", "alpha", "length",
                                                 "steps", "solver", "tolerance",  "cycles"};

/// Whether patches are asked for, or what there is no other way for is not.
bool by_patches(Run& run, bool at_vertices) {
  const OptionValues& options = run.options();
  const auto asked = std::ranges::find_if(of_edges, [&](const char* name) { return asks_for(options, name); });
  const std::string method = options.text("method");
  if (method == "edges") return false;
  if (method == "automatic") {
    if (at_vertices)
      run.terminal().remark("smoothing up to edges, as colours at vertices have no patches");
    else if (asked != of_edges.end())
      run.terminal().remark(fmt::format(
          "smoothing up to edges, as --{} is given; without it by patches, which keeps more detail", *asked));
    return !at_vertices && asked == of_edges.end();
  }
  require(!at_vertices, "--method patches is for textures: colours at vertices have no patches; leave it out");
  if (asked != of_edges.end())
    throw InvalidInput(fmt::format("--{} is of smoothing up to edges: leave it out, or --method patches", *asked));
  return true;
}

/// Patches.
Signal without_noise(Run& run, const TexturedModel& scene, const ModelSignal& target, const Signal& before) {
  const Step step(run, "solve", 0.79);
  PatchDenoised found =
      denoise_by_patches(scene.surface, *target.texel_atlas(), *target.texel_space(), before,
                         {.strength = asked_noise_strength(run.options())}, step);
  run.result["noise"] = found.noise;
  run.result["smoothed"] = found.smoothed;
  run.result["fireflies"] = found.fireflies;
  run.result["strays"] = found.strays;
  if (found.strays > 0)
    run.print(fmt::format("{} set to the least or the largest value, as salt-and-pepper noise does, {} now what is around {}\n",
                          found.strays == 1 ? "one texel" : fmt::format("{} texels", found.strays),
                          found.strays == 1 ? "is" : "are", found.strays == 1 ? "it" : "them"));
  const double most = std::ranges::max(found.noise);
  if (most > 0)
    run.print(fmt::format("noise of deviation {:.3g} was measured{}\n", most,
                          found.fireflies == 0   ? ""
                          : found.fireflies == 1 ? ", and one firefly"
                                                 : fmt::format(", and {} fireflies", found.fireflies)));
  else if (found.strays == 0)
    say_that_it_is_clean(run);
  if (most > 0 && found.fireflies == 0 && found.strays == 0 &&
      (found.signal - before).norm() < unseen_change * std::sqrt(double(before.size())))
    say_that_it_hardly_changes(run, most);
  if (found.smoothed > 1)
    run.terminal().remark(fmt::format(
        "it seems that a camera or JPEG has smoothed the noise: it is {:.1f} times as strong over some texels as from "
        "one to the next, and taken off so; if it is the grain of cloth or stone, --strength 50 leaves half of it",
        found.smoothed));
  return std::move(found.signal);
}

/// Smoothing.
Signal smooth_up_to_edges(Run& run, const TexturedModel& scene, const ModelSignal& target, const Signal& before) {
  const OptionValues& options = run.options();
  const DenoiseOptions wanted =
      asked_edges(options, target.space().scale(), denoising::spacing(target.space().scale(), target.space().size()));
  const std::vector<Guide> guides = asked_guides(options, scene, target);
  Denoised found;
  solve_as_asked(run, target, [&](const SolverFactory& factory, const SolvingShares& shares) {
    const Step step(run, "solve", shares.prepare + shares.solve + 0.07);
    found = denoise(target.space(), before, guides, wanted, factory, step);
    return found.report;
  });
  say_edge(run, wanted, found.edge);
  return std::move(found.signal);
}

Exit denoise_verb_run(Run& run) {
  const OptionValues& options = run.options();
  TexturedModel scene = read_usable_model(
      run, options.flag("vertices") ? MissingPictures::unneeded : MissingPictures::refuse, 0.04);
  if (at_vertices(options, scene)) refuse_pictures(options);
  const Outputs outputs(
      options.text("output"), scene.model,
      at_vertices(options, scene) ? Outputs::Kind::model : Outputs::Kind::pictures);
  run.will_write(outputs.paths(), outputs.folders());
  check_pictures(options, scene,
                 {"guide", InputPictures::Count::many_sets, InputPictures::Size::of_the_texture});
  const bool patches = by_patches(run, at_vertices(options, scene));
  if (run.dry_run()) return Exit::done;

  std::unique_ptr<ModelSignal> target;
  {
    const Step step(run, "assemble", patches ? 0.13 : 0.2);
    target = make_signal(run, scene, step);
  }
  Signal before, after;
  about(scene.model, [&] {
    before = target->values();
    after = patches ? without_noise(run, scene, *target, before) : smooth_up_to_edges(run, scene, *target, before);
  });
  run.result["method"] = patches ? "patches" : "edges";
  run.result.update(change_json(before, after, value_space(run.options()).space));

  const Step step(run, "write", 0.04);
  target->put(before, after, scene.model);
  set_depth(options, scene.model);
  write_outputs(run, outputs, std::move(scene.model), step);
  return Exit::done;
}

}  // namespace

Verb denoise_verb() {
  using Type = Option::Type;
  constexpr const char* by_edges = "Smoothing up to edges";
  OptionTable table("denoise",
                    "Take noise off a texture, a bake or a lightmap on the surface and keep its "
                    "edges and its detail, across the seams of the texture.");
  table.example("scan.obj -o calm.obj", "noise off a texture, detail kept");
  table.example("scan.obj bake.exr --guide albedo.png -o clean.exr", "baked light, with edges of the albedo");
  add_model_options(table);
  add_model_output_option(table);
  table.add({.name = "method",
             .type = Type::choice,
             .default_value = "automatic",
             .choices = {"automatic", "patches", "edges"},
             .metavar = "HOW",
             .group = "Denoise",
             .help = "patches: by what patches that are alike have in common; edges: smoothing that stops at edges",
             .details = "automatic: patches, of noise that is measured; edges where an option of smoothing up to edges "
                        "is given, and of colours at vertices."});
  add_noise_strength_option(table);
  add_spread_options(table, usual_denoise_length, by_edges,
                     "how far values spread where no edge is: on the surface scaled to unit area");
  add_edge_option(table);
  table.add({.name = "guide",
             .type = Type::path,
             .count = Option::Count::many,
             .group = by_edges,
             .help = "a picture per texture whose edges are kept too: normals, albedo",
             .details = "Of the texture's size. Several guides follow one another, each with a "
                        "picture for every texture."});
  table.add({.name = "guide-edge",
             .type = Type::number,
             .default_value = as_typed(Guide{}.edge),
             .least = 1e-30,
             .most = 1e30,
             .group = by_edges,
             .help = "the same as --edge of the guides"});
  add_steps_option(table);
  add_solver_options(table);
  add_space_option(table);
  add_normals_option(table);
  add_vertices_option(table, "colours at vertices, though there are textures");
  add_depth_option(table);
  table.exclusive({"strength", "edge"});
  table.exclusive({"normals", "vertices"});
  table.exclusive({"normal-space", "vertices"});
  add_frames_option(table);
  return {table, denoise_verb_run,
          {{.what = "noise off, detail kept"}},
          {},
          Slots::several};
}

}  // namespace mq::app
