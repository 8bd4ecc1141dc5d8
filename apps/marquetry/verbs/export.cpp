// marquetry export X.evolving [-o OUT]: what an evolving mesh is, and its frames as files that
// other programs read.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/io/animation.h"
#include "mq/io/evolving_file.h"
#include "mq/io/file_names.h"
#include "mq/io/frame_files.h"
#include "mq/io/model.h"
#include "mq/io/video.h"
#include "mq/model/evolving_input.h"
#include "mq/model/stored_models.h"
#include "options/model_options.h"
#include "options/signal_options.h"
#include "options/video_options.h"
#include "shell/results.h"
#include "shell/run.h"
#include "shell/verb.h"
#include "verbs/shared/captured_textures.h"
#include "verbs/shared/evolving_frames.h"
#include "verbs/shared/sequence_pictures.h"

namespace mq::app {
namespace {

namespace fs = std::filesystem;

/// Triangles and their lives are those of the frames that can be given.
Json describe(const EvolvingReader& reader, const std::vector<int>& damaged) {
  const StoreFigures found = store_figures(reader, damaged);
  return {{"frames", reader.frames().size()},
          {"segments", reader.segments().size()},
          {"triangles", found.triangles},
          {"triangles_throughout", found.throughout},
          {"lifespan_mean", found.mean_lifespan},
          {"step", reader.step()},
          {"bytes", reader.is_store() ? found.bytes : std::int64_t(fs::file_size(reader.manifest()))},
          {"damaged", numbers_of(reader, damaged)},
          {"broken", reader.broken()}};
}

std::string in_words(const Json& found, const EvolvingReader& reader) {
  std::string text = fmt::format(
      "{} in {}, {}{}\n"
      "{}, {} of them throughout; they live for {:.1f} frames on average\n",
      counted(found["frames"].get<int>(), "frame"),
      counted(found["segments"].get<int>(), "segment"),
      counted(found["bytes"].get<std::int64_t>(), "byte"),
      reader.is_store() ? fmt::format(" in steps of {:.3g}", found["step"].get<double>()) : "",
      counted(found["triangles"].get<int>(), "triangle"), found["triangles_throughout"].get<int>(),
      found["lifespan_mean"].get<double>());
  for (std::size_t s = 0; s < reader.segments().size(); ++s) {
    const auto of_segment = [&](const StoredFrame& f) { return f.segment == int(s); };
    const auto first = std::ranges::find_if(reader.frames(), of_segment);
    if (first == reader.frames().end()) continue;
    text += fmt::format("segment {}: from frame {}, {}, {}, {}\n", s, first->number,
                        counted(std::ranges::count_if(reader.frames(), of_segment), "frame"),
                        counted(reader.segments()[s].vertices, "vertex"),
                        counted(reader.segments()[s].triangles, "triangle"));
  }
  return text;
}

/// Throws where frames are not one after the other.
void require_consecutive(const std::vector<int>& frames) {
  for (std::size_t i = 1; i < frames.size(); ++i)
    require(frames[i] == frames[i - 1] + 1,
            "--frames: an animation takes all frames between its first and its last");
}

/// Takes those that are damaged out of the frames and their files; returns these.
std::vector<int> leave_out(const std::vector<int>& damaged, std::vector<int>& frames,
                           std::vector<fs::path>& paths) {
  std::vector<int> lost, kept;
  std::vector<fs::path> kept_paths;
  for (std::size_t i = 0; i < frames.size(); ++i)
    if (std::ranges::binary_search(damaged, frames[i])) {
      lost.push_back(frames[i]);
    } else {
      kept.push_back(frames[i]);
      kept_paths.push_back(paths[i]);
    }
  frames = std::move(kept);
  paths = std::move(kept_paths);
  return lost;
}

/// Whether the file's own pictures are written.
bool carries_pictures(const OptionValues& options, const EvolvingInput& input) {
  return input.has_pictures() && has_atlas(input.reader) && !options.has("from") && !options.has("paint");
}

bool has_picture(const EvolvingInput& input, int frame) { return !input.picture(frame).values().empty(); }

/// That of a frame's file, `frame_0001.ply`.
fs::path picture_beside(fs::path model) { return model.replace_extension(".png"); }

/// How animations and videos are written: at the rate that is asked for, or else the file's own.
VideoOptions rate_and_codec(const OptionValues& options, const EvolvingInput& input) {
  VideoOptions how = video_options(options);
  if (options.has("rate")) return how;
  how.rate = (names_animation(options.text("output")) ? input.numbers_rate : input.rate).value_or(how.rate);
  return how;
}

void write_frames(Run& run, const EvolvingInput& input, const std::vector<int>& frames) {
  const EvolvingReader& reader = input.reader;
  const OptionValues& options = run.options();
  const std::string output = options.text("output");
  const Step step(run, "write", 0.9);
  PictureOfFrame picture;
  if (carries_pictures(options, input)) picture = [&](int frame) { return input.picture(frame); };
  if (names_animation(output)) {
    require(!options.has("paint"), "--paint: an animation has no colours at vertices");
    const double rate = rate_and_codec(options, input).rate;
    write_animation(output, reader, {frames.front(), frames.back(), rate, asked_compression(options)}, picture, step);
    return;
  }
  std::vector<fs::path> models;
  for (const int number : numbers_of(reader, frames)) models.emplace_back(frame_name(output, number));
  std::optional<CarriedColours> colours;
  if (options.has("paint")) colours.emplace(read_model(options.text("paint")), reader);
  write_stored_models(reader, frames, models, {colours ? &*colours : nullptr, picture}, step);
}

void refuse_what_does_not_fit(const OptionValues& options) {
  require(!options.has("from") || options.has("output"),
          "--from: what is captured is written as textures, so --output says where");
  require(!options.has("from") || !options.has("paint"),
          "--paint: with --from the colours are those captured");
  for (const char* name : {"size", "samples", "texture", "stitch", "images", "steady"})
    require(!asks_for(options, name) || options.has("from"),
            fmt::format("--{}: it is of textures, which --from makes", name));
  require(!options.has("paint") || options.has("output"),
          "--paint: it colours models, so --output says where");
}

/// The files that these frames make.
std::vector<fs::path> paths_of(const OptionValues& options, const EvolvingInput& input,
                               const std::vector<int>& frames) {
  const EvolvingReader& reader = input.reader;
  const std::string output = options.text("output");
  require(options.has("from") || names_animation(output) ||
              (names_model(output) && has_frame_place(output)),
          fmt::format("--output: found '{}', wanted an animation (.glb, .usda or .usdz), or a model with a place "
                      "for the frame's number, such as frame_%04d.ply",
                      output));
  if (names_animation(output)) require_consecutive(frames);
  require(asked_compression(options) == Compression::none || names_animation(output),
          "--compress: it is of an animation, --output walk.glb");
  if (options.has("from")) return captured_paths(options, reader, numbers_of(reader, frames));
  const bool carries = carries_pictures(options, input);
  if (names_animation(output))
    return animation_files(output, reader, {frames.front(), frames.back()},
                           [&](int frame) { return carries && has_picture(input, frame); });
  std::vector<fs::path> paths;
  for (const int frame : frames) {
    const fs::path model = frame_name(output, numbers_of(reader, {frame}).front());
    const bool has_pictures = carries && has_picture(input, frame);
    paths.push_back(model);
    if (has_pictures && lower_extension(output) != ".glb") paths.push_back(picture_beside(model));
    std::ranges::copy(files_beside_made(model, has_pictures ? 1 : 0), std::back_inserter(paths));
  }
  return paths;
}

/// What becomes of the unit of lengths, where it is not a metre.
void say_unit(Run& run, const EvolvingReader& reader) {
  const fs::path output = run.options().text("output");
  if (reader.metres_per_unit() == 1 || !names_model(output)) return;
  run.terminal().remark(
      fmt::format("{}: its unit is {:g} m; {}", reader.manifest().string(), reader.metres_per_unit(),
                  names_gltf(output) ? "glTF counts in metres, and lengths are multiplied by that"
                                     : lower_extension(output) + " has no unit, and lengths stay as they are"));
}

/// Writes what can be had of the frames. Throws `IoError` after the rest was written where some are
/// damaged.
void write_asked(Run& run, const EvolvingInput& input, const std::vector<int>& damaged,
                 std::vector<int> frames, std::vector<fs::path> paths) {
  const EvolvingReader& reader = input.reader;
  const OptionValues& options = run.options();
  std::vector<int> lost;
  if (!damaged.empty() && !options.has("from") && !names_animation(options.text("output")))
    lost = leave_out(damaged, frames, paths);
  require(!frames.empty(), options.text("evolving") + ": every frame that is asked for is damaged");
  if (options.has("from"))
    write_captured_textures(run, reader, frames, options.text("output"), rate_and_codec(options, input));
  else
    write_frames(run, input, frames);
  say_written(run, paths);
  if (!lost.empty())
    throw IoError(fmt::format(
        "{}: {} of {} frames were written; damaged, and not written: {}; copy the store again, or "
        "ask for others with --frames",
        reader.blocks_file().string(), frames.size(), frames.size() + lost.size(),
        fmt::join(numbers_of(reader, lost), ", ")));
}

Exit run_export(Run& run) {
  const OptionValues& options = run.options();
  run.will_read(options.text("evolving"));
  refuse_what_does_not_fit(options);
  if (options.has("paint")) run.will_read(options.text("paint"));
  require_video_for_codec(options, options.has("output") && names_video(options.text("output")));
  const EvolvingInput input = open_evolving(options.text("evolving"), run.terminal());
  for (const fs::path& beside : input.files) run.will_read(beside);
  const EvolvingReader& reader = input.reader;
  std::vector<int> frames;
  std::vector<fs::path> paths;
  if (options.has("output")) {
    frames = wanted_frames(options, reader);
    paths = paths_of(options, input, frames);
    if (options.has("from")) will_read_captured(run, numbers_of(reader, frames), paths);
    run.will_write(paths);
  }
  if (options.has("output")) say_unit(run, reader);
  if (options.has("plot")) run.will_write({options.text("plot")});
  const std::vector<int> damaged = reader.damaged();
  warn_of_damage(run.terminal(), reader, damaged);
  run.result = describe(reader, damaged);
  run.print(in_words(run.result, reader));
  if (run.dry_run()) return Exit::done;
  if (options.has("plot")) {
    write_plot(run, followed_frames(reader));
    if (paths.empty()) say_written(run, {options.text("plot")});
  }
  if (!paths.empty()) write_asked(run, input, damaged, frames, paths);
  return Exit::done;
}

}  // namespace

Verb export_verb() {
  using Type = Option::Type;
  OptionTable table("export", "Say what an evolving mesh is, and write its frames as files.");
  table.example("walk.evolving -o walk.glb --from captured/", "an animation with textures");
  table.example("walk.evolving -o frame_%04d.obj --from captured/", "a model a frame");
  table.add({.name = "evolving",
             .place = Option::Place::positional,
             .type = Type::path,
             .required = true,
             .help = "the evolving mesh, as track makes it, or a file that moves: .usda, .usdz, .glb or .gltf, of "
                     "export or another program",
             .details = "Pictures that such a file has are written with it, unless --from makes others."});
  table.add({.name = "output",
             .letter = 'o',
             .type = Type::path,
             .metavar = "OUT",
             .help = "frame_%04d.ply (or .obj, .gltf, .glb) for a file a frame, or .glb, .usda or "
                     ".usdz for an animation; without it nothing is written",
             .details =
                 "With --from a model a frame, a picture a frame, such as texture_%04d.png, or a "
                 "video (.mp4, .mov, .webm, .mkv) of the textures, not of the model as a camera sees it: a page in "
                 "which that moves is what play makes."});
  add_evolving_frames_option(table);
  table.add({.name = "paint",
             .type = Type::path,
             .metavar = "MODEL",
             .help = "the first frame's own model: its colours, carried along, so that one sees "
                     "whether they stay where they belong",
             .details = "What was added later is grey."});
  table.add({.name = "compress",
             .type = Type::choice,
             .default_value = "none",
             .choices = {"none", "meshopt"},
             .help = "geometry of an animation that is a .glb; without loss"});
  table.add({.name = "rate",
             .type = Type::number,
             .unit = "frames a second",
             .least = 0.001,
             .most = 100000,
             .help = "of an animation, or a video, which has 1000 at most; else that of a file that moves, or 30"});
  add_codec_option(table);
  add_captured_texture_options(table);
  add_plot_option(table);
  auto fields = captured_fields();
  fields["colours"] = "paint";
  return {table, run_export, {}, fields};
}

}  // namespace mq::app
