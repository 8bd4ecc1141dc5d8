#include "verbs/shared/filter_strength.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "mq/base/error.h"
#include "options/signal_options.h"
#include "shell/arguments.h"

namespace mq::app {
namespace {

/// Of what size detail is where only a strength is given, on textures and where there are no texels.
constexpr Length usual_radius{3, Length::Unit::texels}, usual_radius_of_shapes{1, Length::Unit::percent};

/// Contrast that 8 bits a channel, and what a lossy format makes of them, leave where there is none.
constexpr double usual_threshold = 0.02;

/// Without --threshold the usual one, where a strength sharpens colours of 8 bits.
double asked_threshold(const OptionValues& options, const Model& model) {
  if (options.has("threshold")) return options.number("threshold");
  const bool is_coarse = !model.textures.empty() && std::ranges::all_of(model.textures, [](const Texture& texture) {
    return texture.format.depth == Depth::u8;
  });
  return is_coarse && by_luminance(options, model) && options.has("strength") && options.number("strength") > 0 &&
                 value_space(options).space == ColourSpace::stored
             ? usual_threshold
             : 0;
}

}  // namespace

void add_strength_options(OptionTable& table) {
  table.add({.name = "strength",
             .type = Option::Type::number,
             .unit = "%",
             .least = -100,
             .most = 99'900,
             .group = "Filter",
             .help = "how much of detail is added: 100 doubles it, -100 smooths it away, 0 changes nothing",
             .details = "As --beta 1 + N/100; above 0 colours are filtered as with --luminance, which --beta does "
                        "not do by itself."});
  table.add({.name = "radius",
             .type = Option::Type::length,
             .group = "Filter",
             .help = "how large that detail is, as --length",
             .details = fmt::format("With --strength {} without it, {} of shapes and at vertices.",
                                    as_typed(usual_radius), as_typed(usual_radius_of_shapes))});
  table.add({.name = "beta",
             .letter = 'b',
             .type = Option::Type::number,
             .least = 0,
             .most = 1000,
             .group = "Filter",
             .help = "factor on the gradients: 0 smooths, 1 changes nothing, more sharpens"});
}

void add_luminance_option(OptionTable& table) {
  table.add({.name = "luminance",
             .group = "Filter",
             .help = "filter what is bright and dark, and leave the hues: no coloured fringes",
             .details = "0.2126 red + 0.7152 green + 0.0722 blue is filtered, and what it changes by is "
                        "added to all three. Alpha is kept. Maps that hold other values than colours "
                        "are filtered channel by channel."});
}

void require_strength(const OptionValues& options) {
  if (options.has("beta") || options.has("strength")) return;
  std::string commands;
  for (const auto& [words, use] : options.table().examples())
    commands += fmt::format("\n  marquetry filter {}    {}", words, use);
  throw InvalidInput("how much is wanted: --strength 50% brings detail out by half, -100% smooths it away (or --beta)" +
                     commands);
}

double asked_beta(const OptionValues& options) {
  return options.has("beta") ? options.number("beta") : 1 + options.number("strength") / 100;
}

double asked_weight(const OptionValues& options, const SurfaceScale& scale) {
  if (options.has("radius")) return weight_from_length(parse_length(options.text("radius")), scale);
  if (options.has("strength") && !options.has("length"))
    return weight_from_length(scale.texel_spacing > 0 ? usual_radius : usual_radius_of_shapes, scale);
  return spread_weight(options, scale);
}

bool by_luminance(const OptionValues& options, const Model& model) {
  const std::vector<Texture>& textures = model.textures;
  const bool sharpens = options.has("strength") && options.number("strength") > 0;
  const bool are_normals = value_space(options).meaning == ValueSpace::Meaning::normals;
  return (options.flag("luminance") || (sharpens && !are_normals)) &&
         (textures.empty() || textures.front().meaning == TextureMeaning::colours);
}

void add_threshold_option(OptionTable& table) {
  table.add({.name = "threshold",
             .type = Option::Type::number,
             .least = 0,
             .most = 1e6,
             .group = "Filter",
             .help = "contrast over seven texels up to which nothing is sharpened; from twice it on all is",
             .details = fmt::format("{:g} without it where --strength sharpens colours of 8 bits, so that blocks of JPEG "
                                    "stay as faint as they are; else 0.", usual_threshold)});
}

HaloOptions asked_halos(const OptionValues& options, const Model& model, double largest) {
  HaloOptions halo;
  halo.fraction = asked_halo(options, model, largest);
  if (std::isinf(halo.fraction) && options.has("threshold"))
    throw InvalidInput("--threshold is of sharpening that limits halos, which is not so of normals, of light and "
                       "with --halo inf: give --halo a number, such as 0.2, or leave --threshold out");
  halo.threshold = std::isinf(halo.fraction) ? 0 : asked_threshold(options, model);
  return halo;
}

}  // namespace mq::app
