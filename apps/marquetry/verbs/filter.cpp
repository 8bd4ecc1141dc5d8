// marquetry filter MESH [TEXTURE...] -o OUT --strength N: smooth or sharpen a signal on its surface.
//
// The verb finds the signal (textures, or colours at vertices), takes it into the space of values
// asked for, lets ScreenedPoisson work, and puts the result back. A texel that the filter leaves
// alone, or that no chart touches, keeps its bits. With --geometry the signal is the shape itself:
// positions, or normals that vertices are then fitted to.
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <tuple>
#include <utility>

#include "verbs/shared/filter_strength.h"
#include "verbs/shared/geometry.h"
#include "options/field_options.h"
#include "options/gradient_options.h"
#include "options/mask_options.h"
#include "mq/base/error.h"
#include "mq/filter/geometry_filter.h"
#include "mq/filter/halo_limit.h"
#include "mq/filter/luminance.h"
#include "mq/filter/modulation.h"
#include "shell/arguments.h"
#include "shell/results.h"
#include "shell/run.h"
#include "options/model_options.h"
#include "options/signal_options.h"
#include "options/solver_options.h"
#include "shell/verb.h"

namespace mq::app {
namespace {

GeometryFilterOptions asked_filter(const OptionValues& options, const SurfaceScale& scale) {
  const auto length = [&](const std::string& name) {
    return std::sqrt(weight_from_length(parse_length(options.text(name)), scale));
  };
  GeometryFilterOptions wanted{.weight = asked_weight(options, scale), .beta = asked_beta(options)};
  if (options.has("by-curvature")) wanted.crease_length = length("by-curvature");
  const double spread = length("smooth-normals");
  wanted.crease_alpha = spread * spread / scale.area;
  return wanted;
}

/// New positions of the vertices, and the reports of all that was solved.
std::pair<std::vector<Vector3>, SolveReport> filtered_shape(const Surface& surface,
                                                            const OptionValues& options,
                                                            const GeometryFilterOptions& wanted,
                                                            const SolverFactory& factory,
                                                            const Progress& progress) {
  if (!options.flag("normals")) {
    Reshaped shape = filter_positions(surface, wanted, factory, progress);
    return {std::move(shape.positions), shape.report};
  }
  const FilteredNormals found =
      filter_normals(surface, wanted, factory, progress.step("normals", 0.5));
  const NormalFit fit(surface, options.number("fit-weight"), factory, progress.step("prepare", 0.4));
  Reshaped shape = fit.fit(found.of_triangles, int(options.integer("fit-steps")),
                           progress.step("fit", 0.1));
  return {std::move(shape.positions), worst_of({found.report, shape.report})};
}

bool sharpens_normals(const OptionValues& options) { return options.flag("normals") && asked_beta(options) > 1; }

/// What keeps more of a shape's size. Normals that turn more foreshorten more, in any number of small steps;
/// positions do not.
std::string advice_on_size(const OptionValues& options) {
  if (sharpens_normals(options))
    return "parts that are thin may have come through each other; without --normals, and with half the --length, more "
           "of it is kept";
  return "a shorter --length or a --beta nearer to 1 keeps more of it";
}

Exit filter_geometry(Run& run) {
  const OptionValues& options = run.options();
  require(!options.flag("normals") || (options.texts("mask").empty() && options.texts("spot").empty()),
          "--mask and --spot are for positions: vertices fitted to normals that changed in one place "
          "move everywhere; leave --normals out");
  require(options.flag("normals") ||
              (!asks_for(options, "fit-weight") && !asks_for(options, "fit-steps")),
          "--fit-weight and --fit-steps are of the fit to filtered normals: give --normals too");
  require(options.has("by-curvature") || !asks_for(options, "smooth-normals"),
          "--smooth-normals is for finding creases: give --by-curvature too. To smooth the normals "
          "themselves, give --normals --beta 0 and how far as --length");
  refuse_pictures_of_shape(options);
  TexturedModel scene = read_shape(run, 0.2);
  const Outputs outputs = shape_outputs(options, scene);
  run.will_write(outputs.paths(), outputs.folders());
  if (run.dry_run()) return Exit::done;
  if (sharpens_normals(options))
    run.terminal().remark("normals that are sharpened make a shape thinner, and what is thin may come through itself; "
                          "without --normals it is made thicker");

  std::vector<Vector3> positions;
  about(scene.model, [&] {
    const VertexColourSignal target(scene);
    const SurfaceScale scale = target.space().scale();
    GeometryFilterOptions wanted = asked_filter(options, scale);
    if (const auto mask = asked_mask(run, scene, target, {})) wanted.mask = *mask;
    solve_as_asked(run, target, [&](const SolverFactory& factory, const SolvingShares& shares) {
      const Step step(run, "filter", shares.prepare + shares.solve);
      SolveReport report;
      std::tie(positions, report) =
          filtered_shape(scene.surface, options, wanted, factory, step);
      return report;
    });
    run.result["alpha"] = number_json(wanted.weight / scale.area);
    run.result["length"] = number_json(std::sqrt(wanted.weight));
  });
  const Step step(run, "write", 0.04);
  put_positions(run, scene, positions, advice_on_size(options));
  write_outputs(run, outputs, std::move(scene.model), step);
  return Exit::done;
}

/// What is filtered of values: their luminance, or each channel by itself.
Signal filtered_part(const Run& run, const TexturedModel& scene, Signal values) {
  return by_luminance(run.options(), scene.model) ? luminance(values) : std::move(values);
}

/// What sharpening is to keep to. Nothing where halos are as the equation has them, or nothing is sharpened.
std::optional<HaloLimit> halo_limit(const Run& run, const TexturedModel& scene, const ModelSignal& target,
                                    const HaloOptions& halo, Signal values, const std::vector<double>& beta,
                                    const Progress& progress) {
  if (std::isinf(halo.fraction) || !sharpens(beta)) return std::nullopt;
  return HaloLimit(target.space(), filtered_part(run, scene, std::move(values)), halo, progress);
}

/// `space` is that of the equation, in which distances are others than in the signal's own.
Filtered filtered_along(const Run& run, const TexturedModel& scene, const SignalSpace& space,
                        const ScreenedPoisson& equation, const Signal& before, const std::vector<double>& beta,
                        const std::optional<HaloLimit>& limit, const Progress& progress) {
  const Signal values = filtered_part(run, scene, before);
  Filtered found = limit ? solve_without_halos(equation, space, values, beta, *limit, progress)
                         : equation.solve(values, beta, progress);
  if (by_luminance(run.options(), scene.model)) found.signal = with_luminance(before, values, found.signal);
  return found;
}

Solution filtered_in_steps(Run& run, TexturedModel& scene, const ModelSignal& target, double weight,
                           const std::vector<double>& beta, const std::optional<HaloLimit>& limit) {
  std::optional<SolveInSteps> steps;
  return solve_in_steps(
      run, scene.model, target, weight,
      {.begin = [&](Signal before) {
         steps.emplace(target.space(), filtered_part(run, scene, std::move(before)), beta, limit ? &*limit : nullptr);
       },
       .solve = [&](const ScreenedPoisson& equation, const Progress& progress) { return steps->solve(equation, progress); },
       .end = [&](const Signal& before) {
         const bool of_luminance = by_luminance(run.options(), scene.model);
         if (!of_luminance) return std::move(*steps).solution(before);
         const Signal Y = luminance(before);
         return with_luminance(before, Y, std::move(*steps).solution(Y));
       }});
}

Exit filter(Run& run) {
  const OptionValues& options = run.options();
  const bool towards = options.has("gradient");
  require(towards || !asks_for(options, "gradient-scale"), "--gradient-scale is of a field: name one with --gradient");
  if (!towards) require_strength(options);
  if (options.flag("geometry")) return filter_geometry(run);
  for (const char* name : {"by-curvature", "smooth-normals", "fit-weight", "fit-steps"})
    require(!asks_for(options, name),
            fmt::format("--{} is for the shape of a model: give --geometry too", name));
  TexturedModel scene = read_usable_model(
      run, options.flag("vertices") ? MissingPictures::unneeded : MissingPictures::refuse, 0.03);
  if (at_vertices(options, scene)) refuse_pictures(options);
  const Outputs outputs(
      options.text("output"), scene.model,
      at_vertices(options, scene) ? Outputs::Kind::model : Outputs::Kind::pictures);
  run.will_write(outputs.paths(), outputs.folders());
  check_mask(run, scene);
  if (towards) check_gradient(options, scene);
  if (run.dry_run()) return Exit::done;

  std::unique_ptr<ModelSignal> target;
  std::unique_ptr<SignalSpace> along;
  std::optional<std::vector<double>> mask;
  {
    const Step step(run, "assemble", 0.26);
    target = make_signal(run, scene, step.progress().step("space", 0.5));
    about(scene.model, [&] { along = asked_space_along(run, scene, *target, step.progress().step("along the field", 0.4)); });
    mask = asked_mask(run, scene, *target, step.progress().step("mask", 0.1));
  }
  const SurfaceScale scale = target->space().scale();
  const double weight = asked_weight(options, scale);
  std::vector<double> beta;
  if (!towards)
    beta = mask ? modulation(*mask, asked_beta(options)) : std::vector{asked_beta(options)};
  Solution solution;
  HaloOptions halo;
  std::optional<HaloLimit> limit;
  about(scene.model, [&] {
    if (!towards) {
      // Before the solver stands: each of them needs much memory while it is made.
      const Step step(run, "look around", 0.05);
      Signal values = target->values();
      halo = asked_halos(options, scene.model, largest_value(values));
      limit = halo_limit(run, scene, *target, halo, std::move(values), beta, step);
    }
    if (!towards && !along) {
      solution = filtered_in_steps(run, scene, *target, weight, beta, limit);
      return;
    }
    const SignalSpace& space = along ? *along : target->space();
    solution = solve_poisson(
        run, *target, space, weight,
        [&](const ScreenedPoisson& equation, const Signal& before, const Progress& progress) {
          if (towards)
            return equation.solve_towards(
                before, asked_gradient_moments(run, scene, *target, before, progress.step("field", 0.2)),
                progress.step("solve", 0.8));
          return filtered_along(run, scene, space, equation, before, beta, limit, progress);
        });
  });
  run.result.update(change_json(solution.before, solution.filtered.signal, value_space(run.options()).space));
  run.result["alpha"] = number_json(weight / scale.area);
  run.result["length"] = number_json(std::sqrt(weight));
  if (!towards) {
    run.result["halo"] = number_json(halo.fraction);
    run.result["threshold"] = halo.threshold;
  }

  const Step step(run, "write", 0.04);
  target->put(solution.before, solution.filtered.signal, scene.model);
  set_depth(options, scene.model);
  write_outputs(run, outputs, std::move(scene.model), step);
  return Exit::done;
}

void add_shape_options(OptionTable& table) {
  table.add({.name = "geometry",
             .letter = 'g',
             .group = "Shape",
             .help = "filter the shape: the positions of the vertices, or with --normals its normals",
             .details = "With --normals normals are filtered and vertices fitted to them, which "
                        "keeps more of the size of things."});
  table.add({.name = "by-curvature",
             .type = Option::Type::length,
             .group = "Shape",
             .help = "keep creases: distances across them count for more",
             .details = "A direction in which the surface curves with radius r is stretched by "
                        "sqrt(1 + (LENGTH/r)^2)."});
  table.add({.name = "smooth-normals",
             .type = Option::Type::length,
             .default_value = "1%",
             .group = "Shape",
             .help = "how far normals are spread before creases are looked for in them"});
  add_fit_options(table, "Shape");
}

}  // namespace

Verb filter_verb() {
  OptionTable table("filter",
                    "Smooth or sharpen a texture, or colours at vertices, on the surface, across "
                    "the seams of the texture; or the shape of the surface itself.");
  table.example("scan.obj --strength 50% -o sharp.obj", "bring detail out by half");
  table.example("scan.obj --strength -100% --radius 1% -o smooth.obj", "smooth, across all seams");
  table.example("mesh.ply --geometry --strength -100% -o smooth.ply", "smooth the shape itself");
  add_model_options(table);
  add_model_output_option(table);
  add_strength_options(table);
  add_luminance_option(table);
  add_halo_option(table, "Filter");
  add_threshold_option(table);
  add_mask_options(table, "Filter");
  add_spread_options(table, {1e-3, Length::Unit::alpha}, "Filter",
                     "how far it reaches: weight of gradients on the surface scaled to unit area",
                     true);
  add_direction_options(table, "Along a field", "filter", "10");
  add_gradient_options(table, "Towards a field");
  table.exclusive({"strength", "beta"});
  table.exclusive({"radius", "alpha", "length"});
  table.exclusive({"strength", "alpha"});
  add_shape_options(table);
  add_solver_options(table);
  add_space_option(table);
  add_normals_option(table);
  add_vertices_option(table, "filter the colours at vertices, though there are textures");
  add_depth_option(table);
  table.exclusive({"normals", "vertices"});
  table.exclusive({"normal-space", "vertices"});
  table.exclusive({"normals", "luminance"});
  for (const char* name : {"space", "normal-space", "vertices", "depth", "luminance", "halo", "threshold", "field", "gradient"})
    table.exclusive({"geometry", name});
  for (const char* name : {"strength", "luminance", "halo", "threshold", "mask", "spot", "field", "normals"})
    table.exclusive({"gradient", name});
  add_frames_option(table);
  return {table, filter,
          {{.what = "smooth, sharpen"},
           {.what = "the same here and not there", .with = "--mask, --spot"},
           {.what = "along a vector field", .with = "--field"},
           {.what = "towards gradients of one's own", .with = "--gradient"},
           {.what = "shapes: positions, normals", .with = "--geometry", .textures = "", .pictures = ""}},
          {},
          Slots::several};
}

}  // namespace mq::app
