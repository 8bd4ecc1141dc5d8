// marquetry track SEQUENCE -o OUT.evolving: one triangulation that follows a sequence of meshes,
// each of which is a mesh of its own. The first frame is the template.
#include "mq/base/error.h"
#include "shell/results.h"
#include "shell/verb.h"
#include "verbs/shared/render_request.h"
#include "verbs/shared/tracking_run.h"

namespace mq::app {
namespace {

Exit track(Run& run) {
  const bool is_remeshed = run.options().flag("remesh");
  require(is_remeshed || !run.options().flag("keyframes"),
          "--keyframes: it says what --remesh replaces, which is not given");
  const Json measured = track_sequence(run, is_remeshed ? Remeshing::parts : Remeshing::none, 1);
  if (run.dry_run()) return Exit::done;
  run.result = measured;
  run.terminal().safe("");
  say_written(run, followed_paths(run.options()));
  return Exit::done;
}

}  // namespace

Verb track_verb() {
  OptionTable table("track",
                    "Follow a sequence of meshes with one triangulation, so that a triangle is the "
                    "same piece of the surface in every frame.");
  table.example("frame_%04d.ply -o walk.evolving", "follow a sequence with its first mesh");
  table.example("frame_%04d.ply --remesh -o walk.evolving", "and replace triangles where it deviates");
  table.example("frame_%04d.ply --shard 2/4 -o part_%d.evolving", "the second of four parts, on one of four machines");
  table.example("frame_%04d.ply --motion part_%d.evolving -o walk.evolving", "all parts joined");
  add_tracking_options(table);
  add_part_option(table);
  table.add({.name = "remesh",
             .group = "Sequence",
             .help = "replace what deviates from a frame by the frame's own triangles",
             .details = "As the verb remesh does, with its own tolerances; the rest lives on."});
  add_remeshing_options(table);
  add_view_option(table, "Pictures");
  return {table, track, {}, tracking_fields()};
}

}  // namespace mq::app
