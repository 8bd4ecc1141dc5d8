// marquetry react MESH [TEXTURE...] -o OUT --preset spots: patterns that grow on the surface.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "shell/arguments.h"
#include "options/field_options.h"
#include "options/signal_options.h"
#include "mq/base/error.h"
#include "mq/base/length.h"
#include "mq/base/words.h"
#include "mq/atlas/atlas.h"
#include "mq/filter/pattern_growth.h"
#include "mq/io/file_names.h"
#include "mq/mesh/geometry.h"
#include "mq/model/texture_fill.h"
#include "shell/results.h"
#include "shell/verb.h"

namespace mq::app {
namespace {

std::vector<std::string> preset_names() {
  std::vector<std::string> names;
  for (const GrayScottPreset& preset : gray_scott_presets()) names.push_back(preset.name);
  return names;
}

GrayScottPreset asked_preset(const OptionValues& options) {
  const auto& presets = gray_scott_presets();
  GrayScottPreset preset =
      *std::ranges::find(presets, options.text("preset"), &GrayScottPreset::name);
  if (options.has("feed")) preset.rates.feed = options.number("feed");
  if (options.has("kill")) preset.rates.kill = options.number("kill");
  return preset;
}

std::optional<Colour> parse_colour(const std::string& text) {
  const std::optional<Backdrop> backdrop = parse_backdrop(text);
  if (!backdrop || backdrop->kind != Backdrop::Kind::colour) return std::nullopt;
  return backdrop->colour;
}

Signal amounts(const Substances& state) {
  Signal values(std::ssize(state) / 2, 1);
  for (Eigen::Index i = 0; i < values.rows(); ++i) values(i, 0) = state[std::size_t(2 * i + 1)];
  return values;
}

/// From the ground's colour to the ink's, between the values that all but a hundredth of the
/// unknowns exceed and stay below.
Signal coloured(const Substances& state, const Colour& ground, const Colour& ink) {
  const Signal v = amounts(state);
  std::vector<double> sorted(v.data(), v.data() + v.size());
  std::ranges::sort(sorted);
  const double low = sorted[sorted.size() / 100],
               high = sorted[sorted.size() - 1 - sorted.size() / 100];
  Signal values(v.rows(), 3);
  for (Eigen::Index i = 0; i < values.rows(); ++i) {
    const double share = high > low ? std::clamp((v(i, 0) - low) / (high - low), 0.0, 1.0) : 0;
    for (int c = 0; c < 3; ++c)
      values(i, c) =
          ground[std::size_t(c)] + share * (ink[std::size_t(c)] - ground[std::size_t(c)]);
  }
  return values;
}

/// More steps than anyone waits for: at a microsecond each, which is a few dozen texels, a minute
/// and a half.
constexpr double most_steps = 1e8;

void require_bearable(const OptionValues& options, const PatternGrowth& growth) {
  const PatternGrowth::Stage longest = growth.stages().front();
  require(
      longest.steps <= most_steps,
      fmt::format("--time {:g}: takes {:.3g} steps of {:.3g}, which is what a wave of --scale {} "
                  "allows on this surface; wanted at most {:g} steps: choose a shorter time, or "
                  "a smaller scale",
                  options.number("time"), longest.steps, longest.process->time_step(), options.text("scale"), most_steps));
}

/// "40 seconds", "12 minutes", "5 hours", "3 days".
std::string spoken(double seconds) {
  const std::pair<double, const char*> units[] = {{86400, "day"}, {3600, "hour"}, {60, "minute"}};
  for (const auto& [length, name] : units)
    if (seconds >= 2 * length) return counted(std::llround(seconds / length), name);
  return counted(std::llround(seconds), "second");
}

/// Where it takes long, says so, with what would make it shorter.
Substances grow(Run& run, const PatternGrowth& growth, const Reaction& reaction, Substances seeds,
                const Progress& progress) {
  constexpr double long_wait = 20;  // seconds
  const PatternGrowth::Stage longest = growth.stages().front();
  const auto expect = [&](double wait) {
    run.terminal().foresee(wait);
    if (wait > long_wait)
      run.terminal().remark(fmt::format("{} on {} take about {}; --time and --scale say how many", counted(std::llround(longest.steps), "step"),
                                        counted(longest.process->size(), "unknown"), spoken(wait)));
  };
  return growth.grow(reaction, std::move(seeds), expect, progress);
}

/// The most there is of the second substance, which the pattern is made of.
float most_of_second(const Substances& state) {
  float most = 0;
  for (std::size_t i = 1; i < state.size(); i += 2) most = std::max(most, state[i]);
  return most;
}

/// Waves shorter than this many texels show the grid; where texels are stretched, and few, it is seen from the second
/// on.
constexpr double least_texels = 6, least_stretched_texels = 4;

/// Of the surface, the part where texels are longer than this.
double part_of_longer(const TexturedModel& scene, const Atlas& atlas, double length) {
  double longer = 0, all = 0;
  for (int t = 0; t < scene.surface.triangle_count(); ++t) {
    const double area = triangle_area(scene.surface.mesh, t);
    all += area;
    if (atlas.chart[std::size_t(t)] < 0) continue;
    const TexelMetric metric = texel_metric(scene.surface, atlas, t);
    if (std::sqrt(metric.density * metric.stretch) > length) longer += area;
  }
  return all > 0 ? longer / all : 0;
}

void warn_of_coarse_texels(Run& run, const TexturedModel& scene, const ModelSignal& domain, double wave,
                           const std::string& where) {
  const double spacing = domain.scale().texel_spacing;
  if (wave < least_texels * spacing) {
    const bool texels = domain.texel_space() != nullptr;
    run.terminal().warning(fmt::format("--scale: a wave is {:.1f} {} long{}; below {:g} the {} shows in the pattern: take a "
                                       "larger --scale, {}",
                                       wave / spacing, texels ? "texels" : "vertices", where, least_texels,
                                       texels ? "grid" : "mesh",
                                       texels ? "or a larger texture" : "or 'unwrap', which makes texels for finer patterns"));
    return;
  }
  const Atlas* const atlas = domain.texel_atlas();
  const double coarse = atlas ? part_of_longer(scene, *atlas, wave / least_stretched_texels) : 0;
  constexpr double noticeable = 0.02;
  if (coarse > noticeable)
    run.terminal().remark(fmt::format("on {:.0f} % of the surface texels are so long that a wave has fewer than {:g} "
                                      "of them, and the grid shows there: take a larger --scale, a larger texture, "
                                      "or 'unwrap'",
                                      100 * coarse, least_stretched_texels));
}

/// Where nothing is left the picture is plain: says why.
void warn_of_nothing(Run& run, const Substances& state) {
  constexpr float visible = 1.0F / 255;
  if (most_of_second(state) >= visible) return;
  run.terminal().warning(
      fmt::format("nothing is left of the pattern: it died out; another --seed may live, at --scale {} the surface may be "
                  "too small for it, and --feed and --kill decide whether any can",
                  run.options().text("scale")));
}

/// As asked for; where nobody asked, and vertices lie too far apart for the default, the whole per cent that suits them.
double asked_wave_length(Run& run, const ModelSignal& domain) {
  constexpr double enough_vertices = 8;
  const OptionValues& options = run.options();
  const auto in_model_units = [&](const std::string& text) {
    return std::sqrt(weight_from_length(parse_length(text), domain.space().scale()));
  };
  const double wave = in_model_units(options.text("scale")), least = enough_vertices * domain.scale().texel_spacing;
  require(wave > 0, "--scale must be more than 0");
  if (domain.texel_space() || options.given("scale") || wave >= least) return wave;
  const std::string scale = fmt::format("{:.0f}%", std::ceil(least / in_model_units("1%")));
  run.terminal().remark(fmt::format("of the usual --scale {} a wave would be {:.1f} vertices long, so --scale {} is taken; "
                                    "'unwrap' makes texels for finer patterns",
                                    options.text("scale"), wave / domain.scale().texel_spacing, scale));
  return in_model_units(scale);
}

Exit react(Run& run) {
  const OptionValues& options = run.options();
  TargetTextures target;
  if (options.has("size")) target.side = int(options.integer("size"));
  TexturedModel scene = read_usable_model(run, MissingPictures::overlook, 0.05, {}, ImageTriangles::two, target);
  const bool vertices = works_at_vertices(options, scene);
  require(!vertices || !options.has("size"), "--size: it is of textures, and the pattern grows at vertices");
  const Outputs outputs(options.text("output"), scene.model,
                        vertices ? Outputs::Kind::model : Outputs::Kind::pictures);
  run.will_write(outputs.paths(), outputs.folders());
  if (run.dry_run()) return Exit::done;

  std::unique_ptr<ModelSignal> domain;
  std::unique_ptr<SignalSpace> along;
  std::unique_ptr<PatternGrowth> growth;
  const GrayScottPreset preset = asked_preset(options);
  double wave_length = 0;
  {
    const Step step(run, "assemble", 0.15);
    // Texels that charts share show the pattern of one of these places.
    domain = make_field_signal(run, scene, step.progress().step("space", 0.35),
                               TextureSignalOptions::SharedTexels::one_for_each);
    about(scene.model, [&] {
      along = asked_space_along(run, scene, *domain,
                                options.has("field") ? step.progress().step("along the field", 0.2) : Progress());
      wave_length = asked_wave_length(run, *domain);
      growth = std::make_unique<PatternGrowth>(
          along ? *along : domain->space(), along ? nullptr : &scene.surface,
          along ? std::vector<int>() : components_of(*domain, scene.surface),
          diffusivities(preset, wave_length), wave_length, options.number("time"), step.progress().step("even triangles", 0.45));
    });
  }
  warn_of_coarse_texels(run, scene, *domain,
                        along ? wave_length / std::hypot(1, options.number("kappa")) : wave_length,
                        along ? " across the field" : "");
  require_bearable(options, *growth);
  Substances state = growth->seeds(std::uint64_t(options.integer("seed")));
  {
    const Step step(run, "react", 0.78);
    state = grow(run, *growth, gray_scott(preset.rates), std::move(state), step);
  }
  warn_of_nothing(run, state);
  run.result["stages"] = Json::array();
  for (const PatternGrowth::Stage& stage : growth->stages())
    run.result["stages"].push_back({{"unknowns", stage.process->size()},
                                    {"steps", std::int64_t(stage.steps)},
                                    {"time_step", stage.process->time_step()},
                                    {"slowed", stage.process->slowed()}});
  run.result["wave_length"] = wave_length;

  const Step step(run, "write", 0.02);
  const bool numbers = holds_numbers(outputs.paths().front());
  domain->replace(numbers ? amounts(state)
                    : coloured(state, *parse_colour(options.text("ground")),
                               *parse_colour(options.text("ink"))),
            numbers ? Depth::f32 : Depth::u8, scene.model);
  if (domain->texel_space()) spread_past_charts(domain->texels(), scene);
  write_outputs(run, outputs, std::move(scene.model), step);
  return Exit::done;
}

}  // namespace

Verb react_verb() {
  using Type = Option::Type;
  OptionTable table("react",
                    "Grow a pattern on the surface by reaction and diffusion: spots, "
                    "stripes and others, without seams.");
  table.example("bust.obj -o spots.obj", "spots that grow over all seams");
  table.example("bust.obj --preset stripes --scale 3% -o stripes.obj", "broader stripes");
  add_model_options(table);
  add_model_output_option(table);
  table.add({.name = "preset",
             .letter = 'p',
             .type = Type::choice,
             .default_value = "spots",
             .choices = preset_names(),
             .group = "Pattern",
             .help = "what grows"});
  table.add(
      {.name = "scale",
       .letter = 's',
       .type = Type::length,
       .default_value = "2%",
       .group = "Pattern",
       .help = "wave length of the pattern: from spot to spot, from stripe to stripe",
       .details = "At least 6 texels, or vertices; where these lie too far apart for the default, 8 of them."});
  table.add({.name = "time",
             .letter = 't',
             .type = Type::number,
             .default_value = "5000",
             .least = 0,
             .most = 1e7,
             .group = "Pattern",
             .help = "how long it grows, in units of the reaction"});
  table.add({.name = "feed",
             .type = Type::number,
             .least = 0,
             .most = 1,
             .group = "Pattern",
             .help = "rate F of the reaction, in place of the preset's"});
  table.add({.name = "kill",
             .type = Type::number,
             .least = 0,
             .most = 1,
             .group = "Pattern",
             .help = "rate k of the reaction, in place of the preset's"});
  table.add({.name = "size",
             .type = Type::integer,
             .unit = "texels",
             .least = 1,
             .most = 32768,
             .group = "Pattern",
             .help = "side of the textures that are made; else that of the model's, 2048 where it has none"});
  const auto colour = [&](const std::string& name, const std::string& value,
                          const std::string& help) {
    table.add({.name = name,
               .type = Type::text,
               .default_value = value,
               .accepts = [](const std::string& text) { return parse_colour(text).has_value(); },
               .wanted = "white, black or #rrggbb",
               .metavar = "COLOUR",
               .group = "Pattern",
               .help = help});
  };
  colour("ground", "#e8c88a", "colour between spots or stripes");
  colour("ink", "#2b1a12", "colour of spots or stripes");
  add_direction_options(table, "Along a field", "waves of this length", "2");
  add_vertices_option(table, "grow it at vertices, though there are textures");
  add_frames_option(table);
  return {table, react,
          {{.what = "reaction and diffusion"}}};
}

}  // namespace mq::app
