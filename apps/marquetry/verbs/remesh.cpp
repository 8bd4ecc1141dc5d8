// marquetry remesh TEMPLATE TARGET -o OUT: replace a mesh by another one, but only where it cannot
// show it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <span>
#include <utility>

#include "mq/base/error.h"
#include "mq/base/length.h"
#include "mq/base/words.h"
#include "mq/io/atomic_file.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/orient.h"
#include "mq/mesh/soundness.h"
#include "mq/remesh/remesh.h"
#include "mq/remesh/texture.h"
#include "shell/arguments.h"
#include "shell/results.h"
#include "options/model_options.h"
#include "shell/verb.h"

namespace mq::app {
namespace {

const ReadModelOptions shape_alone{.textures = {}, .pictures = ReadModelOptions::Pictures::skip};

bool wants_textures(const OptionValues& options) {
  return !options.flag("no-textures") && !options.flag("paint");
}

struct Side {
  Model model;
  Surface surface;
};

/// What of a target faces the wrong way is turned back.
void turn_back(Model& target, const Mesh& of_template) {
  Oriented found = oriented_like(target.mesh, of_template);
  target.mesh = std::move(found.mesh);
  std::ranges::move(found.defects, std::back_inserter(target.defects));
}

/// A model, its defects in the report. `before`: the template, where this is the target.
Side read_side(Run& run, const std::string& option, double share, const Mesh* before = nullptr) {
  Side side;
  const Step step(run, "read", share);
  side.model = read_model(run.options().text(option),
                          wants_textures(run.options()) ? ReadModelOptions{} : shape_alone, step);
  const std::string file = side.model.path.string();
  run.will_read(side.model.path);
  for (const std::string& note : side.model.notes) run.terminal().remark(file + ": " + note);
  require(side.model.mesh.triangle_count() > 0,
          fmt::format("{}: has {} and no faces, so no surface: check that it is a mesh, not a "
                      "point cloud or curves, and not cut short",
                      file, counted(side.model.mesh.vertex_count(), "vertex")));
  about(side.model, [&] {
    if (before != nullptr) turn_back(side.model, *before);
    side.surface = make_surface(side.model.mesh);
  });
  require(
      side.surface.area > 0,
      fmt::format("{}: none of its triangles has an area, so it is no surface: check that it is "
                  "a mesh, and not cut short",
                  file));
  Defects defects = side.model.defects;
  defects.insert(defects.end(), side.surface.defects.begin(), side.surface.defects.end());
  run.found(defects);
  for (const Defect& defect : defects)
    if (defect.severity == Defect::Severity::warning)
      run.terminal().warning(file + ": " + sentence(defect));
  require_usable(defects, file);
  run.input[option] = {{"file", file},
                       {"vertices", side.model.mesh.vertex_count()},
                       {"triangles", side.model.mesh.triangle_count()},
                       {"components", side.surface.components},
                       {"boundary_edges", side.surface.boundary_edges}};
  return side;
}

/// Corners of the template's triangles at their birth.
std::vector<std::array<Vector3, 3>> read_rest(Run& run, const Side& side) {
  if (!run.options().has("reference")) return {};
  const std::string file = run.options().text("reference");
  const Model rest = read_model(file, shape_alone);
  run.will_read(rest.path);
  require(rest.mesh.triangles == side.model.mesh.triangles &&
              rest.mesh.vertex_count() == side.model.mesh.vertex_count(),
          fmt::format("{}: has other triangles than {}, wanted the same mesh as it was when its "
                      "triangles were made",
                      file, side.model.path.string()));
  return corner_positions(rest.mesh);
}

/// Colours of what was kept and of what was born, where both models have the same channels.
VertexSignal colours(Run& run, const Side& of_template, const Side& target,
                     const Remeshed& remeshed) {
  const VertexSignal &old = of_template.model.colors, &fresh = target.model.colors;
  if (old.channels == 0 && fresh.channels == 0) return {};
  if (old.channels != fresh.channels) {
    run.terminal().remark(fmt::format("colours at vertices are left out: {} has {}, {} has {}",
                                      of_template.model.path.string(),
                                      counted(old.channels, "channel"), target.model.path.string(),
                                      counted(fresh.channels, "channel")));
    return {};
  }
  VertexSignal colours{old.channels, {}, std::max(old.depth, fresh.depth)};
  for (const VertexOrigin& origin : remeshed.origins) {
    const Side& side = origin.of_target ? target : of_template;
    for (int c = 0; c < old.channels; ++c) {
      double sum = 0;
      for (int k = 0; k < 3; ++k) {
        const int v = side.surface.mesh.triangles[std::size_t(origin.triangle)][std::size_t(k)];
        const int source = side.surface.source_from_vertex[std::size_t(v)];
        if (origin.barycentric[k] != 0)
          sum += origin.barycentric[k] *
                 double(side.model.colors.values[std::size_t(source * old.channels + c)]);
      }
      colours.values.push_back(float(sum));
    }
  }
  return colours;
}

/// What goes with the result: the template's pictures, then the target's, each under a name of its
/// own. Of a picture that both have there are two.
std::vector<Texture> pictures(const Side& of_template, const Side& target) {
  std::vector<Texture> all = of_template.model.textures;
  for (const Texture& texture : target.model.textures) {
    all.push_back(texture);
    const std::filesystem::path name = texture.name;
    for (int copy = 1; std::ranges::count(all, all.back().name, &Texture::name) > 1; ++copy)
      all.back().name =
          fmt::format("{}_target{}{}", name.stem().string(), copy > 1 ? std::to_string(copy) : "",
                      name.extension().string());
  }
  return all;
}

/// Kept triangles grey, those that were born orange.
VertexSignal painted(const Remeshed& remeshed) {
  VertexSignal colours{3, {}, Depth::u8};
  std::vector<char> kept(remeshed.mesh.positions.size(), 0);
  for (int t = 0; t < remeshed.mesh.triangle_count(); ++t)
    if (remeshed.template_triangles[std::size_t(t)] >= 0)
      for (const int v : remeshed.mesh.triangles[std::size_t(t)]) kept[std::size_t(v)] = 1;
  for (const char k : kept)
    for (const float value : k ? std::array{0.72F, 0.72F, 0.72F} : std::array{0.93F, 0.45F, 0.1F})
      colours.values.push_back(value);
  return colours;
}

Json distance_json(const DistanceSummary& distance, double diagonal) {
  return {{"mean", distance.mean / diagonal},
          {"p95", distance.p95 / diagonal},
          {"max", distance.max / diagonal}};
}

/// Of what a warning is worth.
constexpr double far_in_tolerances = 1.5;

void report(Run& run, const Side& of_template, const Side& target, const Remeshed& found) {
  const double all = std::max(1, of_template.surface.triangle_count());
  const double diagonal = bounding_box(target.surface.mesh).diagonal();
  Json& result = run.result;
  result["triangles"] = found.mesh.triangle_count();
  result["triangles_kept"] = {{"count", found.kept}, {"fraction", found.kept / all}};
  result["triangles_born"] = found.added;
  result["triangles_died"] = found.removed;
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
  run.print(fmt::format("kept {} of {} triangles ({:.2f} %), {} born, {} died, in {}\n", found.kept,
                        of_template.surface.triangle_count(), 100 * found.kept / all, found.added,
                        found.removed, counted(found.regions, "region")));
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

Exit run_remesh(Run& run) {
  const OptionValues& options = run.options();
  const Side of_template = read_side(run, "template", 0.1);
  const Side target = read_side(run, "target", 0.1, &of_template.model.mesh);
  const std::vector<std::array<Vector3, 3>> rest = read_rest(run, of_template);
  Model model;
  model.path = of_template.model.path;
  const bool has_uvs =
      wants_textures(options) && (of_template.model.mesh.has_uvs() || target.model.mesh.has_uvs());
  if (has_uvs) model.textures = pictures(of_template, target);
  const Outputs outputs(options.text("output"), model,
                        model.textures.empty() ? Outputs::Kind::model : Outputs::Kind::pictures);
  std::vector<std::filesystem::path> paths = outputs.paths();
  if (options.has("record")) paths.emplace_back(options.text("record"));
  run.will_write(paths);
  if (run.dry_run()) return Exit::done;

  Remeshed found;
  {
    const Step step(run, "remesh", 0.7);
    RemeshOptions how = asked(options, of_template.surface);
    how.rest = rest;
    about(of_template.model,
          [&] { found = remesh(of_template.surface, target.surface, how, step); });
  }
  report(run, of_template, target, found);
  for (const Side* side : {&of_template, &target})
    if (has_uvs && !side->model.mesh.has_uvs())
      run.terminal().remark(side->model.path.string() +
                            ": has no texture coordinates, nor has what comes from it");

  const Step step(run, "write", 0.1);
  model.colors = options.flag("paint") ? painted(found) : colours(run, of_template, target, found);
  if (options.has("record")) write_record(options.text("record"), found);
  model.mesh = has_uvs ? textured(found, of_template.surface.mesh, target.surface.mesh,
                                  int(of_template.model.textures.size()))
                       : std::move(found.mesh);
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
  table.add({.name = "occlusion",
             .type = Type::number,
             .default_value = as_typed(RemeshOptions{}.occlusion),
             .least = 0,
             .most = 1,
             .group = "Remesh",
             .help = "how much less distance counts in hidden places, such as creases and contacts"});
  table.add({.name = "curvature",
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
  OptionTable table("remesh",
                    "Replace a part of a mesh by another mesh, where it deviates beyond a tolerance: "
                    "the rest keeps its triangles.");
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
  add_remesh_options(table);
  return {table, run_remesh};
}

}  // namespace mq::app
