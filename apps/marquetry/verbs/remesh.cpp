// marquetry remesh TEMPLATE TARGET -o OUT: replace a mesh by another one, but only where it cannot
// show it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <span>

#include "mq/base/error.h"
#include "mq/base/length.h"
#include "mq/base/words.h"
#include "mq/io/atomic_file.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/soundness.h"
#include "mq/model/remeshed_model.h"
#include "mq/model/unwrapped_model.h"
#include "options/model_options.h"
#include "options/signal_options.h"
#include "shell/arguments.h"
#include "shell/results.h"
#include "shell/verb.h"
#include "verbs/shared/baking.h"
#include "verbs/shared/unwrap_evolving.h"

namespace mq::app {
namespace {

const ReadModelOptions shape_alone{.textures = {}, .pictures = ReadModelOptions::Pictures::skip};

RemeshedContents asked_contents(const OptionValues& options) {
  using Textures = RemeshedContents::Textures;
  using Colours = RemeshedContents::Colours;
  const bool painted = options.flag("paint");
  return {
      .textures = painted || options.flag("no-textures") ? Textures::left_out : Textures::carried,
      .colours = painted ? Colours::origin : Colours::carried};
}

/// A model, its defects in the report. `of_template`: its mesh, where this is the target.
RemeshInput read_side(Run& run, const std::string& option, const Mesh* of_template = nullptr) {
  const Step step(run, "read", 0.1);
  const bool with_textures =
      asked_contents(run.options()).textures == RemeshedContents::Textures::carried;
  Model model = read_model(run.options().text(option),
                           with_textures ? ReadModelOptions{} : shape_alone, step);
  run.will_read(model.path);
  RemeshInput side = remesh_input(std::move(model), run.terminal(), of_template);
  const std::string file = side.model.path.string();
  const Defects defects = side.defects();
  run.found(defects);
  for (const Defect& defect : defects)
    if (defect.severity == Defect::Severity::warning) {
      run.terminal().warning(file + ": " + short_sentence(defect));
      run.terminal().point_to_check(file);
    }
  require_usable(defects, file);
  run.input[option] = {{"file", file},
                       {"vertices", side.model.mesh.vertex_count()},
                       {"triangles", side.model.mesh.triangle_count()},
                       {"components", side.surface.components},
                       {"boundary_edges", side.surface.boundary_edges}};
  return side;
}

/// Corners of the template's triangles at rest.
std::vector<std::array<Vector3, 3>> read_rest(Run& run, const RemeshInput& of_template) {
  if (!run.options().has("reference")) return {};
  const Model rest_shape = read_model(run.options().text("reference"), shape_alone);
  run.will_read(rest_shape.path);
  return rest_corners(of_template, rest_shape);
}

Json distance_json(const DistanceSummary& distance, double diagonal) {
  return {{"mean", distance.mean / diagonal},
          {"p95", distance.p95 / diagonal},
          {"max", distance.max / diagonal}};
}

/// Of what a warning is worth.
constexpr double far_in_tolerances = 1.5;

void report(Run& run, const RemeshInput& of_template, const RemeshInput& target,
            const Remeshed& found) {
  const double all = std::max(1, of_template.surface.triangle_count());
  const double diagonal = bounding_box(target.surface.mesh).diagonal();
  Json& result = run.result;
  result["triangles"] = found.mesh.triangle_count();
  result["triangles_kept"] = {{"count", found.kept}, {"fraction", found.kept / all}};
  result["triangles_born"] = found.added;
  result["triangles_died"] = found.removed;
  result["triangles_added"] = found.added;  // the two above by their usual names
  result["triangles_removed"] = found.removed;
  const Surface surface = make_surface(found.mesh, {WeldOptions::Kind::none});
  result["manifold"] = is_manifold(surface);
  result["manifold_inputs"] = {{"template", is_manifold(of_template.surface)},
                               {"target", is_manifold(target.surface)}};
  const auto folded = [](const Surface& of) { return folded_triangles(of).size(); };
  result["folded"] = folded(surface);
  result["folded_inputs"] = {{"template", folded(of_template.surface)},
                             {"target", folded(target.surface)}};
  result["seeds"] = {{"template", found.template_seeds}, {"target", found.target_seeds}};
  result["regions"] = found.regions;
  result["components_replaced"] = found.replaced_components;
  result["rounds"] = found.rounds;
  result["tolerance"] = found.tolerance;
  result["diagonal"] = diagonal;
  result["to_target"] = distance_json(found.to_target, diagonal);
  result["from_target"] = distance_json(found.from_target, diagonal);
  Json seconds = Json::object();
  for (const auto& [step, time] : found.seconds) seconds[step] = time;
  result["seconds"] = seconds;
  run.print(fmt::format("kept {} of {} triangles ({:.2f} %), {} added, {} removed, in {}\n",
                        found.kept, of_template.surface.triangle_count(), 100 * found.kept / all,
                        found.added, found.removed, counted(found.regions, "region")));
  run.print(fmt::format(
      "distance, of the diagonal: to the target {:.2g} (largest {:.2g}), from it {:.2g} ({:.2g})\n",
      found.to_target.mean / diagonal, found.to_target.max / diagonal,
      found.from_target.mean / diagonal, found.from_target.max / diagonal));
  const double far = std::max(found.to_target.max, found.from_target.max);
  if (far > far_in_tolerances * found.tolerance)
    run.terminal().warning(fmt::format(
        "the farthest points of both are {:.2g} % of the diagonal apart, {:.2g} tolerances: what "
        "is "
        "hidden counts less; --occlusion 0 counts it like the rest, a smaller --tolerance all more",
        100 * far / diagonal, far / found.tolerance));
  if (found.replaced_components > 0)
    run.terminal().remark(fmt::format("replaced as a whole: {} of the template",
                                      counted(found.replaced_components, "component")));
}

/// Where every triangle and vertex comes from, as a file.
void write_record(const std::string& path, const Remeshed& found) {
  const Json json = {{"template_triangles", found.template_triangles},
                     {"target_triangles", found.target_triangles},
                     {"template_vertices", found.template_vertices},
                     {"target_vertices", found.target_vertices}};
  const std::string text = json.dump() + "\n";
  write_file(path, std::as_bytes(std::span(text.data(), text.size())));
}

RemeshOptions asked(const OptionValues& options, const Surface& of_template) {
  RemeshOptions how{.keep = options.number("keep"),
                    .occlusion = options.number("occlusion"),
                    .curvature = options.number("curvature"),
                    .growth = options.number("growth")};
  if (!options.has("tolerance")) return how;
  const Length length = parse_length(options.text("tolerance"));
  how.tolerance = std::sqrt(weight_from_length(length, {.area = of_template.area}));
  require(how.tolerance > 0, "--tolerance: must be above 0");
  return how;
}

void refuse_idle_options(const OptionValues& options, const RemeshedContents& contents) {
  if (options.flag("bake")) {
    require(contents.textures == RemeshedContents::Textures::carried,
            "--bake: there is nothing to bake with --no-textures or --paint: leave one out");
    return;
  }
  for (const char* name : {"size", "gutter", "stretch", "trials", "normal-space"})
    require(!asks_for(options, name),
            fmt::format("--{}: is of the textures that --bake makes: give it too", name));
}

/// The slots to bake, for an output of that format.
std::vector<std::string> slots_to_remesh(const OptionValues& options,
                                         const RemeshInput& of_template,
                                         const RemeshInput& target) {
  std::vector<std::string> slots = slots_of_both(of_template, target);
  require(!slots.empty(),
          "--bake: neither mesh has textures, so there is nothing to bake: leave it out");
  if (std::filesystem::path(options.text("output")).extension() == ".ply") slots.resize(1);
  return slots;
}

/// The remeshed model with the pictures that both have for a slot.
using ModelOfSlot = std::function<Model(const std::string& slot)>;

/// New texture coordinates, and for each slot one texture with what those of both meshes showed.
Model unwrap_and_bake(Run& run, const std::vector<std::string>& slots, const ModelOfSlot& shown) {
  const OptionValues& options = run.options();
  const LoadOptions load{.missing = MissingPictures::assume, .side = int(options.integer("size"))};
  const auto source_of = [&](const std::string& slot) {
    return textured_model(shown(slot), {.missing = MissingPictures::unneeded}, run.terminal());
  };
  TexturedModel source = source_of(slots.front());
  TexturedModel scene = source;
  Unwrapped unwrapped;
  about(scene.model, [&] {
    const Step step(run, "unwrap", 0.2);
    unwrapped = unwrap(scene.surface, asked_atlas(options), step);
  });
  put_unwrapped(unwrapped, scene);
  run.result["charts"] = unwrapped.figures.charts;
  const SourceOfSlot source_once = [&](const std::string& slot) {
    return slot == slots.front() ? std::move(source) : source_of(slot);
  };
  bake_unwrapped(run, slots, {}, source_once, load, scene, 0.2);
  return std::move(scene.model);
}

Exit run_remesh(Run& run) {
  const OptionValues& options = run.options();
  const RemeshedContents contents = asked_contents(options);
  refuse_idle_options(options, contents);
  const bool bakes = options.flag("bake");
  const RemeshInput of_template = read_side(run, "template");
  const RemeshInput target = read_side(run, "target", &of_template.model.mesh);
  const std::vector<std::array<Vector3, 3>> rest = read_rest(run, of_template);
  const std::vector<std::string> slots =
      bakes ? slots_to_remesh(options, of_template, target) : std::vector<std::string>();
  Model model;
  model.path = of_template.model.path;
  if (!bakes) model = begin_remeshed(of_template, target, contents);
  model.compression = asked_compression(options);
  const Outputs outputs =
      bakes ? unwrapped_outputs(options, model, slots)
            : Outputs(options.text("output"), model,
                      model.textures.empty() ? Outputs::Kind::model : Outputs::Kind::pictures);
  std::vector<std::filesystem::path> paths = outputs.paths();
  if (options.has("record")) paths.emplace_back(options.text("record"));
  run.will_write(paths);
  if (run.dry_run()) return Exit::done;

  Remeshed found;
  {
    const Step step(run, "remesh", bakes ? 0.3 : 0.7);
    RemeshOptions how = asked(options, of_template.surface);
    how.rest = rest;
    about(of_template.model,
          [&] { found = remesh(of_template.surface, target.surface, how, step); });
  }
  report(run, of_template, target, found);

  if (options.has("record")) write_record(options.text("record"), found);
  if (bakes)
    model = unwrap_and_bake(run, slots, [&](const std::string& slot) {
      RemeshInput old = with_slot(of_template, slot);
      RemeshInput fresh = with_slot(target, slot, &of_template.model.mesh);
      for (RemeshInput* side : {&old, &fresh}) side->model.others.clear();  // all slots are baked
      Model one = begin_remeshed(old, fresh, contents);
      one.compression = model.compression;
      finish_remeshed(old, fresh, found, contents, run.terminal(), one);
      return one;
    });
  else
    finish_remeshed(of_template, target, std::move(found), contents, run.terminal(), model);
  const Step step(run, "write", 0.1);
  for (const std::string& note : outputs.write(std::move(model), step)) run.terminal().remark(note);
  say_written(run, paths);
  return Exit::done;
}

void add_remesh_options(OptionTable& table) {
  using Type = Option::Type;
  table.add(
      {.name = "tolerance",
       .letter = 't',
       .type = Type::length,
       .accepts =
           [](const std::string& text) { return parse_length(text).unit != Length::Unit::texels; },
       .wanted = "a length such as 0.02 (model units) or 1% (of the square root of the area)",
       .group = "Remesh",
       .help = "how far open, flat surfaces may be apart: 0.02 in model units, 1% of "
               "sqrt(area)",
       .details = "By default two mean edges of the finer of the two meshes."});
  table.add({.name = "keep",
             .type = Type::number,
             .default_value = as_typed(RemeshOptions{}.keep),
             .least = 0,
             .most = 1,
             .group = "Remesh",
             .help = "neighbours of a replaced part go too from this share of the tolerance on"});
  table.add(
      {.name = "occlusion",
       .type = Type::number,
       .default_value = as_typed(RemeshOptions{}.occlusion),
       .least = 0,
       .most = 1,
       .group = "Remesh",
       .help = "how much less distance counts in hidden places, such as creases and contacts"});
  table.add(
      {.name = "curvature",
       .type = Type::number,
       .default_value = as_typed(RemeshOptions{}.curvature),
       .least = 0,
       .most = 100,
       .group = "Remesh",
       .help = "how much more distance counts where a mesh is bent, such as at ridges and tips"});
  table.add({.name = "growth",
             .type = Type::number,
             .default_value = as_typed(RemeshOptions{}.growth),
             .least = 0,
             .most = 1,
             .group = "Remesh",
             .help = "share of a component that may be replaced beyond what has to be",
             .details = "Where curves cannot be stitched within it, the component is replaced as "
                        "a whole."});
  table.add({.name = "reference",
             .type = Type::path,
             .group = "Remesh",
             .help = "the template as it was when its triangles were made",
             .details = "Those stretched or scaled by more than 3 since are replaced as well."});
  table.add({.name = "record",
             .type = Type::text,
             .metavar = "FILE",
             .group = "Output",
             .help = "write where every triangle and vertex comes from, as JSON",
             .details = "Per triangle and vertex its number in the template and in the target, "
                        "-1 where it is not of it."});
  table.add(
      {.name = "bake",
       .type = Type::flag,
       .group = "Atlas",
       .help = "new texture coordinates, and a texture per slot that shows what those of both did",
       .details = "As unwrap --bake."});
  add_atlas_options(table);
  add_normal_space_option(table, "Green stays as it is, but glTF gets it up.");
  table.add({.name = "no-textures",
             .type = Type::flag,
             .group = "Output",
             .help = "leave texture coordinates and pictures out, and do not read them"});
  table.add({.name = "paint",
             .type = Type::flag,
             .group = "Output",
             .help = "colours at vertices: orange where triangles were added, grey elsewhere"});
}

}  // namespace

Verb remesh_verb() {
  using Type = Option::Type;
  constexpr auto positional = Option::Place::positional;
  OptionTable table(
      "remesh",
      "Replace a part of a mesh by another mesh, where it deviates beyond a tolerance: "
      "the rest keeps its triangles.");
  table.example("tracked.ply scan.ply -o next.ply", "a mesh, replaced where it deviates from another");
  table.add({.name = "template",
             .place = positional,
             .type = Type::path,
             .required = true,
             .help = "the mesh to keep: OBJ, PLY, glTF or GLB"});
  table.add({.name = "target",
             .place = positional,
             .type = Type::path,
             .required = true,
             .help = "the mesh to show"});
  table.add({.name = "output",
             .letter = 'o',
             .type = Type::path,
             .required = true,
             .metavar = "OUT",
             .help = "the remeshed model: .ply, .obj, .gltf or .glb"});
  add_compress_option(table);
  add_remesh_options(table);
  return {table, run_remesh};
}

}  // namespace mq::app
