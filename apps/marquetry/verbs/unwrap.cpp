// marquetry unwrap MESH -o OUT: a texture atlas for a mesh that has none, or a better one; for an
// evolving mesh see unwrap_evolving.h.
//
// The report's figures are those of the new atlas, with distortion measured as in the thesis
// (5.8.4) on the surface scaled to the area of the atlas. Percentiles weigh triangles by their area
// on the surface.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <set>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/model/unwrapped_model.h"
#include "options/model_options.h"
#include "options/signal_options.h"
#include "shell/arguments.h"
#include "shell/percentiles.h"
#include "shell/results.h"
#include "shell/run.h"
#include "shell/verb.h"
#include "verbs/shared/baking.h"
#include "verbs/shared/geometry.h"
#include "verbs/shared/render_request.h"
#include "verbs/shared/unwrap_evolving.h"

namespace mq::app {
namespace {

UnwrapOptions asked_unwrap(const OptionValues& options) {
  UnwrapOptions wanted = asked_atlas(options);
  wanted.largest = options.number("largest") / 100;
  return wanted;
}

void report(Run& run, const UnwrapFigures& figures, std::int64_t overlaps) {
  std::vector<Weighted> ratio, conformal, authalic;
  for (const TriangleStretch& t : figures.stretch.triangles) {
    ratio.push_back({t.ratio, t.area});
    conformal.push_back({t.conformal, t.area});
    authalic.push_back({t.authalic, t.area});
  }
  run.result = {{"charts", figures.charts},
                {"flipped", figures.stretch.flipped},
                {"overlapping_charts", figures.overlapping},
                {"overlapping_texels", overlaps},
                {"occupancy", figures.stretch.occupancy},
                {"stretch", figures.stretch.l2_stretch},
                {"seam_length", figures.seam_length},
                {"ratio", percentiles_json(ratio)},
                {"conformal", percentiles_json(conformal)},
                {"authalic", percentiles_json(authalic)}};
  run.print(
      fmt::format("{}, {:.1f} % of the texture, L2 stretch {:.4f}\n"
                  "ratio of singular values: {}\n",
                  counted(figures.charts, "chart"), 100 * figures.stretch.occupancy,
                  figures.stretch.l2_stretch, percentiles_text(run.result["ratio"])));
}

/// Pictures lie by the texture coordinates that go.
void leave_pictures_behind(Run& run, Model& model) {
  std::set<std::string> names;
  for (const MaterialSlot& slot : model.slots)
    for (const MaterialSlot::Use& use : slot.pictures) names.insert(use.picture);
  if (!names.empty())
    run.terminal().remark(fmt::format(
        "without {}, which {} by the old texture coordinates: --bake brings {} over", fmt::join(names, ", "),
        names.size() == 1 ? "lies" : "lie", names.size() == 1 ? "it" : "them"));
  forget_textures(model);
  model.slots.clear();
  model.others.clear();
}

/// What the model showed, on its new texture coordinates.
void bake_what_was_there(Run& run, const std::vector<std::string>& slots, TexturedModel& source,
                         TexturedModel& scene) {
  const std::vector<SharedSlot> shared = shared_slots(source.model, slots);
  const OptionValues& options = run.options();
  const LoadOptions load{.weld = asked_weld(options),
                         .missing = MissingPictures::assume,
                         .side = int(options.integer("size"))};
  const SourceOfSlot source_of = [&](const std::string& slot) {
    return slots.empty() || slot == source.model.slot
               ? std::move(source)
               : load_textured_model(options.text("mesh"),
                                     {.weld = load.weld,
                                      .slot = slot,
                                      .layer = options.has("layer") ? options.text("layer") : ""},
                                     run.terminal());
  };
  bake_unwrapped(run, slots, shared, source_of, load, scene, 0.3);
}

Exit unwrap(Run& run) {
  const OptionValues& options = run.options();
  require_picture_name(options, "picture");
  if (names_evolving(options.text("mesh"))) {
    require(!options.flag("bake"),
            "--bake: it is for a mesh; textures of an evolving mesh are made by export --from");
    require(!asks_for(options, "compress"), "--compress: it is for a mesh; .evolving has its own");
    require(!asks_for(options, "largest"),
            "--largest: it is for a mesh; an evolving mesh has --coherence");
    return unwrap_evolving(run);
  }
  require(!options.has("picture"),
          "--picture: it is for an evolving mesh; draw a model with the verb render");
  for (const char* name : {"coherence", "look-ahead", "uv-error", "renew", "view"})
    require(!asks_for(options, name),
            fmt::format("--{}: it is for an evolving mesh, whose frames come one after the other",
                        name));
  const bool bakes = options.flag("bake");
  for (const char* name : {"flipped", "slot", "uv-set", "layer", "normal-space"})
    require(bakes || !asks_for(options, name),
            fmt::format("--{} is of textures, which are looked at with --bake alone: give it too", name));
  TexturedModel scene = bakes ? read_usable_model(run, MissingPictures::unneeded, 0.06)
                              : read_shape(run, 0.06);
  if (!bakes) leave_pictures_behind(run, scene.model);
  const std::vector<std::string> slots =
      bakes ? slots_to_bake(options, scene.model) : std::vector<std::string>();
  const Outputs outputs =
      bakes ? unwrapped_outputs(options, scene.model, slots, shared_slots(scene.model, slots)) : shape_outputs(options, scene);
  run.will_write(outputs.paths(), outputs.folders());
  if (run.dry_run()) return Exit::done;
  const UnwrapOptions wanted = asked_unwrap(options);
  Unwrapped unwrapped;
  about(scene.model, [&] {
    const Step step(run, "unwrap", bakes ? 0.5 : 0.9);
    unwrapped = mq::unwrap(scene.surface, wanted, step);
  });
  for (const UnwrapFigures::Seconds& seconds : unwrapped.figures.seconds)
    run.add_seconds(seconds.step, seconds.seconds);
  TexturedModel source;
  if (bakes) {  // of pictures there is one copy: the target gets others
    std::vector<Texture> textures = std::move(scene.model.textures);
    source = scene;
    source.model.textures = std::move(textures);
  }
  put_unwrapped(unwrapped, scene);
  std::int64_t overlaps = 0;
  {
    const Step step(run, "check", 0.02);
    overlaps = overlapping_texels(scene, {wanted.width, wanted.height}, step);
  }
  report(run, unwrapped.figures, overlaps);
  if (bakes) bake_what_was_there(run, slots, source, scene);
  const Step step(run, "write", 0.02);
  write_outputs(run, outputs, std::move(scene.model), step);
  return Exit::done;
}

}  // namespace

Verb unwrap_verb() {
  OptionTable table("unwrap",
                    "Cut a mesh into few charts of little stretch, flatten them and pack them.");
  table.example("scan.ply -o scan.obj --size 4096", "texture coordinates for a mesh");
  table.example("scan.obj --bake -o again.obj", "new ones, with the pictures brought over");
  add_model_options(table,
                    "the model: OBJ, PLY, glTF or GLB, or an evolving mesh as track makes it; "
                    "texture coordinates it has are replaced");
  table.add({.name = "output",
             .letter = 'o',
             .type = Option::Type::path,
             .required = true,
             .metavar = "OUT",
             .help = "the model with its new texture coordinates (.obj, .ply, .gltf or .glb; or "
                     ".evolving)"});
  add_compress_option(table);
  add_atlas_options(table);
  table.add({.name = "largest",
             .type = Option::Type::number,
             .default_value = as_typed(100 * UnwrapOptions{}.largest),
             .unit = "% of the area",
             .least = 0.1,
             .most = 100,
             .group = "Atlas",
             .help = "the most that a chart of a mesh may have",
             .details = "Large ones leave gaps that nothing fits; 100: as few charts as --stretch "
                        "allows."});
  table.add({.name = "bake",
             .group = "Atlas",
             .help = "give a mesh textures that show on it what the old ones did",
             .details = "As the verb bake does, with its defaults, all slots; --size is their side."});
  add_normal_space_option(table, "Green stays as it is, but glTF gets it up.");
  add_evolving_atlas_options(table);
  add_frames_option(table);
  return {table, unwrap, {}, {}, Slots::its_own};
}

}  // namespace mq::app
