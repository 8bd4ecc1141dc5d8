// marquetry seams MESH [TEXTURE...] -o OUT: texels at seams chosen so that no seam shows.
//
// Hardware interpolates bilinearly in each chart for itself, so the two sides of a seam differ even
// where a texture is right at every texel. The texels that seams read are changed so that the two
// sides agree, as smoothly as can be.
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "mq/base/error.h"
#include "mq/filter/seam_values.h"
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

Exit seams(Run& run) {
  const OptionValues& options = run.options();
  TexturedModel scene = read_usable_model(run, MissingPictures::refuse, 0.1);
  refuse_normals_of_colours(options, scene.model);
  const std::string file = scene.model.path.string();
  require(scene.atlas.has_value(), file + ": has no texture coordinates, so no seams; the verb unwrap makes some");
  const Outputs outputs(options.text("output"), scene.model, Outputs::Kind::pictures);
  run.will_write(outputs.paths(), outputs.folders());
  if (run.dry_run()) return Exit::done;
  if (scene.atlas->seam_count == 0) run.terminal().remark(file + ": has no seams");

  std::unique_ptr<TextureSignal> target;
  Signal before, after;
  std::vector<char> free;
  Json difference;
  about(scene.model, [&] {
    {
      const Step step(run, "assemble", 0.35);
      target = make_texture_signal(run, scene,
                                   {.values = value_space(options),
                                    .space = soft_seams(*scene.atlas, options.number("weight")),
                                    .shared = TextureSignalOptions::SharedTexels::as_normals_need,
                                    .depth = asked_depth(options)},
                                   step);
      free = seam_texels(scene.surface, *target->texel_atlas(), target->space());
      difference = seams_json(scene, *target);
    }
    const auto at_seams = std::ranges::count(free, 1);
    if (2 * at_seams > std::ssize(free))
      run.terminal().warning(
          fmt::format("{} of {} texels are at seams: the picture changes as a whole and loses "
                      "contrast; a larger texture has more texels between its seams",
                      at_seams, std::ssize(free)));
    const Step step(run, "solve", 0.4);
    before = target->values();
    Filtered found = smooth_at_seams(target->space(), before, free, Smooth::change,
                                     economical_solver(), step);
    report_solve_at_seams(run, found.report);
    after = std::move(found.signal);
  });
  run.result = change_json(before, after);
  run.result["seam_texels"] = std::ranges::count(free, 1);
  const Step step(run, "write", 0.15);
  target->put(before, after, scene.model);
  run.result["seams"] = {{"before", difference}, {"after", seams_json(scene, *target)}};
  set_depth(options, scene.model);
  write_outputs(run, outputs, std::move(scene.model), step);
  return Exit::done;
}

}  // namespace

Verb seams_verb() {
  OptionTable table("seams",
                    "Change the texels at seams as smoothly as can be so that both sides agree and "
                    "no seam shows.");
  table.example("scan.obj -o even.obj", "the same colours on both sides of every seam");
  add_model_options(table);
  add_model_output_option(table);
  add_seam_weight_option(table);
  add_space_option(table);
  add_normals_option(table);
  add_depth_option(table);
  add_frames_option(table);
  return {table, seams,
          {{.what = "seams that do not show", .vertices = "", .pictures = ""}},
          {},
          Slots::several};
}

}  // namespace mq::app
