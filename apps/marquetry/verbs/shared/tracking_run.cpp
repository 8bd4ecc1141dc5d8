#include "verbs/shared/tracking_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <string>

#include "mq/base/error.h"
#include "mq/io/evolving_file.h"
#include "mq/io/frame_files.h"
#include "mq/io/model.h"
#include "mq/io/path_status.h"
#include "mq/model/sequence_pictures.h"
#include "mq/model/sequence_tracker.h"
#include "shell/arguments.h"
#include "shell/frame_numbers.h"
#include "shell/run.h"
#include "verbs/shared/sequence_pictures.h"

namespace mq::app {
namespace {

namespace fs = std::filesystem;

constexpr int most_group_frames = 10000;

/// What decides how frames are followed: a store is gone on with as it was begun.
constexpr const char* deciding[] = {"photometric", "cycles",    "nodes",         "stiffness",
                                    "elasticity",  "angle",     "no-prediction", "restart",
                                    "within",      "keyframes", "texture",       "error",
                                    "group",       "motion",    "shard"};

/// The part of the sequence that is asked for; none: all of it.
std::optional<Shard> asked_part(const OptionValues& options) {
  const bool in_parts = std::ranges::any_of(options.table().options(),
                                            [](const Option& option) { return option.name == "shard"; });
  if (!in_parts || !options.has("shard")) return {};
  return parse_shard(options.text("shard"));
}

/// The stores of --motion.
std::vector<fs::path> asked_parts(const OptionValues& options) {
  if (!options.has("motion")) return {};
  const std::string name = options.text("motion");
  if (!has_frame_place(name)) return {name};
  std::vector<fs::path> stores;
  for (const FrameFile& part : find_frames(name)) stores.push_back(part.path);
  return stores;
}

fs::path blocks_of(const fs::path& store) { return fs::path(store).replace_extension(".blocks"); }

/// What parts of the sequence that were followed by themselves say of its motion; null: none are given.
std::shared_ptr<const KnownMotion> known_motion(Run& run) {
  const std::vector<fs::path> stores = asked_parts(run.options());
  for (const fs::path& store : stores) {
    run.will_read(store);
    run.will_read(blocks_of(store));
  }
  return stores.empty() ? nullptr : std::make_shared<StoredMotion>(stores);
}

/// Of each of the parts what its blocks are: parts that are made again are others.
Json parts_json(const OptionValues& options) {
  Json parts = Json::array();
  for (const fs::path& store : asked_parts(options)) {
    const FilePrint print = file_print(blocks_of(store));
    parts.push_back({{"part", store.filename().string()}, {"bytes", print.bytes}, {"crc32", print.crc32}});
  }
  return parts;
}

TemplateFollowerOptions follow_options(const OptionValues& options, Remeshing remeshing) {
  TemplateFollowerOptions follow;
  TrackOptions& track = follow.track;
  track.node_spacing = options.number("nodes") / 100;
  track.elasticity = options.number("elasticity");
  track.last_stiffness = options.number("stiffness");
  track.first_stiffness = first_over_last_stiffness * track.last_stiffness;
  track.most_angle = options.number("angle");
  if (options.flag("no-prediction")) track.prediction = TrackOptions::Prediction::none;
  follow.remeshing =
      remeshing != Remeshing::none && options.flag("keyframes") ? Remeshing::keyframes : remeshing;
  follow.within = options.number("within") / 100;
  if (options.has("restart")) follow.restart = options.number("restart") / 100;
  if (options.has("truth"))
    follow.truth = options.text("truth") == "uv" ? Truth::uvs : Truth::material;
  if (options.flag("photometric")) follow.colours = TemplateFollowerOptions::Colours::used;
  follow.colour_cycles = int(options.integer("cycles"));
  return follow;
}

SequenceTrackerOptions tracker_options(Run& run, Remeshing remeshing) {
  const OptionValues& options = run.options();
  SequenceTrackerOptions tracker;
  tracker.follow = follow_options(options, remeshing);
  tracker.follow.motion = known_motion(run);
  if (options.has("error")) tracker.error = options.number("error") / 100;
  if (options.flag("skip-bad")) tracker.bad_frames = SequenceTrackerOptions::BadFrames::left_out;
  if (options.flag("resume")) tracker.resume = SequenceTrackerOptions::Resume::where_possible;
  return tracker;
}

FileFrames captured_frames(Run& run) {
  const OptionValues& options = run.options();
  FileFramesOptions files;
  if (options.has("frames")) files.numbers = parse_frames(options.text("frames"));
  if (options.flag("skip-bad")) files.missing = MissingFrames::left_out;
  if (const auto part = asked_part(options)) {
    if (files.numbers.empty())
      for (const FrameFile& file : find_frames(options.text("sequence"))) files.numbers.push_back(file.number);
    asked_range(options, int(files.numbers.size()));
    files.numbers = frames_of(*part, files.numbers);
  }
  if (options.has("texture")) files.textures = options.text("texture");
  if (options.flag("photometric")) files.pictures = ReadModelOptions::Pictures::read;
  if (const std::string truth = options.has("truth") ? options.text("truth") : "uv";
      truth != "uv") {
    require(is_folder(truth) || has_frame_place(truth),
            fmt::format("--truth: found '{}', which is no folder; wanted uv, a folder that is "
                        "there, or a name with a place for the frame's number",
                        truth));
    files.material = truth;
  }
  FileFrames frames(options.text("sequence"), std::move(files), run.terminal());
  for (const fs::path& path : frames.paths()) run.will_read(path);
  return frames;
}

/// What decides how frames are followed must be as it was for those in the store.
void require_same_options(const EvolvingReader& reader, const OptionValues& options,
                          Remeshing remeshing) {
  const Json about = Json::parse(reader.about(), nullptr, false);
  if (!about.is_object() || !about.contains("options")) return;
  const Json& before = about.at("options");
  const Json now = options_json(options);
  const auto require_same = [&](const std::string& name, const Json& was, const Json& is) {
    require(was == is,
            fmt::format("{}: --resume: its frames were followed with {} {}, and now it is {}; give "
                        "the options it was made with, or go without --resume",
                        reader.manifest().string(), name, was.is_null() ? "not given" : was.dump(),
                        is.is_null() ? "not given" : is.dump()));
  };
  require_same("--remesh", about.value("verb", "") == "evolve" || before.value("remesh", false),
               remeshing != Remeshing::none);
  for (const char* name : deciding)
    require_same(std::string("--") + name, before.value(name, Json()), now.value(name, Json()));
  require(about.value("parts", Json::array()) == parts_json(options),
          fmt::format("{}: --resume: the parts of --motion are not those that its frames were followed with; go without "
                      "--resume",
                      reader.manifest().string()));
}

EvolvingStore made_store(const OptionValues& options, Remeshing remeshing) {
  const fs::path output = followed_store(options);
  require(
      output.extension() == ".evolving",
      fmt::format("--output: found '{}', wanted a name that ends in .evolving", output.string()));
  Json about = {{"verb", options.table().verb()}, {"options", options_json(options)}};
  if (options.has("motion")) about["parts"] = parts_json(options);
  const auto require_same = [&options, remeshing](const EvolvingReader& reader) {
    require_same_options(reader, options, remeshing);
  };
  return EvolvingStore(output, about.dump(), require_same,
                       options.has("group") ? int(options.integer("group")) : store_group_frames);
}

/// Says from where on the template no longer shows what was captured.
void warn_where_lost(Run& run, const std::vector<FollowedFrame>& frames, Remeshing remeshing) {
  const std::optional<LostFrame> found = first_lost(frames);
  if (!found) return;
  const std::string what =
      found->extent == LostFrame::Extent::many
          ? fmt::format(
                "5 % of the points are farther than {:.3g} % of the diagonal from "
                "what follows it: the motion was too fast or the shape changed",
                100 * found->p95)
          : fmt::format(
                "the farthest point is {:.3g} % of the diagonal from what follows "
                "it, though 95 % are within {:.2g} %: a part came, went, or "
                "touches another",
                100 * found->max, 100 * found->p95);
  run.terminal().warning(fmt::format(
      "in frame {} {}; {}--restart {:g} begins anew where 5 % are so far", found->number, what,
      remeshing == Remeshing::none ? "--remesh replaces what does not fit, " : "",
      100 * lost_distance));
}

std::string frames_table(const std::vector<FollowedFrame>& frames) {
  std::string text = fmt::format("{:>7} {:>10} {:>10} {:>10} {:>10} {:>8} {:>8}\n", "frame", "mean",
                                 "95 %", "max", "distortion", "added", "seconds");
  for (const FollowedFrame& f : frames) {
    text += fmt::format("{:>7} {:>9.4f}% {:>9.4f}% {:>9.4f}% {:>10.3f} {:>8} {:>8.2f}", f.number,
                        100 * f.distance.mean, 100 * f.distance.p95, 100 * f.distance.max,
                        f.distortion.p95, f.added, f.seconds);
    if (f.drift)
      text += fmt::format("   drift {:.5g} = {:.3f} edges", f.drift->mean, f.drift->mean_edges);
    text += '\n';
  }
  return text;
}

Json result_json(const FollowedSequence& found) {
  Json frames = Json::array(), skipped = Json::array();
  double p95 = 0, max = 0, folded = 0;
  for (const FollowedFrame& frame : found.frames) {
    frames.push_back(Json::parse(followed_text(frame)));
    p95 = std::max(p95, frame.distance.p95);
    max = std::max(max, frame.distance.max);
    folded = std::max(folded, double(frame.folded));
  }
  for (const SkippedFrame& one : found.skipped)
    skipped.push_back({{"frame", one.number}, {"why", one.why}});
  return {{"frames", std::move(frames)},
          {"skipped", std::move(skipped)},
          {"distance_p95", p95},
          {"distance_max", max},
          {"folded", folded}};
}

void add_files_options(OptionTable& table) {
  using Type = Option::Type;
  table.add({.name = "sequence",
             .place = Option::Place::positional,
             .type = Type::path,
             .required = true,
             .help = "frame_%04d.ply, or a folder of frames: OBJ, PLY, glTF or GLB"});
  table.add({.name = "output",
             .letter = 'o',
             .type = Type::path,
             .required = true,
             .metavar = "OUT",
             .help = "the evolving mesh, a name that ends in .evolving",
             .details = "Its blocks are written beside it, in a file that ends in .blocks."});
}

void add_sequence_options(OptionTable& table) {
  using Type = Option::Type;
  Option frames = frames_option();
  frames.group = "Sequence";
  frames.help = "which frames, such as 1-100 or 1-100x2; else all there are";
  table.add(frames);
  table.add({.name = "texture",
             .type = Type::path,
             .group = "Sequence",
             .help = "pictures instead of those the frames name, %04d for the number"});
  table.add({.name = "resume",
             .group = "Sequence",
             .help = "go on with OUT where it ends, if it is there",
             .details = "The result is the same as that of one run with the same options."});
  table.add({.name = "motion",
             .type = Type::path,
             .metavar = "PARTS",
             .group = "Sequence",
             .help = "join parts of the sequence that 'track --shard' followed: part_%d.evolving",
             .details = "Triangles live on from part to part, and are moved as those of the parts were, which takes a "
                        "fraction of the time. Each frame must be in one of them."});
  table.add({.name = "skip-bad",
             .group = "Sequence",
             .help = "leave out frames that are missing, cannot be read or hold no mesh to follow",
             .details = "The report lists them."});
  table.add({.name = "restart",
             .type = Type::number,
             .unit = "% of the diagonal",
             .least = 0,
             .most = 100,
             .group = "Sequence",
             .help = "begin anew with the frame's own mesh where 95 % are not within this"});
}

void add_store_options(OptionTable& table) {
  table.add({.name = "error",
             .type = Option::Type::number,
             .unit = "% of the diagonal",
             .least = 1e-7,
             .most = 10,
             .group = "Sequence",
             .help = "how far positions in OUT may be from where they were found",
             .details = "They are rounded before the next frame is followed. 0.01 is a fifth of a millimetre on a "
                        "person, and makes OUT three times smaller. Without it they are rounded to a millionth."});
  table.add({.name = "group",
             .type = Option::Type::integer,
             .unit = "frames",
             .least = 1,
             .most = most_group_frames,
             .group = "Sequence",
             .help = "after so many frames one is told by itself; else after 32",
             .details = "To show a frame, those before it in its group are read. Each group takes as many bytes as "
                        "two to eight frames more."});
}

void add_graph_options(OptionTable& table) {
  using Type = Option::Type;
  const TemplateFollowerOptions defaults;
  table.add({.name = "photometric",
             .group = "Tracking",
             .help = "let colours correct what slides along the surface",
             .details = "Colours at vertices, or textures, of the frames."});
  table.add({.name = "cycles",
             .type = Type::integer,
             .default_value = as_typed(defaults.colour_cycles),
             .least = 1,
             .most = 20,
             .group = "Tracking",
             .help = "of registration by colour in each frame"});
  table.add({.name = "nodes",
             .type = Type::number,
             .default_value = as_typed(100 * defaults.track.node_spacing),
             .unit = "% of the square root of the area",
             .least = 1,
             .most = 50,
             .group = "Tracking",
             .help = "how far nodes of the deformation graph are apart"});
  table.add({.name = "stiffness",
             .type = Type::number,
             .default_value = as_typed(defaults.track.last_stiffness),
             .least = 1e-6,
             .most = 1e6,
             .group = "Tracking",
             .help = "of the graph's edges against the distances, in the end",
             .details = "A frame begins with a thousand times as much."});
  table.add({.name = "elasticity",
             .type = Type::number,
             .default_value = as_typed(defaults.track.elasticity),
             .least = 0,
             .most = 1,
             .group = "Tracking",
             .help = "how much of the rest shape comes back in each frame"});
  table.add({.name = "angle",
             .type = Type::number,
             .default_value = as_typed(defaults.track.most_angle),
             .unit = "degrees",
             .least = 1,
             .most = 90,
             .group = "Tracking",
             .help = "between normals of points that may correspond, at most"});
  table.add({.name = "no-prediction",
             .group = "Tracking",
             .help = "begin each frame where the last one ended, not where its motion leads"});
}

}  // namespace

void add_remeshing_options(OptionTable& table) {
  table.add({.name = "within",
             .type = Option::Type::number,
             .default_value = as_typed(100 * TemplateFollowerOptions{}.within),
             .unit = "% of the diagonal",
             .least = 0.001,
             .most = 100,
             .group = "Sequence",
             .help = "how far 95 % of the points may be from a frame that is remeshed",
             .details = "Where more are, smaller differences are replaced too; what is five times "
                        "as far is replaced wherever it is."});
  table.add({.name = "keyframes",
             .group = "Sequence",
             .help = "where a part would be replaced, replace all by the frame's own mesh: what "
                     "evolving meshes are compared with"});
}

void add_part_option(OptionTable& table) {
  Option shard = shard_option();
  shard.group = "Sequence";
  shard.help = "follow only part I of N of the frames, on one of N machines";
  shard.details = "OUT then needs a place for I, part_%d.evolving, which --motion takes to join all parts.";
  table.add(shard);
  for (const char* whole : {"motion", "plot", "strip"}) table.exclusive({"shard", whole});
}

fs::path followed_store(const OptionValues& options) {
  const std::string output = options.text("output");
  const auto part = asked_part(options);
  if (!part) return output;
  require(has_frame_place(output),
          fmt::format("--output: found '{}'; with --shard the name needs a place for the part's number, such as "
                      "part_%d.evolving",
                      output));
  return frame_name(output, part->number);
}

std::vector<fs::path> followed_paths(const OptionValues& options) {
  const fs::path output = followed_store(options);
  std::vector<fs::path> paths = {output, blocks_of(output)};
  std::ranges::copy(sequence_picture_paths(options), std::back_inserter(paths));
  return paths;
}

Json track_sequence(Run& run, Remeshing remeshing, double share) {
  const OptionValues& options = run.options();
  EvolvingStore store = made_store(options, remeshing);
  const FileFrames frames = captured_frames(run);
  const SequenceTrackerOptions how = tracker_options(run, remeshing);
  run.will_write(followed_paths(options));
  run.input = {{"frames", frames.count()},
               {"first", frames.name(0)},
               {"last", frames.name(frames.count() - 1)}};
  SequenceTracker tracker(frames, store, how, run.terminal());
  if (run.dry_run()) {
    tracker.rehearse();
    return nullptr;
  }
  FollowedSequence found;
  {
    const Step step(run, "track", options.has("strip") ? 0.9 * share : share);
    found = tracker.run(step);
  }
  run.found(found.defects);
  warn_where_lost(run, found.frames, remeshing);
  write_plot(run, found.frames);
  if (options.has("strip")) {
    const Step step(run, "draw", 0.1 * share);
    const EvolvingReader reader(followed_store(options));
    write_strip(
        run, reader,
        [&](int frame) {
          return frames.with_pictures(frames.index_of(reader.frames()[frame].number));
        },
        step);
  }
  run.print(frames_table(found.frames));
  return result_json(found);
}

OptionFields tracking_fields() {
  return {{"bad_frames", "skip-bad"}, {"colours", "photometric"}, {"textures", "texture"}};
}

void add_tracking_options(OptionTable& table) {
  add_files_options(table);
  add_sequence_options(table);
  add_store_options(table);
  add_graph_options(table);
  table.add({.name = "truth",
             .type = Option::Type::text,
             .metavar = "uv|MATERIAL",
             .group = "Measuring",
             .help = "say how far vertices are from where they should be",
             .details = "MATERIAL: meshes of the same triangles whose positions are where their "
                        "material is at rest, a folder or frame_%04d.ply; sample makes them. uv: "
                        "texture coordinates are the same for the same material in all frames."});
  add_sequence_picture_options(table);
}

}  // namespace mq::app
