#include "options/model_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "mq/base/error.h"
#include "mq/io/document.h"
#include "mq/model/joined_slots.h"

namespace mq::app {
namespace {

/// exact, none, or a distance in model units.
std::optional<WeldOptions> parse_weld(const std::string& text) {
  if (text == "exact") return WeldOptions{WeldOptions::Kind::exact};
  if (text == "none") return WeldOptions{WeldOptions::Kind::none};
  double distance = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), distance);
  if (error != std::errc() || stop != text.data() + text.size() || !(distance > 0) ||
      distance > 1e60)
    return std::nullopt;
  return WeldOptions{WeldOptions::Kind::distance, distance};
}

/// The slot to be read; of several whichever a model would have without them.
std::string one_slot(const OptionValues& options) {
  const std::string slot = options.has("slot") ? options.text("slot") : "";
  return names_several_slots(slot) ? "" : slot;
}

std::vector<std::filesystem::path> texture_paths(const OptionValues& options) {
  std::vector<std::filesystem::path> paths;
  for (const std::string& name : options.texts("texture")) paths.emplace_back(name);
  return paths;
}

LoadOptions load_options(const OptionValues& options, MissingPictures missing,
                         const ModelPictures& pictures) {
  return {.textures = pictures.value_or(texture_paths(options)),
          .weld = asked_weld(options),
          .atlas = asked_flipped(options),
          .missing = missing,
          .slot = one_slot(options),
          .uv_set = options.has("uv-set") ? int(options.integer("uv-set")) : -1,
          .layer = options.has("layer") ? options.text("layer") : ""};
}

/// All that was read, and what else the options name to be read.
void register_inputs(Run& run, const Model& model) {
  will_read_model(run, model);
  for (const Option& option : run.options().table().options())
    if (option.type == Option::Type::path && option.name != "output" && option.name != "report" &&
        option.name != "cameras" && option.name != "screenshot" && !option.name.starts_with("write-"))
      for (const std::string& name : run.options().texts(option.name)) run.will_read(name);
}

}  // namespace

WeldOptions asked_weld(const OptionValues& options) { return *parse_weld(options.text("weld")); }

AtlasOptions asked_flipped(const OptionValues& options) {
  const std::string flipped = options.text("flipped");
  return {.flipped = flipped == "keep"     ? AtlasOptions::Flipped::keep
                     : flipped == "refuse" ? AtlasOptions::Flipped::refuse
                                           : AtlasOptions::Flipped::few};
}

void add_model_options(OptionTable& table, const std::string& mesh_help,
                       const std::string& texture_help) {
  using Type = Option::Type;
  constexpr auto positional = Option::Place::positional;
  table.add({.name = "mesh",
             .place = positional,
             .type = Type::path,
             .required = true,
             .help = mesh_help});
  table.add({.name = "texture",
             .place = positional,
             .type = Type::path,
             .count = Option::Count::many,
             .help = texture_help});
  table.add({.name = "weld",
             .type = Type::text,
             .default_value = "exact",
             .accepts = [](const std::string& text) { return parse_weld(text).has_value(); },
             .wanted = "exact, none or a distance in model units",
             .metavar = "exact|none|DISTANCE",
             .group = "Model",
             .help = "which vertices are one point of the surface",
             .details = "Many programs write a vertex once for every chart it lies in; exact joins "
                        "those at equal positions, a distance also those nearer than that."});
  table.add({.name = "flipped",
             .type = Type::choice,
             .default_value = "few",
             .choices = {"few", "refuse", "keep"},
             .group = "Model",
             .help = "triangles flipped against the rest of their chart",
             .details = "few: kept while they cover less than a thousandth of all charts. Kept, "
                        "both layers of the fold read and write the same texels."});
  table.add({.name = "slot",
             .type = Type::text,
             .metavar = "NAME",
             .group = "Model",
             .help = "which pictures of the materials: base-colour, normal, occlusion, ...",
             .details = "inspect lists those there are; a word of the file (map_Ks, normalTexture) "
                        "does as well; several between commas or all where a verb can, each by "
                        "itself. Otherwise it is that of the pictures named after the mesh, "
                        "if they are the model's own; else base-colour, or the only one there is."});
  table.add({.name = "uv-set",
             .type = Type::integer,
             .least = 0,
             .most = 100,
             .metavar = "N",
             .group = "Model",
             .help = "the set of texture coordinates, counted from 0, instead of that which the "
                     "material names"});
  table.add({.name = "layer",
             .type = Type::text,
             .metavar = "NAME",
             .group = "Model",
             .help = "the layer of an EXR of several that is processed; the others are kept",
             .details = "inspect lists those there are. Otherwise it is the first with R, G and B. A "
                        "picture of one layer has only that."});
}

void add_compress_option(OptionTable& table) {
  table.add({.name = "compress",
             .type = Option::Type::choice,
             .default_value = "none",
             .choices = {"none", "meshopt", "draco"},
             .group = "Model",
             .help = "geometry of a .gltf or .glb that is written",
             .details = "meshopt: without loss. draco: smaller; positions are rounded to 16 bits, texture "
                        "coordinates to 1/65536. none: what was compressed stays so where pictures "
                        "alone change."});
}

Compression asked_compression(const OptionValues& options) {
  const bool known = std::ranges::any_of(options.table().options(),
                                         [](const Option& option) { return option.name == "compress"; });
  const std::string asked = known ? options.text("compress") : "none";
  if (asked == "none") return Compression::none;
  const std::string output = options.text("output");
  require(output.ends_with(".gltf") || output.ends_with(".glb"),
          fmt::format("--compress {}: it is for .gltf and .glb, and --output is '{}'", asked, output));
  return asked == "draco" ? Compression::draco : Compression::meshopt;
}

TexturedModel read_textured_model(Run& run, MissingPictures missing, double share,
                                  const ModelPictures& pictures, ImageTriangles picture,
                                  const TargetTextures& target, const ModelWatch& watch) {
  LoadOptions options = load_options(run.options(), missing, pictures);
  const Compression compression = asked_compression(run.options());
  options.picture = picture;
  options.side = target.side;
  if (target.slot) options.slot = *target.slot, options.layer.clear();
  options.assumed_side = target.assumed;
  Model read;
  {
    const Step step(run, "read", 0.6 * share);
    read = read_input(run.options().text("mesh"), options, step, watch);
  }
  read.compression = compression;
  register_inputs(run, read);
  const Step step(run, "find charts", 0.4 * share);
  TexturedModel model = textured_model(std::move(read), options, run.terminal(), step);
  describe_input(run, model);
  run.found(model.defects());
  return model;
}

TexturedModel read_usable_model(Run& run, MissingPictures missing, double share,
                                const ModelPictures& pictures, ImageTriangles picture,
                                const TargetTextures& target) {
  TexturedModel model = read_textured_model(run, missing, share, pictures, picture, target);
  const Defects defects = model.defects();
  run.warn(defects);
  require_usable(defects, model.model.path.string());
  return model;
}

void will_read_model(Run& run, const Model& model) {
  run.will_read(model.path);
  for (const auto* textures : {&model.textures, &model.others})
    for (const Texture& texture : *textures)
      if (!texture.path.empty()) run.will_read(texture.path);
  if (model.document)
    for (const Part& part : model.document->parts)
      run.will_read(model.path.parent_path() / part.name);
}

Json picture_json(const Model& picture) {
  const Texture& texture = picture.textures.front();
  return {{"files", Json::array({picture.path.string()})},
          {"width", texture.pixels.width()},
          {"height", texture.pixels.height()},
          {"channels", texture.pixels.channels()},
          {"depth", depth_name(texture.format.depth)}};
}

void describe_input(Run& run, const TexturedModel& model) {
  Json files = Json::array({model.model.path.string()});
  Json textures = Json::array();
  for (const Texture& texture : model.model.textures) {
    if (!texture.path.empty()) files.push_back(texture.path.string());
    textures.push_back({{"name", texture.name},
                        {"width", texture.pixels.width()},
                        {"height", texture.pixels.height()},
                        {"channels", texture.pixels.channels()},
                        {"depth", depth_name(texture.format.depth)},
                        {"format", texture.format.file_format}});
    if (const auto& layers = texture.format.layers) {
      textures.back()["layer"] = layers->names[layers->chosen];
      textures.back()["layers"] = layers->names;
    }
  }
  run.input = {{"files", files},
               {"vertices", model.model.mesh.vertex_count()},
               {"triangles", model.model.mesh.triangle_count()}};
  if (model.atlas) {
    run.input["charts"] = model.atlas->charts.size();
    run.input["texels"] = std::int64_t(std::llround(model.atlas->texel_area));
  }
  run.input["uv_sets"] = uv_set_count(model.model);
  if (!model.model.slot.empty()) run.input["slot"] = model.model.slot;
  run.input["textures"] = textures;
  run.input["notes"] = model.model.notes;
}

void add_depth_option(OptionTable& table) {
  table.add({.name = "depth",
             .type = Option::Type::choice,
             .default_value = "keep",
             .choices = {"keep", "8", "16", "half", "float"},
             .group = "Signal",
             .help = "bits per value in the output"});
}

void set_depth(const OptionValues& options, Model& model) {
  const std::optional<Depth> depth = asked_depth(options);
  if (!depth) return;
  for (Texture& texture : model.textures) texture.format.depth = *depth;
  model.colors.depth = *depth;
}

std::optional<Depth> asked_depth(const OptionValues& options) {
  const std::string name = options.text("depth");
  if (name == "keep") return std::nullopt;
  return depth_from_name(name);
}

std::string depth_name(Depth depth) {
  switch (depth) {
    case Depth::u8: return "u8";
    case Depth::u16: return "u16";
    case Depth::half: return "half";
    case Depth::f32: return "float";
  }
  return "";
}

Depth depth_from_name(const std::string& name) {
  return name == "8"      ? Depth::u8
         : name == "16"   ? Depth::u16
         : name == "half" ? Depth::half
                          : Depth::f32;
}

}  // namespace mq::app
