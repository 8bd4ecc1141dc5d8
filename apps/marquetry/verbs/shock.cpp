// marquetry shock IMAGE|MESH -o OUT: sharpen edges without leaving the range of values.
//
// Four kinds of input, one table of options: a picture, colours at the vertices of a model, its
// textures, and its shape (shock_geometry.h). Each is a function; the mathematics is in
// filter/shock.h and its neighbours.
#include <fmt/format.h>

#include <algorithm>

#include "mq/base/error.h"
#include "mq/baseline/osher_rudin.h"
#include "mq/filter/image_shock.h"
#include "mq/io/file_names.h"
#include "options/shock_options.h"
#include "options/signal_options.h"
#include "options/solver_options.h"
#include "shell/arguments.h"
#include "shell/results.h"
#include "shell/verb.h"
#include "verbs/shared/shock_geometry.h"
#include "verbs/shared/shock_outputs.h"

namespace mq::app {
namespace {

/// What the report says of paths.
void report_paths(Run& run, double rate, double time, const PathCounts& counts, double seconds) {
  run.result["time"] = time;
  run.result["rate"] = rate;
  run.result["paths"] = {{"count", counts.paths},
                         {"triangles_crossed", counts.triangles},
                         {"edges_slid_along", counts.edges},
                         {"at_rest", counts.resting},
                         {"cut_short", counts.cut_short}};
  run.result["relative_time"] = time * rate;
  run.result["path_seconds"] = seconds;
}

void report_solves(Run& run, const std::vector<SolveReport>& solves) {
  if (solves.empty()) return;
  run.solve = solve_json(solves.back());
  for (const SolveReport& solve : solves)
    if (!solve.converged)
      run.terminal().warning(
          "smoothing did not reach its tolerance: the field to follow is less smooth than asked "
          "for; --solver direct has no such limit");
}

void refuse_for_models(const OptionValues& options) {
  for (const char* name : {"method", "steps", "concavity"})
    require(
        !asks_for(options, name),
        fmt::format("--{} is for pictures; on a model paths follow one field, along the gradient",
                    name));
}

void refuse_without_geometry(const OptionValues& options) {
  for (const char* name : {"smooth-normals", "fit-weight", "fit-steps"})
    require(!asks_for(options, name), fmt::format("--{} is for shapes: it needs --geometry", name));
}

/// The explicit scheme takes as many steps as stability asks for, which may be more than anybody
/// waits for.
void announce_steps(Run& run, const Image<float>& image, const OsherRudinOptions& evolution) {
  const double steps = osher_rudin_steps(image, evolution);
  run.result["expected_steps"] = number_json(steps);
  const std::string about = steps < 1e7 ? fmt::format("about {:.0f} steps", steps)
                                        : fmt::format("about {:.1e} steps", steps);
  if (steps <= evolution.most_steps)
    run.terminal().remark(
        fmt::format("osher-rudin takes {} of the whole picture per channel", about));
  else
    run.terminal().warning(fmt::format(
        "osher-rudin would take {} for this time, and ends after {} unless it comes to rest "
        "before: give less --time, or take a method that follows paths, which has no steps",
        about, evolution.most_steps));
}

void refuse_for_pictures(const OptionValues& options, const std::filesystem::path& path) {
  refuse_without_geometry(options);
  const std::string way = options.text("method");
  require(way == "composed" || way == "iterated" || !asks_for(options, "steps"),
          fmt::format("--steps is for --method composed and iterated; {} has none to choose", way));
  require(options.texts("texture").empty(),
          fmt::format("{}: is a picture, so nothing is read after it; found '{}'", path.string(),
                      options.texts("texture").empty() ? "" : options.texts("texture").front()));
  for (const char* name : {"vertices", "weld", "flipped", "slot", "uv-set", "solver",
                           "tolerance"})
    require(!asks_for(options, name),
            fmt::format("{}: is a picture, and --{} is for models", path.string(), name));
}

/// Only paths along one field have one potential.
void refuse_outputs_of_other_fields(const OptionValues& options) {
  const bool one = options.text("method") == "transport" && options.text("concavity") == "along-gradient";
  for (const char* name : {"write-potential", "write-field"})
    require(one || !options.has(name),
            fmt::format("--{}: there is one for --method transport along the gradient alone", name));
}

/// `share` is of the run.
Model read_picture(Run& run, const std::filesystem::path& path, double share) {
  const Step step(run, "read", share);
  Model model = mq::read_picture(path, ImageTriangles::two, step, NotFinite::refuse,
                                 run.options().has("layer") ? run.options().text("layer") : "");
  run.will_read(path);
  for (const std::string& note : model.textures.front().notes) run.terminal().remark(note);
  run.input = picture_json(model);
  return model;
}

/// By differences, as Osher and Rudin do; `before` is what `texture` shows.
Image<float> evolved(Run& run, const Image<float>& before, const Texture& texture,
                     Concavity concavity, const Step& step) {
  using Scheme = OsherRudinOptions::Scheme;
  OsherRudinOptions evolution{
      .scheme = run.options().text("method") == "osher-rudin" ? Scheme::bounded : Scheme::as_printed,
      .time = osher_rudin_time(before, asked_time(run.options())),
      .concavity = concavity};
  // Half of what such a picture can tell apart.
  if (const double smallest = value_step(texture, value_space(run.options())); smallest > 0)
    evolution.least_change = 0.5 * smallest;
  announce_steps(run, before, evolution);
  EvolvedImage result = osher_rudin(before, evolution, step);
  run.result["steps"] = result.steps;
  if (result.left > 0)
    run.terminal().warning(
        fmt::format("stopped after {} steps with {:.0f} % of the time to go: a method that "
                    "follows paths has "
                    "no steps to run out of",
                    result.steps, 100 * result.left / evolution.time));
  run.result["time"] = evolution.time;
  const PassedExtrema passed = passed_extrema(before, result.image);
  run.result["extrema"] = {{"count", passed.extrema},
                           {"passed", passed.passed},
                           {"furthest", passed.furthest}};
  return std::move(result.image);
}

/// What is smoothed of a picture.
ShockWeights weights_of(const ShockRequest& request, const Image<float>& picture) {
  return request.weights({.area = double(picture.pixel_count()), .texel_spacing = 1});
}

/// `before` is what `texture` shows.
Image<float> sharpened(Run& run, const Image<float>& before, const Texture& texture,
                       const Step& step) {
  const OptionValues& options = run.options();
  const ShockRequest request = shock_request(options);
  const ShockWeights weights = weights_of(request, before);
  const bool laplacian = options.text("concavity") == "laplacian";
  const Concavity concavity = laplacian ? Concavity::laplacian : Concavity::along_gradient;
  const std::string method = options.text("method");
  if (method.starts_with("osher-rudin")) {
    require(weights.signal == 0 || !options.given("smooth"),
            "--smooth is for methods that follow paths; smooth the picture before");
    return evolved(run, before, texture, concavity, step);
  }
  using Method = ImageShockOptions::Method;
  ShockedImage shocked = shock(before,
                               {.method = method == "composed"   ? Method::composed
                                          : method == "iterated" ? Method::iterated
                                                                 : Method::transport,
                                .concavity = concavity,
                                .weights = weights,
                                .time = request.time,
                                .steps = int(options.integer("steps"))},
                               step);
  report_paths(run, shocked.rate, shocked.time, shocked.counts, shocked.path_seconds);
  return std::move(shocked.image);
}

Exit shock_picture(Run& run) {
  const OptionValues& options = run.options();
  const std::filesystem::path path = options.text("mesh");
  refuse_for_pictures(options, path);
  // Of one long step after the other reading takes nothing, and so no part of the time to go.
  const double beside = options.text("method") == "transport" ? 0.1 : 0.001;
  Model model = read_picture(run, path, beside);
  Texture& texture = model.textures.front();
  require(!names_model(options.text("output")),
          fmt::format("--output: found '{}', wanted a picture: what is read is one",
                      options.text("output")));
  asked_compression(options);
  const Outputs outputs(options.text("output"), model, Outputs::Kind::pictures);
  run.will_write(outputs.paths(), outputs.folders());
  refuse_outputs_of_other_fields(options);
  const ShockOutputs beside_it(run, model, ShockOutputs::At::texels, outputs.paths());
  if (run.dry_run()) return Exit::done;

  const ValueSpace values = value_space(options);
  const Image<float> before = decoded(texture, values);
  Image<float> after;
  {
    const Step step(run, "sharpen", 1 - 2 * beside);
    about(model, [&] { after = sharpened(run, before, texture, step); });
  }
  const Step step(run, "write", beside);
  if (beside_it.wanted())
    beside_it.write(run, model, shock_potential(before, weights_of(shock_request(options), before)));
  run.result["pixels_changed"] = put_changed(before, after, values, texture);
  set_depth(options, model);
  write_outputs(run, outputs, std::move(model), step);
  beside_it.report(run);
  return Exit::done;
}

Exit shock_model(Run& run) {
  const OptionValues& options = run.options();
  refuse_for_models(options);
  refuse_without_geometry(options);
  TexturedModel scene = read_usable_model(run, MissingPictures::refuse, 0.05);
  const bool vertices = at_vertices(options, scene);
  if (vertices) refuse_pictures(options);
  const Outputs outputs(options.text("output"), scene.model,
                        vertices ? Outputs::Kind::model : Outputs::Kind::pictures);
  run.will_write(outputs.paths(), outputs.folders());
  const ShockOutputs beside_it(run, scene.model, vertices ? ShockOutputs::At::vertices : ShockOutputs::At::texels,
                               outputs.paths());
  if (run.dry_run()) return Exit::done;

  std::unique_ptr<ModelSignal> target;
  {
    const Step step(run, "assemble", vertices ? 0.05 : 0.15);
    target = make_signal(run, scene, step);
  }
  const Signal before = target->values();
  ShockedModel shocked;
  about(scene.model, [&] {
    const Step step(run, "sharpen", vertices ? 0.82 : 0.77);
    shocked = shock_signal(scene, *target, before, shock_request(options), step);
  });
  report_paths(run, shocked.rate, shocked.time, shocked.counts, shocked.path_seconds);
  report_solves(run, shocked.solves);
  run.result.update(change_json(before, shocked.signal, value_space(run.options()).space));

  const Step step(run, "write", 0.05);
  if (beside_it.wanted()) beside_it.write(run, scene, *target, shocked.potential);
  target->put(before, shocked.signal, scene.model);
  set_depth(options, scene.model);
  write_outputs(run, outputs, std::move(scene.model), step);
  beside_it.report(run);
  return Exit::done;
}

Exit run_shock(Run& run) {
  const OptionValues& options = run.options();
  const std::string file = options.text("mesh");
  if (options.flag("geometry")) {
    require(!names_picture(file),
            fmt::format("{}: is a picture and has no shape; --geometry is for models: leave it out",
                        file));
    refuse_for_models(options);
    return shock_geometry(run, shock_request(options));
  }
  return names_picture(file) ? shock_picture(run) : shock_model(run);
}

/// Of time, and of what is spread before.
void add_path_options(OptionTable& table) {
  using Type = Option::Type;
  table.add({.name = "time",
             .letter = 't',
             .type = Type::number,
             .least = 0,
             .most = 1e9,
             .group = "Shock",
             .help = fmt::format("how far it goes: at 1 lines of ten texels close up, at 10 the narrowest edges are "
                                 "jumps [default {}, of shapes {}]",
                                 as_typed(ShockRequest{}.time.value), as_typed(usual_shock_time_of_shapes)),
             .details =
                 "Free of units: 1 is the time in which paths part by a factor e, in the mean "
                 "over the surface. An edge twice as wide takes about 16 times as long."});
  table.add({.name = "absolute-time",
             .type = Type::number,
             .least = 0,
             .most = 1e30,
             .group = "Shock",
             .help = "the same as the thesis states it",
             .details = "On the surface scaled to area 1, or with pixels of side 1, and values as "
                        "they are processed."});
  table.exclusive({"time", "absolute-time"});
  table.add({.name = "smooth",
             .letter = 's',
             .type = Type::length,
             .group = "Shock",
             .help = "how far values are spread before it is asked where edges are [default 1.5tx; where there are no "
                     "texels, 0.3%]",
             .details = "0.02 in model units (of a picture: pixels), 1% of sqrt(area), 8tx in "
                        "texels. What is looked up are the values as they were."});
  table.add({.name = "smooth-potential",
             .type = Type::length,
             .group = "Shock",
             .help = "how far the strength of edges is spread; more leaves fewer, larger regions [default 1.5tx; "
                     "where there are no texels, 0.3%]"});
}

void add_picture_options(OptionTable& table) {
  using Type = Option::Type;
  table.add({.name = "method",
             .type = Type::choice,
             .default_value = "transport",
             .choices = {"transport", "composed", "iterated", "osher-rudin", "osher-rudin-as-printed"},
             .metavar = "HOW",
             .group = "Pictures",
             .help = "transport, composed, iterated, osher-rudin or osher-rudin-as-printed",
             .details =
                 "transport: along one field. composed: a new field in every step, values "
                 "from the first picture. iterated: values from the step before, which blurs "
                 "them. osher-rudin: by differences, each channel alone, in as many steps as "
                 "stability asks for; nothing is spread before; no pixel passes an extremum beside it. "
                 "osher-rudin-as-printed: without that, so that some do."});
  table.add({.name = "steps",
             .type = Type::integer,
             .default_value = as_typed(ImageShockOptions{}.steps),
             .least = 1,
             .most = 100'000,
             .group = "Pictures",
             .help = "into how many the time is divided: composed and iterated"});
  table.add({.name = "concavity",
             .type = Type::choice,
             .default_value = "along-gradient",
             .choices = {"along-gradient", "laplacian"},
             .group = "Pictures",
             .help = "which second derivative says on what side of an edge a place is"});
}

/// For smoothing on models.
void add_smoothing_options(OptionTable& table) {
  using Type = Option::Type;
  table.add(
      {.name = "solver",
       .type = Type::choice,
       .default_value = "automatic",
       .choices = {"automatic", "direct", "multigrid"},
       .metavar = "HOW",
       .group = "Solver",
       .help = "for smoothing on models: automatic, direct or multigrid",
       .details = "automatic: direct up to 30,000 vertices or texels."});
  table.add({.name = "tolerance",
             .type = Type::number,
             .default_value = as_typed(ShockSolverChoice{}.tolerance),
             .least = 1e-16,
             .most = 0.1,
             .group = "Solver",
             .help = "relative residual at which iterations stop: it is of the field to follow, "
                     "not of values"});
}

}  // namespace

Verb shock_verb() {
  OptionTable table(
      "shock",
      "Sharpen a picture, colours at vertices, a texture or a shape by shock filters: "
      "steep edges, flat regions, and no value out of the range there was.");
  table.example("scan.obj -o crisp.obj", "steep edges, flat regions");
  table.example("scan.ply --geometry -o crisp.ply", "the edges of the shape itself");
  add_model_options(table, "a picture, or a model: OBJ, PLY, glTF or GLB");
  add_model_output_option(table);
  add_path_options(table);
  add_shock_output_options(table);
  add_picture_options(table);
  add_smoothing_options(table);
  add_shock_geometry_options(table);
  add_space_option(table);
  add_vertices_option(table, "colours at vertices, though there are textures");
  add_depth_option(table);
  for (const char* name : {"space", "vertices", "depth"}) table.exclusive({"geometry", name});
  add_frames_option(table);
  return {table,
          run_shock,
          {{.what = "shock filters", .textures = "yes, across seams"},
           {.what = "shapes: their edges sharpened",
            .with = "--geometry",
            .textures = "",
            .pictures = ""}},
          {},
          Slots::several};
}

}  // namespace mq::app
