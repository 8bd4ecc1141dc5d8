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
#include <set>

#include "shell/arguments.h"
#include "verbs/shared/input_pictures.h"
#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/filter/modulation.h"
#include "mq/filter/stitch.h"
#include "mq/model/photographs.h"
#include "shell/results.h"
#include "verbs/shared/partials.h"
#include "shell/run.h"
#include "options/model_options.h"
#include "verbs/shared/seam_report.h"
#include "options/signal_options.h"
#include "options/solver_options.h"
#include "shell/verb.h"

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

std::vector<int> read_labels(Run& run, const TexturedModel& scene, const TexelSpace& space) {
  const OptionValues& options = run.options();
  const std::vector<std::string> files = options.texts("labels");
  if (files.empty()) return space.texels().chart;
  std::vector<Image<float>> pictures;
  std::optional<std::vector<float>> unseen_colour;
  for (const std::string& file : files) {
    const Texture texture = read_texture(file);
    require(texture.format.file_format != "jpeg",
            file +
                ": --labels: JPEG does not keep colours exactly, so that regions cannot be told "
                "apart: save it as PNG");
    if (options.has("unseen")) {
      const double most = texture.format.depth == Depth::u8    ? 255
                          : texture.format.depth == Depth::u16 ? 65535
                                                               : 1;
      const std::vector<double> values = *parse_label(options.text("unseen"));
      unseen_colour.emplace();
      const int colours = colour_channels(texture.pixels.channels());
      require(values.size() == 1 || int(values.size()) == colours,
              fmt::format("{}: --unseen: has {}, found {}", file,
                          counted(colours, "colour channel"), options.text("unseen")));
      for (int c = 0; c < colours; ++c)
        unseen_colour->push_back(float(values[values.size() == 1 ? 0 : std::size_t(c)] / most));
    }
    const TextureSize size = scene.texture_sizes[pictures.size()];
    if (texture.pixels.width() != size.width || texture.pixels.height() != size.height)
      run.terminal().remark(fmt::format(
          "{}: {} × {} pixels, where the texture has {} × {}: each texel takes the nearest one's label",
          file, texture.pixels.width(), texture.pixels.height(), size.width, size.height));
    pictures.push_back(texture.pixels);
  }
  return labels_of_pictures(space.texels(), scene.texture_sizes, pictures, unseen_colour);
}

/// What is stitched: the signal put together, its regions, and the change its gradient needs.
struct Work {
  Signal psi;
  std::vector<int> labels;
  std::vector<Partial> partials;  ///< none: the signal is the model's
  SparseMatrix stiffness = {};    ///< once it was solved
};

Json border_json(const SparseMatrix& S, const Signal& psi, const std::vector<int>& labels) {
  const BorderJump jump = border_jump(S, psi, labels);
  return {{"across", jump.across}, {"within", jump.within}};
}

Filtered solve(Run& run, const TextureSignal& target, double weight, Work& work) {
  Filtered result;
  solve_as_asked(run, target, [&](const SolverFactory& factory, const SolvingShares& shares) {
    std::unique_ptr<Stitcher> stitcher;
    {
      const Step step(run, "prepare", shares.prepare);
      stitcher = std::make_unique<Stitcher>(target.space(), weight, work.labels, factory, step);
    }
    const Step step(run, "solve", shares.solve);
    const Signal psi = stitcher->fill(work.psi, step.progress().step("fill", 0.3));
    const Signal change = work.partials.empty()
                              ? stitcher->change(psi)
                              : stitcher->change(work.partials, {psi, work.labels});
    result = stitcher->solve(psi, change, step.progress().step("stitch", 0.7));
    work.stiffness = stitcher->stiffness();
    return result.report;
  });
  return result;
}

/// Whether there is anything to stitch.
bool describe(Run& run, const Work& work) {
  std::set<int> labels(work.labels.begin(), work.labels.end());
  labels.erase(unseen);
  require(!labels.empty(),
          run.options().text("mesh") + ": no texel is seen, so there is nothing to stitch; " +
              (run.options().has("views") ? "check the cameras with the verb render, and --steepest and --bias"
                                          : "check --unseen and confidences"));
  run.result["regions"] = labels.size();
  run.result["unseen"] = std::ranges::count(work.labels, unseen);
  if (run.options().has("unseen") && run.result["unseen"] == 0)
    run.terminal().warning(
        fmt::format("--unseen {}: no texel has this label, so every region counts as seen",
                    run.options().text("unseen")));
  if (labels.size() > 1 || std::ranges::count(work.labels, unseen) > 0) return true;
  run.terminal().remark("there is one region only, so nothing to stitch");
  return false;
}

/// Says so where seams are not better than they were.
void compare_seams(Run& run) {
  const Json& seams = run.result["seams"];
  for (const char* what : {"rms", "largest"}) {
    const double before = seams["before"][what], after = seams["after"][what];
    if (after > 1.01 * before && after > 1e-3)
      run.terminal().warning(fmt::format(
          "textures jump more across seams than before ({} {:.3g}, was {:.3g}): single texels where "
          "charts are smaller than a few texels, or share them, are far off; look at them, and try "
          "--space stored, or a larger texture",
          what, after, before));
  }
}

Exit stitch(Run& run) {
  const OptionValues& options = run.options();
  TexturedModel scene = read_usable_model(
      run, has_views(options) ? MissingPictures::assume : MissingPictures::refuse, 0.2);
  require(scene.atlas.has_value(),
          scene.model.path.string() + ": has no texture coordinates, so no textures to stitch");
  if (has_views(options)) add_missing_pictures(scene);
  const Outputs outputs(options.text("output"), scene.model, Outputs::Kind::pictures);
  run.will_write(outputs.paths(), outputs.folder());
  check_pictures(options, scene, {"labels"});
  check_partials(options, scene);
  if (run.dry_run()) return Exit::done;

  std::unique_ptr<TextureSignal> target;
  Work work;
  bool anything = true;
  about(scene.model, [&] {
    const Step step(run, "assemble", 0.2);
    target = make_texture_signal(run, scene, {.values = value_space(options)},
                                 step.progress().step("space", 0.5));
    work.psi = target->values();
    if (has_partials(options)) {
      work.partials =
          read_partials(run, scene, *target, step.progress().step("partial textures", 0.5));
      std::vector<int> wanted;
      if (!options.texts("labels").empty())
        wanted = asked_photographs(options, scene, target->space(),
                                   int(work.partials.size()));
      Composite composite = best_of(work.partials, wanted);
      target->put(work.psi, composite.values, scene.model);
      work.psi = std::move(composite.values);
      work.labels = std::move(composite.labels);
    } else {
      work.labels = read_labels(run, scene, target->space());
    }
    anything = describe(run, work);
  });
  const SurfaceScale scale = target->space().scale();
  const double weight = spread_weight(options, scale);
  const Json seams = seams_json(scene);
  Filtered result;
  if (anything) {
    about(scene.model, [&] { result = solve(run, *target, weight, work); });
  } else {
    work.stiffness = target->space().stiffness();
    result = {work.psi, nothing_to_solve()};
    run.solve = solve_json(result.report);
    run.solve["tried"] = Json::array();
  }

  run.result.update(change_json(work.psi, result.signal, value_space(run.options()).space));
  const SparseMatrix& S = work.stiffness;
  run.result["borders"] = {{"before", border_json(S, work.psi, work.labels)},
                           {"after", border_json(S, result.signal, work.labels)}};
  run.result["mean_drift"] =
      mean_drift(target->space(), work.psi, result.signal, work.labels);
  run.result["alpha"] = weight / scale.area;
  run.result["length"] = std::sqrt(weight);

  const Step step(run, "write", 0.1);
  target->put(work.psi, result.signal, scene.model);
  run.result["seams"] = {{"before", seams}, {"after", seams_json(scene)}};
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
  add_model_options(table);
  add_output_option(table);
  table.add({.name = "labels",
             .type = Type::path,
             .count = Option::Count::many,
             .group = "Regions",
             .help = "a picture per texture: texels of one colour come from one photograph",
             .details = "Taken at the nearest pixel, transparent ones are unseen. Without it every "
                        "chart is a region. With --partial or --views its first channel is the "
                        "number, from 0, of the photograph that each texel comes from; where that "
                        "does not show it, and where labels are transparent, the one that does best "
                        "is taken."});
  table.add({.name = "unseen",
             .type = Type::text,
             .accepts = [](const std::string& text) { return parse_label(text).has_value(); },
             .wanted = "a value as stored, such as 0, or one per channel, or #rrggbb",
             .metavar = "COLOUR",
             .group = "Regions",
             .help = "the label of texels that no photograph shows: they are filled in"});
  add_partial_options(table);
  add_spread_options(table, {usual_stitch_alpha, Length::Unit::alpha}, "Stitch",
                     "how far corrections spread: weight of gradients on the surface scaled to "
                     "unit area");
  add_solver_options(table);
  add_space_option(table);
  add_depth_option(table);
  table.exclusive({"partial", "views"});
  add_frames_option(table);
  return {table, stitch,
          {{.what = "steps between regions taken out, what is unseen filled",
            .vertices = "in the library",
            .pictures = "yes, with `--labels`"}}};
}

}  // namespace mq::app
