#include "verbs/shared/unwrap_evolving.h"

#include <fmt/format.h>

#include <algorithm>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/baseline/forgetful.h"
#include "mq/draw/lifespans.h"
#include "mq/evolving/lifespan_atlas.h"
#include "mq/io/evolving_file.h"
#include "mq/io/image_file.h"
#include "mq/model/stored_atlas.h"
#include "mq/model/stored_frames.h"
#include "shell/arguments.h"
#include "shell/results.h"
#include "verbs/shared/render_request.h"

namespace mq::app {
namespace {

namespace fs = std::filesystem;

constexpr int picture_side = 400;  // pixels

LifespanAtlasOptions atlas_options(const OptionValues& options) {
  LifespanAtlasOptions result;
  result.unwrap.width = result.unwrap.height = int(options.integer("size"));
  result.unwrap.gutter = int(options.integer("gutter"));
  result.unwrap.stretch = options.number("stretch");
  result.unwrap.trials = int(options.integer("trials"));
  result.charting.beta = options.number("coherence");
  if (options.has("look-ahead")) result.look_ahead = int(options.integer("look-ahead"));
  return result;
}

Json frames_json(const EvolvingMesh& evolving, const LifespanAtlas& atlas) {
  Json frames = Json::array();
  for (std::size_t f = 0; f < atlas.frames.size(); ++f)
    frames.push_back({{"frame", evolving.frames[f].number},
                      {"charts", atlas.frames[f].charts},
                      {"born", atlas.frames[f].added},
                      {"renewed", atlas.frames[f].renewed},
                      {"occupancy", atlas.frames[f].occupancy},
                      {"stretch", atlas.frames[f].stretch},
                      {"flipped", atlas.frames[f].flipped}});
  return frames;
}

void report(Run& run, const EvolvingMesh& evolving, const LifespanAtlas& atlas) {
  for (const UnwrapFigures::Seconds& seconds : atlas.seconds)
    run.add_seconds(seconds.step, seconds.seconds);
  Json cleared = Json::array();
  for (const int frame : atlas.cleared) cleared.push_back(evolving.frames[frame].number);
  run.result.update({{"charts", atlas.charts.size()},
                     {"charts_per_frame", atlas.charts_per_frame},
                     {"lifespan", atlas.lifespan},
                     {"occupancy", atlas.occupancy},
                     {"bound", atlas.bound},
                     {"stretch", atlas.stretch},
                     {"flipped", atlas.flipped},
                     {"first_charts", atlas.charting.first_charts},
                     {"first_energy", atlas.charting.first_energy},
                     {"energy", atlas.charting.energy},
                     {"energy_of_whole", atlas.energy_of_whole},
                     {"moved", atlas.moved},
                     {"plans", atlas.plans},
                     {"cleared", cleared},
                     {"edits", atlas.charting.edits}});
  Json& frames = run.result["frames"];
  const Json found = frames_json(evolving, atlas);
  for (std::size_t f = 0; f < found.size(); ++f)
    if (f < frames.size())
      frames[f].update(found[f]);
    else
      frames.push_back(found[f]);
  run.print(fmt::format(
      "{} in {}, {:.1f} in a frame; texture coordinates last for {:.1f} frames on average\n"
      "{:.1f} % of the texture, L2 stretch {:.4f} in the worst frame\n",
      counted(int(atlas.charts.size()), "chart"), counted(int(atlas.frames.size()), "frame"),
      atlas.charts_per_frame, atlas.lifespan, 100 * atlas.occupancy, atlas.stretch));
  if (run.options().has("look-ahead"))
    run.print(
        fmt::format("energy {:.3f} times that with the whole sequence known; planned {}, "
                    "the texture made anew {}\n",
                    atlas.charting.energy / atlas.energy_of_whole, counted(atlas.plans, "time"),
                    counted(int(atlas.cleared.size()), "time")));
}

}  // namespace

bool names_evolving(const fs::path& path) { return path.extension() == ".evolving"; }

void add_atlas_options(OptionTable& table) {
  using Type = Option::Type;
  table.add({.name = "size",
             .letter = 's',
             .type = Type::integer,
             .default_value = as_typed(UnwrapOptions{}.width),
             .unit = "texels",
             .least = 16,
             .most = 32768,
             .group = "Atlas",
             .help = "side of the texture that charts are packed for"});
  table.add({.name = "gutter",
             .type = Type::integer,
             .default_value = as_typed(UnwrapOptions{}.gutter),
             .unit = "texels",
             .least = 0,
             .most = 256,
             .group = "Atlas",
             .help = "that stay free between charts, and half of it at the border"});
  table.add({.name = "stretch",
             .type = Type::number,
             .default_value = as_typed(UnwrapOptions{}.stretch),
             .least = 1.0001,
             .most = 10,
             .group = "Atlas",
             .help = "the most L2 stretch that a chart may get by merging; 1 is none"});
  table.add({.name = "trials",
             .type = Type::integer,
             .default_value = as_typed(UnwrapOptions{}.trials),
             .least = 1,
             .most = 100000,
             .group = "Atlas",
             .help = "orders of packing to try; more fills the texture better, and takes longer"});
}

UnwrapOptions asked_atlas(const OptionValues& options) {
  const int size = int(options.integer("size"));
  return {.width = size,
          .height = size,
          .gutter = int(options.integer("gutter")),
          .stretch = options.number("stretch"),
          .trials = int(options.integer("trials"))};
}

void add_evolving_atlas_options(OptionTable& table) {
  using Type = Option::Type;
  const std::string group = "Evolving meshes";
  table.add({.name = "coherence",
             .type = Type::number,
             .default_value = as_typed(ChartingOptions{}.beta),
             .least = 0,
             .most = 1e6,
             .group = group,
             .help = "weight of few charts against texture coordinates that stay",
             .details = "0: neighbours that come and go together become charts, no more."});
  table.add({.name = "look-ahead",
             .type = Type::integer,
             .unit = "frames",
             .least = 0,
             .most = 1000000,
             .metavar = "N",
             .group = group,
             .help = "give a frame its texture coordinates knowing only so many after it",
             .details = "As for a sequence that goes on while its atlas is made. Without it the "
                        "whole sequence is known."});
  table.add({.name = "uv-error",
             .type = Type::number,
             .default_value = as_typed(store_uv_error),
             .unit = "texels",
             .least = 0,
             .most = 0.5,
             .group = group,
             .help = "how far u and v in OUT may be from where they were laid out",
             .details = "They are rounded to multiples of a power of two. 0: not at all."});
  table.add({.name = "renew",
             .type = Type::choice,
             .default_value = "never",
             .choices = {"never", "segments", "frames"},
             .metavar = "WHEN",
             .group = group,
             .help = "never, segments or frames: an atlas made anew, to compare with",
             .details = "segments: all of it is made anew wherever triangles are replaced, as for "
                        "keyframes. frames: in every frame. Triangles get new ids then."});
  table.add({.name = "picture",
             .type = Type::path,
             .metavar = "FILE",
             .group = group,
             .help = "draw some frames and their textures in colours of how long charts live"});
  add_view_option(table, group);
}

void unwrap_store(Run& run, const EvolvingReader& reader, const fs::path& output, double share) {
  const OptionValues& options = run.options();
  EvolvingMesh evolving;
  {
    const Step step(run, "read", 0.05 * share);
    evolving = read_frames(reader);
  }
  if (options.text("renew") != "never")
    evolving = with_new_ids(
        evolving, options.text("renew") == "frames" ? Forgetting::frames : Forgetting::segments);
  LifespanAtlas atlas;
  {
    const Step step(run, "unwrap", 0.85 * share);
    atlas = lay_out_stored(reader, evolving, atlas_options(options), step);
  }
  report(run, evolving, atlas);
  const Step step(run, "write", 0.1 * share);
  if (options.has("picture"))
    write_image(options.text("picture"),
                draw_lifespan_sheet(evolving, atlas, parse_view(options.text("view")), picture_side,
                                    step.progress().step("draw", 0.7)));
  const Json about = {{"verb", options.table().verb()},
                      {"options", options_json(options)},
                      {"of", Json::parse(reader.about(), nullptr, false)}};
  write_laid_out(reader, evolving, output, about.dump(),
                 uv_step_within(options.number("uv-error") / double(options.integer("size"))));
}

std::vector<fs::path> store_paths(const OptionValues& options) {
  const fs::path output = options.text("output");
  std::vector<fs::path> paths = {output, fs::path(output).replace_extension(".blocks")};
  if (options.has("picture")) paths.emplace_back(options.text("picture"));
  return paths;
}

Exit unwrap_evolving(Run& run) {
  const OptionValues& options = run.options();
  const fs::path input = options.text("mesh"), output = options.text("output");
  require(names_evolving(output),
          fmt::format("--output: found '{}', wanted a name that ends in .evolving, as the input's",
                      output.string()));
  const EvolvingReader reader(input);
  run.will_read(input);
  run.will_read(reader.blocks_file());
  run.will_write(store_paths(options));
  warn_of_broken(run.terminal(), reader);
  run.input = {{"frames", reader.frames().size()}, {"segments", reader.segments().size()}};
  if (run.dry_run()) return Exit::done;
  unwrap_store(run, reader, output, 1);
  say_written(run, store_paths(options));
  return Exit::done;
}

}  // namespace mq::app
