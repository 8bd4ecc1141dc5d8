// marquetry geodesic MESH [TEXTURE...] -o OUT --from PLACE: distances along the surface.
#include <fmt/format.h>

#include <cmath>

#include "shell/arguments.h"
#include "options/signal_options.h"
#include "verbs/shared/input_pictures.h"
#include "mq/base/error.h"
#include "mq/draw/false_colour.h"
#include "mq/fem/field_metric.h"
#include "mq/filter/geodesic.h"
#include "mq/io/file_names.h"
#include "mq/io/held_files.h"
#include "shell/results.h"
#include "options/solver_options.h"
#include "options/source_options.h"
#include "shell/verb.h"

namespace mq::app {
namespace {

/// Whether distances are written as numbers: asked for, or the format is one for numbers.
bool writes_numbers(const OptionValues& options, const std::filesystem::path& path) {
  const std::string show = options.text("show");
  if (show != "automatic") return show == "numbers";
  return holds_numbers(path) || names_held(path);
}

Signal as_numbers(const Vector& distance, int channels) {
  Signal values(distance.size(), channels);
  for (Eigen::Index i = 0; i < distance.size(); ++i) {
    const double d = std::isfinite(distance[i]) ? distance[i] : -1;
    values.row(i).setConstant(d);
  }
  return values;
}

bool by_texture(const OptionValues& options) { return options.text("metric") == "texture"; }

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
      const Step step(run, "prepare", shares.prepare);
      geodesic = std::make_unique<GeodesicDistance>(
          domain.space(), factory, GeodesicOptions{.time = run.options().number("time")}, step);
    }
    const Step step(run, "solve", shares.solve + 0.05);
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
  TexturedModel scene = read_usable_model(run, MissingPictures::assume, 0.05);
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
    const Step step(run, "assemble", 0.18);
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
  const DistanceColours scale{.most = most,
                              .lines = int(options.integer("isolines")),
                              .line_width = 1.5 * domain->scale().texel_spacing};
  domain->replace(
      numbers ? as_numbers(found.distance, vertices ? 3 : 1) : distance_colours(found.distance, scale),
      numbers ? Depth::f32 : Depth::u8, scene.model);
  write_outputs(run, outputs, std::move(scene.model), step);
  return Exit::done;
}

}  // namespace

Verb geodesic_verb() {
  using Type = Option::Type;
  OptionTable table("geodesic",
                    "Measure distances along the surface, across the seams of the texture, from "
                    "one place or many.");
  table.example("bust.obj --from 0,0.3,1 -o distances.png", "distances from the point of the surface nearest to there");
  add_model_options(table);
  add_model_output_option(table);
  add_source_options(table);
  table.add({.name = "time",
             .type = Type::number,
             .default_value = as_typed(GeodesicOptions{}.time),
             .least = 1,
             .most = 1e6,
             .group = "Distance",
             .help = "how long heat spreads, in squared texels",
             .details = "Longer is smoother and rounds off the lines where shortest paths meet."});
  table.add({.name = "metric",
             .type = Type::choice,
             .default_value = "surface",
             .choices = {"surface", "texture"},
             .group = "Distance",
             .help = "lengths are those on the surface, or those in the texture, to compare with",
             .details = "texture: as if the charts were flat and sewn together, with as much area as the surface."});
  table.add({.name = "show",
             .type = Type::choice,
             .default_value = "automatic",
             .choices = {"automatic", "numbers", "colours"},
             .group = "Distance",
             .help = "distances as numbers or as colours with lines of equal distance",
             .details = "automatic: numbers in .exr and .tif, and in memory, in model units; colours elsewhere."});
  table.add({.name = "isolines",
             .type = Type::integer,
             .default_value = as_typed(DistanceColours{}.lines),
             .least = 0,
             .most = 10000,
             .group = "Distance",
             .help = "lines of equal distance, evenly spaced, in colours"});
  // Of the difference to a first guess that is some per cent off: a tenth of what texels allow.
  add_solver_options(table, "1e-3");
  add_vertices_option(table, "distances at vertices, though there are textures");
  add_frames_option(table);
  return {table, geodesic,
          {{.what = "distances"}}};
}

}  // namespace mq::app
