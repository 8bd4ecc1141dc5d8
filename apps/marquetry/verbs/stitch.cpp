// marquetry stitch MESH [TEXTURE...] -o OUT: one texture of photographs that do not match.
//
// The gradients inside each region are kept, the steps between regions taken out. Regions are the
// colours of a label picture, or the charts; or the verb is given the photographs as textures of
// their own, and takes from each what it shows best.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "mq/base/error.h"
#include "mq/filter/modulation.h"
#include "mq/filter/stitch.h"
#include "mq/model/photograph_texture.h"
#include "mq/model/photographs.h"
#include "mq/model/stitch_regions.h"
#include "mq/model/texture_fill.h"
#include "options/model_options.h"
#include "options/signal_options.h"
#include "options/solver_options.h"
#include "shell/arguments.h"
#include "shell/results.h"
#include "shell/run.h"
#include "shell/verb.h"
#include "verbs/shared/input_pictures.h"
#include "verbs/shared/partials.h"
#include "verbs/shared/seam_report.h"

namespace mq::app {
namespace {

/// "0", "12,0,255" or "#0c00ff": values as the label picture stores them.
std::optional<std::vector<double>> parse_label(const std::string& text) {
  if (text.size() == 7 && text[0] == '#') {
    std::vector<double> values;
    for (int k = 0; k < 3; ++k) {
      const std::string digits = text.substr(std::size_t(1 + 2 * k), 2);
      if (!std::ranges::all_of(digits, [](unsigned char c) { return std::isxdigit(c); }))
        return std::nullopt;
      values.push_back(std::stoi(digits, nullptr, 16));
    }
    return values;
  }
  return parse_numbers(text, std::size_t(1 + std::ranges::count(text, ',')));
}

/// What the options name: photographs, labels, or charts.
StitchRegions asked_regions(Run& run, const TexturedModel& scene, const TextureSignal& target) {
  const OptionValues& options = run.options();
  if (has_partials(options)) {
    std::vector<Partial> photographs = read_partials(options, scene, target);
    std::vector<int> wanted;
    if (!options.texts("labels").empty())
      wanted = asked_photographs(options, scene, target, int(photographs.size()));
    return regions_of_photographs(std::move(photographs), wanted);
  }
  std::optional<std::vector<double>> unseen_colour;
  if (options.has("unseen")) unseen_colour = parse_label(options.text("unseen"));
  return regions_of_labels(scene, target, read_labels(options), unseen_colour, run.terminal());
}

struct Stitched {
  Filtered filtered;
  BorderJump before, after;  ///< between regions
};

/// Charts of one baked texture are meant to differ, those of photographs are not: who did not say which are there
/// is told.
void report_gain(Run& run, double gain) {
  constexpr double noticed = 1.15;
  run.result["largest_gain"] = gain;
  if (gain > noticed && !asks_for(run.options(), "labels") && !asks_for(run.options(), "partial"))
    run.terminal().remark(fmt::format(
        "charts became brighter or darker, by a factor of up to {:.2g}, as photographs exposed unlike want it; of a "
        "texture that was baked or painted as one the verb seams changes borders alone",
        gain));
}

Borders asked_borders(const OptionValues& options) {
  const std::string name = options.text("borders");
  return name == "level" ? Borders::level : name == "published" ? Borders::published : Borders::continued;
}

Stitched solve(Run& run, const Model& model, const TextureSignal& target, double weight,
               const StitchRegions& regions) {
  Stitched stitched;
  solve_as_asked(run, target, [&](const SolverFactory& factory, const SolvingShares& shares) {
    const Borders borders = asked_borders(run.options());
    std::unique_ptr<Stitcher> stitcher;
    {
      const Step step(run, "prepare", shares.prepare);
      stitcher = std::make_unique<Stitcher>(
          target.space(), weight, regions.labels, factory, step,
          borders == Borders::published ? Stitcher::Systems::one_each : Stitcher::Systems::kept);
    }
    stitcher->set_borders(borders);
    const Step step(run, "solve", shares.solve);
    const RegionLevels levels = asked_levels(run.options(), model, *stitcher, regions.values);
    if (levels.gains().size() > 0) report_gain(run, std::exp(levels.gains().cwiseAbs().maxCoeff()));
    stitched.filtered = stitcher->stitch(regions.values, regions.partials, levels, step);
    stitched.before = border_jump(stitcher->stiffness(), regions.values, regions.labels);
    stitched.after = border_jump(stitcher->stiffness(), stitched.filtered.signal, regions.labels);
    return stitched.filtered.report;
  });
  return stitched;
}

Json border_json(const BorderJump& jump) {
  return {{"across", jump.across}, {"within", jump.within}};
}

/// Says how many regions there are, and refuses none.
void describe(Run& run, const StitchRegions& regions) {
  require(regions.count() > 0,
          run.options().text("mesh") + ": no texel is seen, so there is nothing to stitch; " +
              "check --unseen and confidences");
  run.result["regions"] = regions.count();
  run.result["unseen"] = regions.count_unseen();
  if (run.options().has("unseen") && regions.count_unseen() == 0)
    run.terminal().warning(
        fmt::format("--unseen {}: no texel has this label, so every region counts as seen",
                    run.options().text("unseen")));
  if (!regions.is_stitchable())
    run.terminal().remark("there is one region only, so nothing to stitch");
}

/// Says so where seams are not better than they were.
void compare_seams(Run& run) {
  const Json& seams = run.result["seams"];
  for (const char* what : {"rms", "largest"}) {
    const double before = seams["before"][what], after = seams["after"][what];
    if (after > 1.01 * before && after > 1e-3)
      run.terminal().warning(fmt::format(
          "textures jump more across seams than before ({} {:.3g}, was {:.3g}): single texels "
          "where "
          "charts are smaller than a few texels, or share them, are far off; look at them, and try {}a larger texture",
          what, after, before, run.options().text("space") == "stored" ? "" : "--space stored, or "));
  }
}

Exit stitch(Run& run) {
  const OptionValues& options = run.options();
  TexturedModel scene = read_usable_model(run, MissingPictures::refuse, 0.03);
  require(scene.atlas.has_value(),
          scene.model.path.string() + ": has no texture coordinates"
              ", so no textures to stitch; the verb unwrap makes some");
  const Outputs outputs(options.text("output"), scene.model, Outputs::Kind::pictures);
  run.will_write(outputs.paths(), outputs.folders());
  check_pictures(options, scene, {"labels"});
  check_partials(options, scene);
  if (run.dry_run()) return Exit::done;

  std::unique_ptr<TextureSignal> target;
  StitchRegions regions;
  about(scene.model, [&] {
    const Step step(run, "assemble", 0.31);
    target = make_texture_signal(run, scene,
                                 {.values = value_space(options), .depth = asked_depth(options)},
                                 step.progress().step("space", 0.5));
    regions = asked_regions(run, scene, *target);
    if (has_partials(options)) target->put(target->values(), regions.values, scene.model);
    describe(run, regions);
  });
  const SurfaceScale scale = target->space().scale();
  const double weight = spread_weight(options, scale);
  const Json seams = seams_json(scene, *target);
  Stitched stitched;
  if (regions.is_stitchable()) {
    about(scene.model, [&] { stitched = solve(run, scene.model, *target, weight, regions); });
  } else {
    const BorderJump jump = border_jump(target->space().stiffness(), regions.values, regions.labels);
    stitched = {{regions.values, nothing_to_solve()}, jump, jump};
    run.solve = solve_json(stitched.filtered.report);
    run.solve["tried"] = Json::array();
  }

  const Signal &before = regions.values, &after = stitched.filtered.signal;
  run.result.update(change_json(before, after, value_space(options).space));
  run.result["borders"] = {{"before", border_json(stitched.before)}, {"after", border_json(stitched.after)}};
  run.result["mean_drift"] = mean_drift(target->space(), before, after, regions.labels);
  run.result["alpha"] = weight / scale.area;
  run.result["length"] = std::sqrt(weight);

  const Step step(run, "write", 0.04);
  target->put(before, after, scene.model);
  spread_past_unseen(regions.labels, target->space(), scene, scene.model);
  run.result["seams"] = {{"before", seams}, {"after", seams_json(scene, *target)}};
  compare_seams(run);
  set_depth(options, scene.model);
  write_outputs(run, outputs, std::move(scene.model), step);
  return Exit::done;
}

}  // namespace

Verb stitch_verb() {
  using Type = Option::Type;
  OptionTable table("stitch",
                    "Take the steps out of a texture where photographs meet, or make one texture "
                    "of several photographs.");
  table.example("scan.obj -o stitched.obj", "no steps, where every chart is a photograph");
  table.example("scan.obj --partial left.png --partial right.png -o one.png", "one texture of two, by their alpha");
  for (const char* name : {"views", "cameras", "images", "poses"})
    table.elsewhere(name, "the verb texture takes photographs with their cameras, chooses among them and stitches them");
  add_model_options(table);
  add_model_output_option(table);
  add_labels_option(table);
  table.add({.name = "unseen",
             .type = Type::text,
             .accepts = [](const std::string& text) { return parse_label(text).has_value(); },
             .wanted = "a value as stored, such as 0, or one per channel, or #rrggbb",
             .metavar = "COLOUR",
             .group = "Regions",
             .help = "the label of texels that no photograph shows: they are filled in"});
  add_partial_options(table);
  add_levels_option(table);
  add_borders_option(table);
  add_spread_options(table, usual_photograph_length, "Stitch", "how far steps between photographs are spread");
  add_solver_options(table);
  add_space_option(table);
  add_depth_option(table);
  add_frames_option(table);
  return {table,
          stitch,
          {{.what = "steps between regions taken out, what is unseen filled",
            .vertices = "in the library",
            .pictures = "yes, with `--labels`"}}};
}

}  // namespace mq::app
