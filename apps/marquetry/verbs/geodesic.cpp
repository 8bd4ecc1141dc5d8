// marquetry geodesic MESH [TEXTURE...] -o OUT --from PLACE: distances along the surface.
#include <fmt/format.h>

#include "shell/arguments.h"
#include "options/signal_options.h"
#include "verbs/shared/distance_options.h"
#include "verbs/shared/input_pictures.h"
#include "mq/base/error.h"
#include "mq/fem/field_metric.h"
#include "mq/filter/geodesic.h"
#include "shell/results.h"
#include "options/solver_options.h"
#include "options/source_options.h"
#include "shell/verb.h"

namespace mq::app {
namespace {

TexelSpaceOptions asked_metric(const OptionValues& options, const TexturedModel& scene) {
  TexelSpaceOptions space;
  if (by_texture(options)) space.metrics = texel_metrics_of_plane(*scene.atlas);
  return space;
}

Geodesic solve(Run& run, const ModelSignal& domain, const std::vector<GeodesicSource>& sources) {
  Geodesic found;
  solve_as_asked(run, domain, [&](const SolverFactory& factory, const SolvingShares& shares) {
    std::unique_ptr<GeodesicDistance> geodesic;
    {
      const Step step(run, "prepare", 0.65 * shares.prepare);
      geodesic = std::make_unique<GeodesicDistance>(
          domain.space(), factory, GeodesicOptions{.time = run.options().number("time")}, step);
    }
    const Step step(run, "solve", 1.85 * shares.solve);
    found = geodesic->from(sources, step);
    run.result["diffusion_length"] = geodesic->diffusion_length();
    return found.report;
  });
  return found;
}

Exit geodesic(Run& run) {
  const OptionValues& options = run.options();
  require(!options.texts("from").empty() || !options.texts("from-mask").empty(),
          "--from: say where distances begin: --from x,y,z, --from texel,column,row or --from-mask "
          "PICTURE");
  TexturedModel scene = read_usable_model(run, MissingPictures::assume, 0.02);
  const bool vertices = works_at_vertices(options, scene);
  require(!vertices || !by_texture(options), "--metric texture is of texels, and vertices are worked on");
  const Outputs outputs(options.text("output"), scene.model,
                        vertices ? Outputs::Kind::model : Outputs::Kind::pictures);
  run.will_write(outputs.paths(), outputs.folders());
  check_pictures(options, scene,
                 {"from-mask", InputPictures::Count::one_set, InputPictures::Size::of_the_texture});
  const std::vector<SourcePlace> places = source_places(run, scene);
  if (run.dry_run()) return Exit::done;

  std::unique_ptr<ModelSignal> domain;
  {
    const Step step(run, "assemble", 0.14);
    domain = make_field_signal(run, scene, step, TextureSignalOptions::SharedTexels::one_for_each,
                               TextureSignalOptions::Pictures::replaced, asked_metric(options, scene));
  }
  Geodesic found;
  about(scene.model, [&] {
    std::vector<GeodesicSource> sources = sources_at(run, scene, *domain, places);
    if (by_texture(options))
      for (GeodesicSource& source : sources) source.from.reset();  // a place in space, whose metric is another
    run.result["sources"] = sources.size();
    found = solve(run, *domain, sources);
  });
  const double most = domain->space().largest_shown(found.distance);
  run.result["max"] = most;
  run.result["unreached"] = found.unreached;
  run.result["sweeps"] = found.sweeps;
  run.result["missed"] = found.change;
  if (found.change > 0.01)
    run.terminal().warning(fmt::format(
        "the spread of heat still misses its equation by {:.1g} after {} sweeps: distances may be "
        "wrong; --time 16 helps where charts are much stretched",
        found.change, found.sweeps));
  if (found.unreached > 0)
    run.terminal().remark(fmt::format(
        "{} of {} unknowns are on parts of the surface without a source: -1 as numbers, grey as "
        "colours",
        found.unreached, found.distance.size()));
  run.print(fmt::format("largest distance: {:g}\n", most));

  const Step step(run, "write", 0.03);
  const bool numbers = writes_numbers(options, outputs.paths().front());
  domain->replace(numbers ? distances_as_numbers(found.distance, vertices ? 3 : 1)
                          : distances_as_colours(options, found.distance, most, domain->scale().texel_spacing),
                  numbers ? Depth::f32 : Depth::u8, scene.model);
  write_outputs(run, outputs, std::move(scene.model), step);
  return Exit::done;
}

}  // namespace

Verb geodesic_verb() {
  OptionTable table("geodesic",
                    "Measure distances along the surface, across the seams of the texture, from "
                    "one place or many.");
  table.example("bust.obj --from 0,0.3,1 -o distances.png", "distances from the point of the surface nearest to there");
  add_model_options(table);
  add_model_output_option(table);
  add_source_options(table);
  add_distance_options(table);
  // Of the difference to a first guess that is some per cent off: a tenth of what texels allow.
  add_solver_options(table, "1e-3");
  add_vertices_option(table, "distances at vertices, though there are textures");
  add_frames_option(table);
  return {table, geodesic,
          {{.what = "distances"}}};
}

}  // namespace mq::app
