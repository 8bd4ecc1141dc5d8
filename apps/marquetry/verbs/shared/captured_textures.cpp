#include "verbs/shared/captured_textures.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "mq/base/error.h"
#include "mq/io/frame_files.h"
#include "mq/io/model.h"
#include "mq/io/path_status.h"
#include "mq/model/photographed_frames.h"
#include "mq/model/stored_frames.h"
#include "options/model_options.h"
#include "options/video_options.h"
#include "shell/arguments.h"

namespace mq::app {
namespace {

constexpr int most_side = 16384;

/// The side of the textures that an atlas was made for, if its maker said so.
std::optional<int> packed_side(const EvolvingReader& reader) {
  const Json about = Json::parse(reader.about(), nullptr, false);
  const Json::json_pointer place("/options/size");
  if (about.is_discarded() || !about.contains(place) || !about[place].is_number_integer())
    return {};
  const auto side = about[place].get<std::int64_t>();
  if (side < 1 || side > most_side) return {};
  return int(side);
}

int texture_side(const OptionValues& options, const EvolvingReader& reader) {
  if (options.has("size")) return int(options.integer("size"));
  return packed_side(reader).value_or(CapturedTextureOptions().side);
}

/// How photographs are found, and how fast what was chosen of them may change.
PhotographedOptions asked_photographs(const OptionValues& options) {
  PhotographedOptions wanted;
  wanted.images = options.texts("images");
  wanted.texture.choice.steady = options.number("steady");
  return wanted;
}

/// Throws where an option is of the other kind of frames.
void refuse_what_is_of_others(const OptionValues& options) {
  const bool photographs = names_camera_frames(options.text("from"));
  const std::vector<const char*> of_meshes = {"texture", "samples", "stitch"}, of_photographs = {"images", "steady"};
  for (const char* name : photographs ? of_meshes : of_photographs)
    require(!asks_for(options, name),
            photographs ? fmt::format("--{}: it is of captured meshes, and --from names photographs with cameras", name)
                        : fmt::format("--{}: it is of photographs, --from cameras_%04d.json", name));
}

Json steps_json(const BorderJump& jump) {
  return {{"across", jump.across}, {"within", jump.within}};
}

Json figures_json(const CapturedFigures& shown) {
  const bool texels = shown.of == CapturedFigures::Of::texels;
  Json found = {{"frame", shown.number},
                {texels ? "texels" : "vertices", shown.count},
                {"unseen", shown.unseen}};
  if (texels) found["filled"] = shown.filled;
  if (shown.changed)
    found["changed"] = *shown.changed;
  else
    found["accuracy"] = shown.accuracy;
  if (shown.steps)
    found["steps"] = {{"before", steps_json(shown.steps->before)},
                      {"after", steps_json(shown.steps->after)}};
  return found;
}

/// The captured frames that --from names, resampled as what they show is wanted in files `to`.
CapturedTextures captured_textures(Run& run, const EvolvingReader& reader, const std::vector<int>& frames,
                                   const std::string& to, const VideoOptions& video) {
  const OptionValues& options = run.options();
  const int side = texture_side(options, reader);
  require_holds_captured(reader, to, side, video);
  CapturedTextureOptions how{.side = side, .samples = int(options.integer("samples"))};
  if (options.flag("stitch")) how.steps = CapturedTextureOptions::Steps::taken_out;
  if (options.has("texture")) how.textures = options.text("texture");
  how.photographs = asked_photographs(options);
  if (const auto made_for = packed_side(reader); made_for && how.side < *made_for)
    run.terminal().warning(
        fmt::format("--size: {} texels, and the atlas was made for {}: its gutters are narrower "
                    "here, and charts may touch",
                    how.side, *made_for));
  return {reader, options.text("from"), frames, std::move(how), run.terminal()};
}

/// What was seen of each frame, and what was found wrong.
void report_captured(Run& run, const CapturedTextures& captured,
                     const std::vector<CapturedFigures>& figures) {
  Json& found = run.result["textures"] = Json::array();
  for (const CapturedFigures& shown : figures) found.push_back(figures_json(shown));
  run.found(captured.defects());
}

}  // namespace

OptionFields captured_fields() {
  return {{"sequence", "from"}, {"steps", "stitch"}, {"textures", "texture"}, {"side", "size"}};
}

void add_captured_texture_options(OptionTable& table) {
  using Type = Option::Type;
  const std::string group = "Textures";
  table.add({.name = "from",
             .type = Type::path,
             .metavar = "SEQUENCE",
             .group = group,
             .help = "the captured frames, or photographs of them: what they show is written as textures",
             .details = "frame_%04d.ply, or a folder, with the numbers of the evolving mesh's "
                        "frames. Without an atlas (unwrap, evolve) models get colours at "
                        "vertices, and nothing else can be written. Photographs are named by their cameras, "
                        "cameras_%04d.json, or one file for all frames where cameras stand still: then --images "
                        "says where those of each frame are."});
  table.add({.name = "texture",
             .type = Type::path,
             .group = group,
             .help = "pictures instead of those the captured frames name, %04d for the number"});
  table.add({.name = "size",
             .letter = 's',
             .type = Type::integer,
             .unit = "texels",
             .least = 1,
             .most = most_side,
             .group = group,
             .help = "side of the textures; without it that the atlas was made for",
             .details = "In smaller ones gutters are narrower, and charts may touch."});
  table.add({.name = "samples",
             .type = Type::integer,
             .default_value = as_typed(CapturedTextureOptions{}.samples),
             .least = 1,
             .most = 8,
             .group = group,
             .help = "per texel and direction"});
  table.add({.name = "images",
             .type = Type::path,
             .count = Option::Count::many,
             .metavar = "FOLDER",
             .group = group,
             .help = "folders with the photographs, %04d for the number; else beside the cameras"});
  table.add({.name = "steady",
             .type = Type::number,
             .default_value = as_typed(ChooseOptions{}.steady),
             .least = 0,
             .most = 100,
             .group = group,
             .help = "more: texels keep their photograph from frame to frame; 0: each frame is chosen for by itself",
             .details = "Cameras have the same order in all frames. 1: another one is taken where the one before shows "
                        "nothing."});
  table.add({.name = "stitch",
             .type = Type::flag,
             .group = group,
             .help = "take out steps where texels come from different captured charts",
             .details = "Gradients inside of charts are kept, as the verb stitch does."});
}

std::vector<std::filesystem::path> captured_paths(const OptionValues& options,
                                                  const EvolvingReader& reader,
                                                  const std::vector<int>& numbers) {
  const std::string output = options.text("output");
  if (names_camera_frames(options.text("from"))) {
    require(has_atlas(reader), fmt::format("--from: photographs are projected into an atlas, and {} has no texture "
                                           "coordinates: unwrap it first",
                                           reader.manifest().string()));
    find_camera_frames(options.text("from"), numbers, options.texts("images"));
  } else {
    find_frames(options.text("from"), numbers);  // refused now where one is missing
  }
  require(has_atlas(reader) || !options.flag("stitch"),
          fmt::format("--stitch: it is of textures, and {} has no texture coordinates",
                      reader.manifest().string()));
  return captured_files(reader, numbers, output);
}

void will_read_captured(Run& run, const std::vector<int>& numbers, const std::vector<std::filesystem::path>& outputs) {
  const OptionValues& options = run.options();
  refuse_what_is_of_others(options);
  if (names_camera_frames(options.text("from"))) {
    for (const FrameFile& frame : find_camera_frames(options.text("from"), numbers, options.texts("images"))) {
      if (!is_folder(frame.path)) run.will_read(frame.path);
      for (const Photograph& one : photographs_of_frame(frame, asked_photographs(options))) run.will_read(one.picture);
    }
    return;
  }
  const std::vector<FrameFile> frames = find_frames(options.text("from"), numbers);
  for (const FrameFile& frame : frames) run.will_read(frame.path);
  const auto is_there = [](const std::filesystem::path& path) {
    std::error_code ignored;
    return std::filesystem::exists(path, ignored);
  };
  // What names others is read for them only where any of them could be replaced.
  if (std::ranges::none_of(outputs, is_there) && !(options.given("report") && is_there(options.text("report")))) return;
  for (const FrameFile& frame : frames) {
    ReadModelOptions how{.textures = {}, .pictures = ReadModelOptions::Pictures::skip};
    if (options.has("texture")) how.textures = {frame_name(options.text("texture"), frame.number)};
    will_read_model(run, read_model(frame.path, how));
  }
}

void write_captured_textures(Run& run, const EvolvingReader& reader, const std::vector<int>& frames,
                             const std::string& to, const VideoOptions& how) {
  const Step step(run, "textures", 0.9);
  CapturedTextures captured = captured_textures(run, reader, frames, to, how);
  report_captured(run, captured,
                  write_captured(captured, to, how, asked_compression(run.options()), run.terminal(), step));
}

FilmVideo captured_video(Run& run, const EvolvingReader& reader, const std::vector<int>& frames,
                         const VideoOptions& how) {
  const Step step(run, "textures", 0.9);
  CapturedTextures captured = captured_textures(run, reader, frames, "textures.mp4", how);
  CapturedFilmVideo made =
      captured_film_video(captured, how, run.terminal(), step);
  report_captured(run, captured, made.figures);
  return std::move(made.video);
}

}  // namespace mq::app
