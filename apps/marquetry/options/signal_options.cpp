#include "options/signal_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/base/infinity.h"
#include "mq/filter/halo_limit.h"
#include "mq/io/slots.h"
#include "shell/arguments.h"

namespace mq::app {

bool asks_for(const OptionValues& options, const std::string& name) {
  if (!options.given(name)) return false;
  const Option& option = options.table().find(name);
  if (option.type == Option::Type::flag) return options.flag(name);
  if (option.default_value.empty()) return true;
  if (option.type == Option::Type::number)
    return options.number(name) != OptionValues(options.table()).number(name);
  return options.text(name) != option.default_value;
}

void add_output_option(OptionTable& table) {
  table.add({.name = "output",
             .letter = 'o',
             .type = Option::Type::path,
             .required = true,
             .metavar = "OUT",
             .help = "a picture, a model, or a folder for all pictures",
             .details = "With several textures %s in the name stands for the texture's own."});
}

void add_model_output_option(OptionTable& table) {
  add_output_option(table);
  add_compress_option(table);
}

void add_spread_options(OptionTable& table, const Length& usual, const std::string& group,
                        const std::string& help, bool infinite, const std::string& zero) {
  const bool by_alpha = usual.unit == Length::Unit::alpha;
  table.add({.name = "alpha",
             .letter = 'a',
             .type = Option::Type::number,
             .default_value = by_alpha ? as_typed(usual.value) : "",
             .least = 0,
             .most = 1e6,
             .infinite = infinite,
             .group = group,
             .help = help,
             .details = "(length / sqrt(area)) squared. " + zero +
                        (infinite ? " inf counts gradients only, and each component keeps its mean."
                                  : "")});
  table.add(
      {.name = "length",
       .letter = 'l',
       .type = Option::Type::length,
       .default_value = by_alpha ? "" : as_typed(usual),
       .group = group,
       .help = "the same as a distance: 0.02 in model units, 1% of sqrt(area), 8tx in texels"});
  table.exclusive({"alpha", "length"});
}

Length spread(const OptionValues& options) {
  if (options.has("length")) return parse_length(options.text("length"));
  return {options.number("alpha"), Length::Unit::alpha};
}

double spread_weight(const OptionValues& options, const SurfaceScale& scale) {
  return weight_from_length(spread(options), scale);
}

void add_halo_option(OptionTable& table, const std::string& group) {
  table.add({.name = "halo",
             .type = Option::Type::number,
             .least = 0,
             .most = 1,
             .infinite = true,
             .group = group,
             .help = "how far beyond what is around it sharpening may carry an edge: part of the contrast there",
             .details = fmt::format("{:g} without it; of normals and light (--space linear, or values above 1) inf: as "
                                    "the equation says, fringes and all. Where contrast is below {:g} it is so with "
                                    "any.",
                                    HaloOptions{}.fraction, HaloOptions{}.contrast / 2)});
}

double asked_halo(const OptionValues& options, const Model& model, double largest) {
  if (options.has("halo")) return options.number("halo");
  const ValueSpace in = value_space(options);
  const bool is_light = in.space == ColourSpace::linear || (in.space == ColourSpace::stored && largest > 1);
  const bool is_normals = in.meaning == ValueSpace::Meaning::normals ||
                          (!model.textures.empty() && model.textures.front().meaning == TextureMeaning::normals);
  return is_light || is_normals ? infinity : HaloOptions{}.fraction;
}

double largest_value(const Signal& values) { return values.size() > 0 ? values.maxCoeff() : 0; }

void add_space_option(OptionTable& table, const std::string& usual) {
  table.add({.name = "space",
             .type = Option::Type::choice,
             .default_value = usual,
             .choices = {"stored", "linear", "log"},
             .group = "Signal",
             .help = "in which values are processed",
             .details = "stored: as the file holds them. linear: light, with the sRGB curve "
                        "undone. log: the logarithm of light."});
}

void add_normals_option(OptionTable& table) {
  table.add(
      {.name = "normals",
       .group = "Signal",
       .help = "the texture is a normal map; keep its normals of unit length"});
  add_normal_space_option(table, "Any but auto says that the texture is a normal map.");
}

void add_normal_space_option(OptionTable& table, const std::string& remark) {
  table.add({.name = "normal-space",
             .type = Option::Type::choice,
             .default_value = "auto",
             .choices = {"auto", "object", "tangent", "directx"},
             .group = "Signal",
             .help = "in which axes a normal map is: the model's, or those of its charts",
             .details = "tangent: green up, as glTF and OpenGL have it; directx: green down. auto: "
                        "tangent in normal slots of glTF, and where 9 of 10 normals point along z. " +
                        remark});
}

NormalAxes normal_axes(const OptionValues& options) {
  const std::string name = options.text("normal-space");
  return name == "object"    ? NormalAxes::object
         : name == "tangent" ? NormalAxes::tangent
         : name == "directx" ? NormalAxes::tangent_down
                             : NormalAxes::as_found;
}

void add_vertices_option(OptionTable& table, const std::string& help) {
  table.add({.name = "vertices",
             .group = "Signal",
             .help = help,
             .details = "Without texture coordinates this is what is done anyway."});
}

namespace {

void refuse_vertices_of_picture(const OptionValues& options, const TexturedModel& model) {
  require(!model.is_picture || !options.flag("vertices"),
          model.model.path.string() + ": is a picture, and --vertices is for models: leave it out");
}

}  // namespace

void refuse_normals_of_colours(const OptionValues& options, const Model& model) {
  const bool says_normals = value_space(options).meaning == ValueSpace::Meaning::normals;
  const bool has_normals = std::ranges::count(model.slots, "normal", &MaterialSlot::name) > 0;
  require(!says_normals || !has_normals || model.slot != base_slot || !options.texts("texture").empty() ||
              options.has("slot"),
          fmt::format("{}: its base colour is processed, and --normals and --normal-space are of normal maps: "
                      "give --slot normal",
                      model.path.string()));
}

bool at_vertices(const OptionValues& options, const TexturedModel& model) {
  refuse_vertices_of_picture(options, model);
  const bool asked = options.flag("vertices");
  if (!asked && model.atlas) return false;
  const std::string file = model.model.path.string();
  const bool has_shapes = std::ranges::count(options.table().options(), "geometry", &Option::name) > 0;
  require(model.model.colors.channels > 0,
          asked ? file + ": has no colours at its vertices (--vertices)"
                : fmt::format("{}: has neither texture coordinates nor colours at its vertices: there is nothing to "
                              "{}; 'marquetry unwrap' gives it texture coordinates, 'marquetry texture' colours of "
                              "photographs{}",
                              file, options.table().verb(), has_shapes ? ", and --geometry works on its shape" : ""));
  require(options.text("space") == "stored",
          file +
              ": has no texture coordinates; --space is for textures, not for colours at "
              "vertices: leave it out");
  return true;
}

void refuse_pictures(const OptionValues& options) {
  const std::vector<std::string> pictures = options.texts("texture");
  require(pictures.empty(),
          fmt::format("{}: its colours at vertices are what is processed, and '{}' would not be "
                      "looked at: leave it out",
                      options.text("mesh"), pictures.empty() ? "" : pictures.front()));
}

ValueSpace value_space(const OptionValues& options) {
  const auto has = [&](const std::string& name) {
    return std::ranges::any_of(options.table().options(),
                               [&](const Option& option) { return option.name == name; }) &&
           options.has(name);
  };
  ValueSpace values;
  if (has("normal-space")) values.axes = normal_axes(options);
  if ((has("normals") && options.flag("normals")) || values.axes != NormalAxes::as_found)
    values.meaning = ValueSpace::Meaning::normals;
  const std::string name = has("space") ? options.text("space") : "stored";
  values.space = name == "linear" ? ColourSpace::linear
                 : name == "log"  ? ColourSpace::log
                                  : ColourSpace::stored;
  return values;
}

void say_defects(Run& run, const ModelSignal& signal) {
  const Defects defects = signal.defects();
  run.found(defects);
  run.warn(defects);
}

std::unique_ptr<TextureSignal> make_texture_signal(Run& run, const TexturedModel& model,
                                                   TextureSignalOptions options,
                                                   const Progress& progress) {
  options.kept = run.kept;
  std::unique_ptr<TextureSignal> signal;
  about(model.model, [&] {
    signal = std::make_unique<TextureSignal>(model, options, run.terminal(), progress);
    say_defects(run, *signal);
  });
  return signal;
}

std::unique_ptr<ModelSignal> make_signal(Run& run, const TexturedModel& model,
                                         const Progress& progress) {
  const bool of_vertices = at_vertices(run.options(), model);
  if (!of_vertices) refuse_normals_of_colours(run.options(), model.model);
  if (!of_vertices)
    return make_texture_signal(run, model,
                               {.values = value_space(run.options()),
                                .shared = TextureSignalOptions::SharedTexels::as_normals_need,
                                .depth = asked_depth(run.options())},
                               progress);
  std::unique_ptr<ModelSignal> signal;
  about(model.model, [&] { signal = std::make_unique<VertexColourSignal>(model); });
  return signal;
}

bool works_at_vertices(const OptionValues& options, const TexturedModel& model) {
  refuse_vertices_of_picture(options, model);
  return options.flag("vertices") || !model.atlas;
}

std::unique_ptr<ModelSignal> make_field_signal(Run& run, const TexturedModel& model,
                                               const Progress& progress,
                                               TextureSignalOptions::SharedTexels shared,
                                               TextureSignalOptions::Pictures pictures,
                                               const TexelSpaceOptions& space) {
  if (!works_at_vertices(run.options(), model))
    return make_texture_signal(run, model, {.space = space, .shared = shared, .pictures = pictures}, progress);
  std::unique_ptr<ModelSignal> signal;
  about(model.model, [&] { signal = std::make_unique<VertexColourSignal>(model); });
  if (model.atlas && !model.model.textures.empty())
    run.terminal().remark("colours at vertices: the model keeps its textures, and viewers that show these show nothing of "
                          "what is written now; without --vertices it is written into textures");
  return signal;
}

}  // namespace mq::app
