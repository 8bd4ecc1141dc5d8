// marquetry evolve SEQUENCE -o OUT.evolving: track --remesh, then unwrap: one mesh that changes
// only where it must, and one atlas for all of its frames.
//
// The store is there without texture coordinates until the sequence has been followed to its end,
// so that --resume can go on with it.
#include <algorithm>

#include "shell/results.h"
#include "shell/verb.h"
#include "verbs/shared/render_request.h"
#include "verbs/shared/tracking_run.h"
#include "verbs/shared/unwrap_evolving.h"

namespace mq::app {
namespace {

constexpr double tracking_share = 0.75;  // of the time

/// Whether half of the frames or more have something that only passes.
bool is_noisy(const Json& frames) {
  const auto noisy = std::ranges::count_if(frames, [](const Json& frame) { return frame.value("passing", 0) > 0; });
  return noisy > 0 && 2 * noisy >= std::ssize(frames);
}

Exit evolve(Run& run) {
  const OptionValues& options = run.options();
  require_picture_name(options, "picture");
  if (options.has("picture")) run.will_write({options.text("picture")});
  const Json measured = track_sequence(run, Remeshing::parts, tracking_share);
  if (run.dry_run()) return Exit::done;
  run.result = measured;
  const std::filesystem::path output = options.text("output");
  unwrap_store(run, EvolvingReader(output), output, 1 - tracking_share);
  std::vector<std::filesystem::path> paths = followed_paths(options);
  if (options.has("picture")) paths.emplace_back(options.text("picture"));
  if (!options.has("look-ahead") && is_noisy(measured["frames"]))
    run.terminal().remark("most frames have holes or handles that only pass, as noisy captures do: with --look-ahead 0 "
                          "texture coordinates of long ones last longer, in fewer charts at a time ('unwrap' makes an atlas anew)");
  run.terminal().safe("");
  say_written(run, paths);
  return Exit::done;
}

}  // namespace

Verb evolve_verb() {
  OptionTable table("evolve",
                    "Make one mesh of a captured sequence, which changes only where it must, with "
                    "one texture atlas for all frames.");
  table.example("frame_%04d.ply -o walk.evolving", "one mesh and one atlas of a captured sequence");
  table.example("captured/ -o walk.evolving --frames 1-30", "of its first 30 frames");
  add_tracking_options(table);
  add_remeshing_options(table);
  add_atlas_options(table);
  add_evolving_atlas_options(table);
  table.elsewhere("shard", "track --remesh --shard follows parts, and --motion joins them here");
  return {table, evolve, {}, tracking_fields()};
}

}  // namespace mq::app
