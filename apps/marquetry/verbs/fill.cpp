// marquetry fill MESH [TEXTURE...] -o OUT: values for the texels outside charts.
//
// First those that lookups at the borders of charts read: the smoothest for which the two sides of
// each seam agree, with everything inside charts as it is. Then all others, each from the nearest
// that a triangle covers, so that no level of a mipmap mixes in what was there before.
#include <fmt/format.h>

#include <memory>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/model/texture_fill.h"
#include "shell/arguments.h"
#include "shell/results.h"
#include "shell/run.h"
#include "options/model_options.h"
#include "verbs/shared/seam_report.h"
#include "verbs/shared/seam_weights.h"
#include "options/signal_options.h"
#include "options/solver_options.h"
#include "shell/verb.h"

namespace mq::app {
namespace {

FillOptions asked_fill(const OptionValues& options) {
  FillOptions fill{.values = value_space(options),
                   .weight = options.number("weight"),
                   .depth = asked_depth(options)};
  if (options.has("distance")) fill.distance = options.number("distance");
  return fill;
}

/// Holes inside charts are none of this verb's.
void say_what_is_transparent(Run& run, const Signal& values) {
  const bool has_alpha = values.cols() == 2 || values.cols() == 4;
  const std::int64_t holes = has_alpha ? (values.col(values.cols() - 1).array() == 0).count() : 0;
  if (holes > 0)
    run.terminal().remark(fmt::format(
        "{} inside charts have alpha 0 and stay as they are, as this verb gives values to those outside; holes "
        "are filled by the verb stitch, with --labels and --unseen",
        counted(holes, "texel")));
}

Exit fill(Run& run) {
  const OptionValues& options = run.options();
  TexturedModel scene = read_usable_model(run, MissingPictures::refuse, 0.08);
  refuse_normals_of_colours(options, scene.model);
  require(scene.atlas.has_value(),
          scene.model.path.string() + ": has no texture coordinates, so no charts to fill around; the verb unwrap makes some");
  const Outputs outputs(options.text("output"), scene.model, Outputs::Kind::pictures);
  run.will_write(outputs.paths(), outputs.folders());
  if (run.dry_run()) return Exit::done;

  std::unique_ptr<TextureFill> filling;
  TextureFill::Solution solution;
  Json difference;
  about(scene.model, [&] {
    {
      const Step step(run, "assemble", 0.47);
      filling = std::make_unique<TextureFill>(scene, asked_fill(options), run.terminal(), step);
      say_defects(run, filling->signal());
      difference = seams_json(scene, filling->signal());
    }
    const Step step(run, "solve", 0.25);
    solution = filling->solve(step);
    report_solve_at_seams(run, solution.report);
  });
  say_what_is_transparent(run, solution.before);
  run.result = change_json(solution.before, solution.after);
  run.result["border_texels"] = filling->border_texels();
  const Step step(run, "write", 0.2);
  run.result["outside_texels"] = filling->put(solution, scene.model);
  run.result["seams"] = {{"before", difference}, {"after", seams_json(scene, filling->signal())}};
  set_depth(options, scene.model);
  write_outputs(run, outputs, std::move(scene.model), step);
  return Exit::done;
}

}  // namespace

Verb fill_verb() {
  OptionTable table("fill",
                    "Give the texels outside charts values that go on from inside, so that neither "
                    "seams nor smaller levels of a mipmap show what was there.");
  table.example("scan.obj -o filled.obj", "colours for the texels outside charts");
  add_model_options(table);
  add_model_output_option(table);
  add_fill_options(table);
  add_space_option(table);
  add_normals_option(table);
  add_depth_option(table);
  add_frames_option(table);
  return {table, fill,
          {{.what = "texels outside charts", .vertices = "", .pictures = ""}},
          {},
          Slots::several};
}

}  // namespace mq::app
