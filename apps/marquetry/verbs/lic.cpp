// marquetry lic MESH [TEXTURE...] -o OUT --field FIELD: the lines of a vector field as a picture.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/base/length.h"
#include "mq/filter/line_integral.h"
#include "mq/filter/path_convolution.h"
#include "mq/image/colour.h"
#include "mq/model/field_lines.h"
#include "options/field_options.h"
#include "options/signal_options.h"
#include "options/solver_options.h"
#include "shell/arguments.h"
#include "shell/results.h"
#include "shell/verb.h"

namespace mq::app {
namespace {

/// Spacing of the noise. Throws `InvalidInput` where it is far from what texels can show.
double asked_grain(Run& run, const ModelSignal& domain) {
  const OptionValues& options = run.options();
  const SurfaceScale scale = domain.scale();
  if (!options.has("grain")) {
    const double grain = usual_grain(domain.space());
    if (grain > 1.001 * finest_grain(scale))
      run.terminal().remark(fmt::format(
          "a fifth of the surface has texels {:.1f} times as far from each other as the mean, so lines are as wide "
          "everywhere as these can show; finer by --grain 2tx, which is uneven, or on a texture with larger charts there",
          grain / scale.texel_spacing));
    return grain;
  }
  const std::string text = options.text("grain");
  const double grain = std::sqrt(weight_from_length(parse_length(text), scale));
  const double texels = grain / scale.texel_spacing;
  require(texels >= 0.1 && texels <= 1e4,
          fmt::format("--grain: found {}, which is {:.3g} texels, wanted 0.1 to 10000 of them; 2tx "
                      "suits most",
                      text, texels));
  return grain;
}

LineIntegralOptions asked_lines(const OptionValues& options, const SurfaceScale& scale, double grain) {
  LineIntegralOptions lines = suiting(spread_weight(options, scale), grain);
  if (options.has("sharpen")) lines.sharpen_weight = options.number("sharpen") * scale.area;
  if (options.text("strength") == "scaled") lines.even_weight = 0;  // they fade
  return lines;
}

/// Whether the lines go over colours: there are some, and alike in channels.
bool shows_colours(const OptionValues& options, const TexturedModel& scene, bool vertices) {
  if (options.text("over") == "nothing") return false;
  if (vertices) return scene.model.colors.channels > 0;
  const std::vector<Texture>& textures = scene.model.textures;
  return !textures.empty() && std::ranges::all_of(textures, [&](const Texture& texture) {
    return !texture.pixels.empty() && texture.pixels.channels() == textures[0].pixels.channels();
  });
}

/// Lines by paths through the texels, of one column.
Signal lines_by_paths(Run& run, const TexturedModel& scene, const ModelSignal& domain, const Signal& noise,
                      double length, const Progress& progress) {
  const TexelVectorSpace vectors(scene.surface, *domain.texel_atlas(), *domain.texel_space());
  const TraceAtlas atlas(scene.surface, *domain.texel_atlas(), *domain.texel_space(), progress.step("order cells", 0.1));
  const ModelField field = found_field(run, scene, domain, asked_request(run.options(), scene), progress.step("field", 0.3));
  const Vector z = field.texels.size() > 0 ? field.texels : vectors.from_triangles(field.field);
  ConvolvedPaths lines = PathConvolution(vectors, atlas, z).draw(noise, length, progress.step("follow paths", 0.6));
  run.result["paths"] = lines.counts.paths;
  return std::move(lines.signal);
}

/// Curvatures have no sign: where neighbours point opposite ways there is nothing to follow.
bool follows_paths(const OptionValues& options, const FieldRequest& request, bool vertices) {
  if (options.text("by") != "paths") return false;
  require(!vertices, "--by paths: follows a field from texel to texel, and there are none: leave it out at vertices");
  for (const char* name : {"kappa", "sharpen"})
    require(!asks_for(options, name), fmt::format("--{}: paths have no use for it; leave it out, or --by paths", name));
  require(request.kind != FieldRequest::Kind::max_curvature && request.kind != FieldRequest::Kind::min_curvature,
          "--by paths: directions of curvature have no sign, so there are no paths to follow; leave it out, or name "
          "another --field");
  return true;
}

Exit lic(Run& run) {
  const OptionValues& options = run.options();
  TexturedModel scene =
      read_usable_model(run, MissingPictures::assume, 0.04, {}, ImageTriangles::per_pixel);
  const bool vertices = works_at_vertices(options, scene);
  const Outputs outputs(options.text("output"), scene.model,
                        vertices ? Outputs::Kind::model : Outputs::Kind::pictures);
  run.will_write(outputs.paths(), outputs.folders());
  const FieldRequest request = asked_request(options, scene);
  check_field(scene, request);
  const bool paths = follows_paths(options, request, vertices);
  if (run.dry_run()) return Exit::done;

  const bool over = shows_colours(options, scene, vertices);
  std::unique_ptr<ModelSignal> domain;
  std::unique_ptr<SignalSpace> across;
  double grain = 0;
  {
    const Step step(run, "assemble", 0.28);
    using Pictures = TextureSignalOptions::Pictures;
    domain = make_field_signal(run, scene, step.progress().step("surface", 0.4),
                               TextureSignalOptions::SharedTexels::one_unknown,
                               over ? Pictures::read : Pictures::replaced);
    about(scene.model, [&] {
      grain = asked_grain(run, *domain);
      if (paths) return;
      const ModelField found =
          found_field(run, scene, *domain, request, step.progress().step("field", 0.2));
      across = domain->space_across(found.field, options.number("kappa"), step.progress().step("metric", 0.4));
    });
  }
  const SurfaceScale scale = domain->space().scale();
  const LineIntegralOptions wanted = asked_lines(options, scale, grain);
  LineIntegral lines;
  about(scene.model, [&] {
    const Signal noise =
        solid_noise(domain->space().positions(), grain, std::uint64_t(options.integer("seed")));
    if (paths) {
      const Step step(run, "follow", 0.6);
      lines.signal = lines_by_paths(run, scene, *domain, noise, 2 * std::sqrt(wanted.weight), step);
      return;
    }
    if (run.onlooker) {
      const Step step(run, "form", 0.05);
      Model forming;
      forming.path = scene.model.path;
      forming.mesh = scene.model.mesh;
      watch_lines_form(
          *across, noise, wanted.weight, 64,
          [&](int done, const Signal& now) {
            domain->replace(with_contrast(now, options.number("deviations")).replicate(1, 3),
                            Depth::u8, forming);
            run.onlooker(done == 0 ? "noise" : fmt::format("step {}", done), forming);
          },
          step);
    }
    solve_as_asked(run, *domain, [&](const SolverFactory& factory, const SolvingShares& shares) {
      const Step step(run, "solve", shares.prepare + shares.solve + 0.03);
      lines = line_integral(*across, domain->space(), noise, wanted, factory, step);
      SolveReport report = lines.spread;
      report.converged = report.converged && lines.sharpen.converged;
      return report;
    });
  });
  run.result["length"] = std::sqrt(wanted.weight);
  run.result["grain"] = grain;

  const Step step(run, "write", 0.03);
  const Signal grey = with_contrast(lines.signal, options.number("deviations"));
  if (over) {
    const Signal colours = domain->values();
    domain->put(colours, lines_over(colours, grey, colour_channels(int(colours.cols()))),
                scene.model);
  } else {
    domain->replace(grey.replicate(1, 3), Depth::u8, scene.model);
  }
  write_outputs(run, outputs, std::move(scene.model), step);
  return Exit::done;
}

}  // namespace

Verb lic_verb() {
  using Type = Option::Type;
  OptionTable table("lic",
                    "Show the lines of a vector field on the surface: line integral "
                    "convolution across the seams of the texture.");
  table.example("scan.obj -o lines.obj", "lines of curvature over the model's colours");
  add_model_options(table);
  add_model_output_option(table);
  add_field_options(table);
  add_spread_options(table, {FieldLinesOptions{}.alpha, Length::Unit::alpha}, "Lines",
                     "how far values spread along the field: on the surface scaled to unit area");
  table.add({.name = "by",
             .type = Type::choice,
             .default_value = "diffusion",
             .choices = {"diffusion", "paths"},
             .group = "Lines",
             .help = "diffusion in a metric, or paths through the texels, twice --length both ways: finer",
             .details = "Paths see a field texel by texel, so that strokes and maps may be finer than triangles; they "
                        "want one with a sign, not curvatures, and have no use for --kappa and --sharpen."});
  table.add({.name = "kappa",
             .type = Type::number,
             .default_value = as_typed(FieldLinesOptions{}.kappa),
             .least = 0,
             .most = 10000,
             .group = "Lines",
             .help = "how many times less far they spread across it"});
  table.add({.name = "grain",
             .type = Type::length,
             .group = "Lines",
             .help = "size of the noise that is spread, and so the width of lines [default 0.25%, or what texels can show: "
                     "2tx, more where they are uneven]",
             .details = "In model units or % it is the same for any texture of the surface."});
  table.add({.name = "sharpen",
             .type = Type::number,
             .least = 0,
             .most = 1e6,
             .group = "Lines",
             .help = "weight, as --alpha, of the sharpening by 100 that follows [default from the grain]; 0: none"});
  table.add({.name = "deviations",
             .type = Type::number,
             .default_value = as_typed(FieldLinesOptions{}.deviations),
             .least = 0.01,
             .most = 1000,
             .group = "Lines",
             .help = "standard deviations from grey to black and to white: less is more contrast"});
  table.add(
      {.name = "over",
       .type = Type::choice,
       .default_value = "colours",
       .choices = {"colours", "nothing"},
       .group = "Lines",
       .help = "what lines are drawn over: the model's colours, or nothing: grey",
       .details = "A model without colours, or with textures of unlike channels, gets grey ones."});
  add_solver_options(table, as_typed(FieldLinesOptions{}.tolerance));
  add_vertices_option(table, "lines at vertices, though there are textures");
  add_frames_option(table);
  return {table, lic, {{.what = "line integral convolution"}}};
}

}  // namespace mq::app
