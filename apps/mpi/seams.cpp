// mpirun -n N marquetry-mpi seams MESH [TEXTURE...] -o FOLDER/: texels at seams chosen so that no seam shows, the
// texels parted among processes.
#include <optional>

#include "mq/filter/seam_values.h"
#include "options/model_options.h"
#include "options/signal_options.h"
#include "options/solver_options.h"
#include "seam_texels.h"
#include "shell/results.h"
#include "shell/run.h"
#include "textures.h"
#include "verbs.h"
#include "verbs/shared/seam_weights.h"

namespace mq::shared {
namespace {

using app::Exit;
using app::Run;
using app::Step;

Exit seams(Run& run) {
  const Processes processes;
  std::optional<Outputs> outputs;
  const TexturedModel scene = read_scene(run, processes, "seams", outputs, [](const OptionValues&) {});
  if (run.dry_run()) return Exit::done;
  const std::unique_ptr<TexelPart> part =
      part_of(run, processes, scene, soft_seams(*scene.atlas, run.options().number("weight")));
  Signal before = read_values(run, processes, scene, *part);
  const std::unique_ptr<Numbering> numbering = numbered(processes, *part, before);
  std::vector<char> free(part->places().size(), 0);
  processes.together([&] {
    if (!part->empty()) free = seam_texels(scene.surface, part->atlas(), part->space());
  });
  Filtered found;
  {
    const Step step(run, "solve", 0.5);
    found = shared_smooth_at_seams(processes, *part, *numbering, before, free, Smooth::change);
  }
  part->let_go_of_space();
  run.result["seam_texels"] = count_own(processes, *part, free);
  run.solve = app::solve_json(found.report);
  write_result(run, processes, scene, *part, *outputs, before, found.signal);
  return Exit::done;
}

}  // namespace

app::Verb seams_verb() {
  OptionTable table("seams", "Change the texels at seams as smoothly as can be so that both sides agree, by several "
                             "processes.");
  describe_program(table);
  table.example("castle.obj -o out/", "the same colours on both sides of every seam");
  app::add_model_options(table);
  app::add_output_option(table);
  app::add_seam_weight_option(table);
  app::add_space_option(table);
  app::add_depth_option(table);
  for (const char* name : {"normals", "normal-space", "frames", "compress"}) table.elsewhere(name, not_yet("seams"));
  return {table, seams};
}

}  // namespace mq::shared
