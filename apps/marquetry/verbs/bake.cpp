// marquetry bake SOURCE TARGET -o OUT: the colours of one model on the charts, or at the vertices,
// of another.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "mq/base/error.h"
#include "mq/io/file_names.h"
#include "mq/io/slots.h"
#include "mq/model/baked_signal.h"
#include "mq/model/joined_slots.h"
#include "mq/model/outputs.h"
#include "options/model_options.h"
#include "options/signal_options.h"
#include "options/solver_options.h"
#include "shell/arguments.h"
#include "shell/results.h"
#include "shell/verb.h"
#include "verbs/shared/baking.h"

namespace mq::app {
namespace {

/// Factors that the source's materials have alike can stay in one material of the target; others go into
/// the pictures.
BakeOptions asked_bake(const OptionValues& options, const Model& source) {
  BakeOptions asked{.within = options.number("within") / 100,
                    .angle = options.number("angle"),
                    .samples = options.has("samples") ? int(options.integer("samples")) : 0,
                    .values = value_space(options)};
  asked.values.meaning = ValueSpace::Meaning::colours;  // which slots hold normals is known
  asked.factors = factors_for_one(source);
  return asked;
}

bool has_pictures_of_its_own(const Model& model) {
  return std::ranges::any_of(model.textures,
                             [](const Texture& texture) { return !texture.pixels.empty(); });
}

bool has_slots(const Model& model, const std::vector<std::string>& slots) {
  return std::ranges::all_of(slots, [&](const std::string& slot) {
    return std::ranges::count(model.slots, slot, &MaterialSlot::name) > 0;
  });
}

/// What of the source is baked.
struct Asked {
  std::vector<std::string> slots;
  BakeOptions::Shown shown = BakeOptions::Shown::pictures;
};

const ReadModelOptions shape_and_slots{.textures = {},
                                       .pictures = ReadModelOptions::Pictures::skip};

/// Whether pictures are given for a slot for which the source's materials name none.
bool gives_a_new_slot(const OptionValues& options, const std::string& slot) {
  if (slot.empty() || options.texts("texture").empty()) return false;
  const Model source = read_model(options.text("source"), shape_and_slots);
  if (std::ranges::count(source.slots, slot, &MaterialSlot::name) > 0) return false;
  known_slot(slot, source.path.string());
  return true;
}

/// Gives the pictures the meaning that they have in a slot.
void take_as(const std::string& slot, Model& model) {
  for (Texture& texture : model.textures) {
    texture.meaning = meaning_of_slot(slot);
    if (texture.meaning == TextureMeaning::normals && texture.pixels.channels() < 3)
      texture.meaning = TextureMeaning::values;
  }
}

TexturedModel read_source(Run& run, const std::string& slot, BakeOptions::Shown shown) {
  const OptionValues& options = run.options();
  const bool has_pictures = shown == BakeOptions::Shown::pictures;
  const bool is_new = has_pictures && gives_a_new_slot(options, slot);
  LoadOptions load;
  for (const std::string& name : options.texts("texture")) load.textures.emplace_back(name);
  Model read;
  {
    const Step step(run, "read source", 0.05);
    read = read_model(options.text("source"),
                      {.textures = load.textures,
                       .pictures = has_pictures ? ReadModelOptions::Pictures::read
                                                : ReadModelOptions::Pictures::skip,
                       .not_finite = NotFinite::keep,
                       .slot = has_pictures && !is_new ? slot : "",
                       .layer = options.has("layer") ? options.text("layer") : ""},
                      step);
  }
  will_read_model(run, read);
  if (is_new) take_as(slot, read);
  load.missing =
      has_pictures_of_its_own(read) ? MissingPictures::assume : MissingPictures::unneeded;
  const Step step(run, "find its charts", 0.05);
  return textured_model(std::move(read), load, run.terminal(), step);
}

/// Whether normals are asked for of a source that has no normal map: then they are those of its
/// shape.
bool asks_for_shape(const OptionValues& options, const Model& source) {
  return options.has("slot") && slot_from_text(options.text("slot")) == "normal" &&
         std::ranges::none_of(source.slots, [](const MaterialSlot& slot) {
           return slot.name == "normal" || slot.name == "bump";
         });
}

/// Slots of the source that are baked; those of pictures named for it are theirs.
Asked asked_slots(Run& run, BakeTo to) {
  const OptionValues& options = run.options();
  const std::string file = options.text("source");
  if (names_picture(file) || !options.texts("texture").empty()) {
    const bool are_normals = normal_axes(options) != NormalAxes::as_found;
    if (!options.has("slot") && !are_normals) return {};
    return {{options.has("slot") ? slot_from_text(options.text("slot")) : "normal"}};
  }
  const Model source = read_model(file, shape_and_slots);
  if (asks_for_shape(options, source)) {
    run.terminal().remark(fmt::format(
        "{}: has no normal map: the shading normals of its shape are baked as one", file));
    return {{"normal"}, BakeOptions::Shown::shading_normals};
  }
  std::vector<std::string> slots = slots_to_bake(options, source);
  if (to == BakeTo::vertices && !options.has("slot") && slots.size() > 1) slots.resize(1);
  return {std::move(slots)};
}

/// As many texels as the source's largest picture has, both ways. One slot that the target has too is
/// replaced there.
TargetTextures asked_textures(Run& run, const Model& source, const std::vector<std::string>& slots) {
  const OptionValues& options = run.options();
  TargetTextures target;
  if (options.has("size")) target.side = int(options.integer("size"));
  int largest = 0;
  for (const Texture& texture : source.textures)
    largest = std::max({largest, texture.pixels.width(), texture.pixels.height()});
  if (largest > 0) target.assumed = largest;
  target.slot = "";
  const std::string file = options.text("mesh");
  if (!options.has("slot") || slots.size() != 1 || names_picture(file)) return target;
  const Model shape = read_model(file, shape_and_slots);
  const std::string slot = slot_from_text(slots.front());
  if (std::ranges::count(shape.slots, slot, &MaterialSlot::name) > 0)
    target.slot = slot;
  else if (!shape.slots.empty() && names_model(options.text("output")))
    run.terminal().remark(fmt::format(
        "{}: its materials name no picture for {}, so {} is made anew without those that they have, for {}; "
        "to keep these, write the picture alone and name it in the material",
        file, slot, options.text("output"), names_of(shape.slots)));
  return target;
}

Exit run_bake(Run& run) {
  const OptionValues& options = run.options();
  const BakeTo to = options.flag("vertices") ? BakeTo::vertices : BakeTo::textures;
  require(to == BakeTo::textures || !options.has("size"),
          "--size: is of textures, and --vertices gives colours to vertices");
  const auto [slots, shown] = asked_slots(run, to);
  TexturedModel source = read_source(run, slots.empty() ? "" : slots.front(), shown);
  TexturedModel target = read_usable_model(
      run, to == BakeTo::vertices ? MissingPictures::unneeded : MissingPictures::assume, 0.1,
      ModelPictures(std::in_place), ImageTriangles::two,
      asked_textures(run, source.model, slots));
  require(to == BakeTo::vertices || target.atlas,
          target.model.path.string() +
              ": has no texture coordinates: give it some with the verb "
              "unwrap, or bake to its vertices with --vertices");
  BakeOptions how = asked_bake(options, source.model);
  how.shown = shown;
  if (to == BakeTo::textures)
    begin_bake_as(source.model, slots,
                  options.has("slot") && has_slots(target.model, slots) ? BakedSlots::named : BakedSlots::as_the_source,
                  options.text("output"), target, run.terminal());
  else if (names_gltf(options.text("output")) && has_pictures_of_its_own(target.model))
    run.terminal().remark(target.model.path.string() +
                          ": its picture stays, and glTF multiplies it by the colours at vertices");
  const std::string output = options.text("output");
  const bool pictures_alone = slots.size() > 1 && !names_model(output);
  const Outputs outputs(output, pictures_alone ? all_pictures(target.model) : target.model,
                        to == BakeTo::vertices ? Outputs::Kind::model : Outputs::Kind::pictures);
  run.will_write(outputs.paths(), outputs.folders());
  run.input["source"] = {{"file", source.model.path.string()},
                         {"triangles", source.model.mesh.triangle_count()}};
  if (run.dry_run()) return Exit::done;

  const SourceOfSlot source_of = [&](const std::string& slot) {
    const bool is_first = slots.empty() || slot == slots.front();
    return is_first ? std::move(source) : read_source(run, slot, shown);
  };
  bake_onto(run, slots, source_of, target, to, how, 0.6);
  const Step step(run, "write", 0.2);
  if (pictures_alone) target.model = all_pictures(std::move(target.model));
  set_depth(options, target.model);
  write_outputs(run, outputs, std::move(target.model), step);
  return Exit::done;
}

}  // namespace

Verb bake_verb() {
  using Type = Option::Type;
  OptionTable table("bake",
                    "Carry the colours of one model to another that lies on it: to new texture "
                    "coordinates, a coarser or finer mesh, from textures to vertices and back.");
  table.example("scan.obj clean.obj -o baked.obj", "the pictures of a scan for a clean mesh with coordinates of its own");
  table.example("high.glb low.obj --slot normal -o low_normal.png", "the shape of a fine mesh as the normal map of a coarse one");
  table.add({.name = "source",
             .place = Option::Place::positional,
             .type = Type::path,
             .required = true,
             .help = "the model that has the colours"});
  add_model_options(table, "the model that gets them",
                    "pictures of the source instead of those that it names");
  add_model_output_option(table);
  table.add({.name = "size",
             .type = Type::integer,
             .unit = "texels",
             .least = 1,
             .most = 65536,
             .group = "Bake",
             .help = "side of the new textures; else that of the target's own, or of the source's "
                     "largest"});
  table.add({.name = "within",
             .type = Type::number,
             .default_value = as_typed(100 * BakeOptions{}.within),
             .unit = "% of the diagonal",
             .least = 0.0001,
             .most = 100,
             .group = "Bake",
             .help = "how far the source may be from the target"});
  table.add({.name = "angle",
             .type = Type::number,
             .default_value = as_typed(BakeOptions{}.angle),
             .unit = "degrees",
             .least = 1,
             .most = 180,
             .group = "Bake",
             .help = "between normals of both, at most"});
  table.add(
      {.name = "samples",
       .type = Type::integer,
       .least = 1,
       .most = 32,
       .group = "Bake",
       .help = "of each texel in each direction; else as many as show all texels of the source"});
  table.add({.name = "vertices", .group = "Signal", .help = "give the target colours at its vertices"});
  add_space_option(table);
  add_normal_space_option(table, "Green stays as it is, but glTF gets it up.");
  add_depth_option(table);
  return {table, run_bake, {{.what = "colours of another model", .pictures = ""}}, {}, Slots::its_own};
}

}  // namespace mq::app
