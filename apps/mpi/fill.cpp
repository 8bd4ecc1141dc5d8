// mpirun -n N marquetry-mpi fill MESH [TEXTURE...] -o FOLDER/: values for the texels outside charts, the texels parted
// among processes.
//
// Those that lookups at the borders of charts read are solved for by all; what is farther outside gets the value of the
// nearest that a triangle covers in the process that writes the picture.
#include <algorithm>
#include <limits>
#include <optional>

#include "mq/filter/chart_borders.h"
#include "mq/model/texture_fill.h"
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

/// Nothing beyond the range that each channel has, in any process.
void keep_in_range(const Processes& processes, const TexelPart& part, const Signal& before,
                   const std::vector<char>& border, Signal& after) {
  const ValueRange range = shared_range(processes, part, before, std::vector<char>(border.size(), 1));
  for (const int i : part.own())
    if (border[std::size_t(i)]) after.row(i) = after.row(i).cwiseMax(range.low).cwiseMin(range.high);
}

/// Of each texture that this process writes the texels at borders of charts, whoever has them.
std::vector<std::vector<Texels::Place>> gathered_borders(const Processes& processes, const TexelPart& part,
                                                         std::size_t textures, const std::vector<char>& border) {
  const std::vector<int> writer = writers(processes, part, textures);
  std::vector<std::vector<Texels::Place>> sent(std::size_t(processes.count()));
  for (const int i : part.own())
    if (const Texels::Place& at = part.places()[std::size_t(i)]; border[std::size_t(i)])
      sent[std::size_t(writer[std::size_t(at.texture)])].push_back(at);
  std::vector<std::vector<Texels::Place>> all(textures);
  processes.talking([&] {
    for (const auto& from : processes.exchange(sent))
      for (const Texels::Place& at : from) all[std::size_t(at.texture)].push_back(at);
  });
  return all;
}

/// The atlas with the charts of one texture alone: no other takes memory.
Atlas atlas_of(const Surface& surface, const Atlas& whole, int texture) {
  Atlas one = whole;
  for (std::size_t t = 0; t < one.chart.size(); ++t)
    if (surface.mesh.texture(int(t)) != texture) one.chart[t] = -1;
  for (std::size_t k = 0; k < one.textures.size(); ++k)
    if (int(k) != texture) one.textures[k].width = one.textures[k].height = 1;
  return one;
}

Exit fill(Run& run) {
  const Processes processes;
  const OptionValues& options = run.options();
  std::optional<Outputs> outputs;
  const TexturedModel scene = read_scene(run, processes, "fill", outputs, [](const OptionValues&) {});
  if (run.dry_run()) return Exit::done;
  const std::unique_ptr<TexelPart> part =
      part_of(run, processes, scene, soft_seams(*scene.atlas, options.number("weight")));
  Signal before = read_values(run, processes, scene, *part);
  const std::unique_ptr<Numbering> numbering = numbered(processes, *part, before);
  std::vector<char> border(part->places().size(), 0);
  processes.together([&] {
    if (!part->empty()) border = border_texels(part->space(), texel_coverage(scene.surface, part->atlas()));
  });
  Filtered found;
  {
    const Step step(run, "solve", 0.4);
    found = shared_smooth_at_seams(processes, *part, *numbering, before, border, Smooth::values);
  }
  part->let_go_of_space();
  keep_in_range(processes, *part, before, border, found.signal);
  run.solve = app::solve_json(found.report);
  const auto borders = gathered_borders(processes, *part, scene.texture_sizes.size(), border);
  double outside = 0;
  const double distance =
      options.has("distance") ? options.number("distance") : std::numeric_limits<double>::infinity();
  write_result(run, processes, scene, *part, *outputs, before, found.signal, [&](std::size_t k, Texture& picture) {
    const Atlas atlas = atlas_of(scene.surface, *scene.atlas, int(k));
    const std::vector<Coverage> coverage = texel_coverage(scene.surface, atlas);
    outside += double(spread_past_borders(borders[k], coverage[k], distance, picture.pixels));
  });
  processes.sum({&outside, 1});
  run.result["border_texels"] = count_own(processes, *part, border);
  run.result["outside_texels"] = std::int64_t(outside);
  return Exit::done;
}

}  // namespace

app::Verb fill_verb() {
  OptionTable table("fill", "Give the texels outside charts values that go on from inside, by several processes.");
  describe_program(table);
  table.example("castle.obj -o out/", "colours for the texels outside charts");
  app::add_model_options(table);
  app::add_output_option(table);
  app::add_fill_options(table);
  app::add_space_option(table);
  app::add_depth_option(table);
  for (const char* name : {"normals", "normal-space", "frames", "compress"}) table.elsewhere(name, not_yet("fill"));
  return {table, fill};
}

}  // namespace mq::shared
