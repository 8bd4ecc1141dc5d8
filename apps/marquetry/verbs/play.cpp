// marquetry play EVOLVING -o OUT: a page in which a browser plays an evolving mesh.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <optional>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/draw/lifespans.h"
#include "mq/io/atomic_file.h"
#include "mq/io/film_page.h"
#include "mq/io/file_names.h"
#include "mq/io/frame_files.h"
#include "mq/io/path_status.h"
#include "mq/io/video.h"
#include "mq/model/evolving_input.h"
#include "options/video_options.h"
#include "player_files.h"
#include "shell/results.h"
#include "shell/run.h"
#include "shell/verb.h"
#include "verbs/shared/captured_textures.h"
#include "verbs/shared/evolving_frames.h"

namespace mq::app {
namespace {

namespace fs = std::filesystem;

constexpr double least_rate = 0.001, most_rate = 1000;  // frames a second
constexpr double beyond_sides = 1e-3;                   // of a picture's side

/// The page, and the scripts that it names.
std::string page_of(const PlayerFiles& files, const Film& film, const FilmPageOptions& options) {
  return film_page(files.page, files.scripts, film, options);
}

void refuse_what_does_not_fit(const OptionValues& options) {
  require(!options.has("from") || !options.has("video"),
          "--video: with --from the textures are those captured");
  if (options.has("video")) film_video_type(options.text("video"));
}

constexpr double textures_share = 0.9;  // of the time, where there are any

/// The pictures that the file has, each for the frames of its segment.
FilmVideo video_of_pictures(Run& run, const EvolvingInput& input, const std::vector<int>& frames,
                            const VideoOptions& how) {
  const Step step(run, "textures", textures_share);
  std::vector<const Image<float>*> pictures;
  for (const int f : frames)
    pictures.push_back(&input.pictures[std::size_t(input.reader.frames()[std::size_t(f)].segment)]);
  return picture_film_video(pictures, how, step);
}

/// Browsers are given pictures as a video, which shows nothing beyond its sides but these.
void warn_of_repeats(Run& run, const EvolvingReader& reader) {
  for (int s = 0; s < int(reader.segments().size()); ++s)
    for (const Vector2& uv : reader.segment(s).uvs) {
      if (uv.minCoeff() >= -beyond_sides && uv.maxCoeff() <= 1 + beyond_sides) continue;
      run.terminal().warning(
          fmt::format("{}: found texture coordinates {:.6g}, {:.6g}, wanted 0 to 1: beyond these its pictures are "
                      "not repeated, but go on with the colours at their sides; bake them into an atlas for more",
                      reader.manifest().string(), uv.x(), uv.y()));
      return;
    }
}

/// The texture video that --video names; none where it names none.
FilmVideo given_video(Run& run, std::size_t frames) {
  const OptionValues& options = run.options();
  if (!options.has("video")) return {};
  FilmVideoOptions how{.frames = std::int64_t(frames)};
  if (options.has("rate")) how.rate = options.number("rate");
  return read_film_video(options.text("video"), how, run.terminal());
}

/// Refuses now what would be refused once the work on textures is done.
void check_video_to_make(Run& run, const EvolvingReader& reader, const std::vector<int>& frames,
                         const fs::path& page, const VideoOptions& how) {
  const OptionValues& options = run.options();
  require_video_program(page);
  require_video_options("textures.mp4", how);
  if (options.has("from")) find_frames(options.text("from"), numbers_of(reader, frames));
  if (video_options(options).codec == VideoCodec::h265)
    warn_of_unplayed_codec("--codec", "H.265", run.terminal());
}

EvolvingInput open_input(Run& run, const fs::path& path) {
  const Step step(run, "read", 0.02);
  return open_evolving(path, run.terminal(), step);
}

/// Whether it is a page; no: a folder for one. Throws where it is called as neither is.
bool names_page(const fs::path& output) {
  const std::string extension = lower_extension(output);
  if (extension == ".html" || extension == ".htm") return true;
  const bool is_ending =
      extension.size() > 1 && std::ranges::all_of(extension.substr(1), [](char c) { return c >= 'a' && c <= 'z'; });
  require(!is_ending || is_folder(output),
          fmt::format("--output: found '{}', wanted a page, such as walk.html, or a folder; {}/ is one of that name",
                      output.string(), output.string()));
  return false;
}

/// Where the page is written, and the film where that is beside it: NAME_film.evolving of NAME.html, film.evolving of
/// index.html in a folder.
struct PageFiles {
  enum class Film { inside, beside };
  fs::path page = {}, folder = {}, manifest = {}, blocks = {}, video = {};  ///< no video: empty
  Film film = Film::inside;

  std::vector<fs::path> all() const {
    std::vector<fs::path> files = {page};
    if (film == Film::inside) return files;
    files.insert(files.end(), {manifest, blocks});
    if (!video.empty()) files.push_back(video);
    return files;
  }
};

PageFiles page_files(const OptionValues& options, bool has_video) {
  const fs::path output = options.text("output");
  const bool is_page = names_page(output);
  PageFiles files{.page = is_page ? output : output / "index.html",
                  .folder = is_page ? output.parent_path() : output,
                  .film = options.flag("beside") ? PageFiles::Film::beside : PageFiles::Film::inside};
  const fs::path stem = files.folder / (is_page ? output.stem().string() + "_film" : "film");
  const auto with = [&stem](const std::string& extension) { return fs::path(stem.string() + extension); };
  files.manifest = with(".evolving");
  files.blocks = with(".blocks");
  if (has_video) files.video = with(options.has("video") ? lower_extension(options.text("video")) : ".mp4");
  return files;
}

/// Writes the page last, as it needs the others.
void write_page(Run& run, const PageFiles& files, const Film& film, FilmPageOptions options) {
  Bytes blocks;
  for (const Bytes& group : film.blocks) blocks.insert(blocks.end(), group.begin(), group.end());
  if (files.film == PageFiles::Film::beside) {
    write_file(files.blocks, blocks);
    write_file(files.manifest, bytes_of(film.manifest));
    options.store_name = files.manifest.filename().string();
    if (!files.video.empty()) {
      write_file(files.video, options.video);
      options.video_name = files.video.filename().string();
    }
  }
  const std::string html = page_of(*player_files(), film, options);
  write_file(files.page, bytes_of(html));
  run.result["video_bytes"] = options.video.size();
  run.result["film_bytes"] = film.manifest.size() + blocks.size() + film.lives.size();
  run.result["bytes"] = html.size();
  say_written(run, files.all());
}

Exit run_play(Run& run) {
  const OptionValues& options = run.options();
  if (!player_files())
    throw InvalidInput(
        "this program was built without three.js, which pages need: install libjs-three "
        "(scripts/install_packages) and build again");
  const fs::path store = options.text("evolving");
  run.will_read(store);
  refuse_what_does_not_fit(options);
  if (options.has("video")) run.will_read(options.text("video"));
  const EvolvingInput input = open_input(run, store);
  for (const fs::path& beside : input.files) run.will_read(beside);
  const EvolvingReader& reader = input.reader;
  const std::vector<int> frames = wanted_frames(options, reader);
  require(std::ranges::is_sorted(frames), "--frames: time runs forwards in a film");
  if (options.has("from") || options.has("video")) require_atlas(reader);
  FilmVideo video = given_video(run, frames.size());
  const double own_rate = video.rate.value_or(input.rate.value_or(VideoOptions{}.rate));
  const double rate = options.has("rate") && !video.rate ? options.number("rate") : own_rate;
  const VideoOptions how{.rate = rate, .codec = video_options(options).codec};
  require(rate >= least_rate && rate <= most_rate,
          fmt::format("{}: it has {:g} frames a second; say another with --rate", store.string(), rate));
  const bool shows_own =
      input.has_pictures() && has_atlas(reader) && !options.has("from") && !options.has("video");
  require_video_for_codec(options, options.has("from") || shows_own);
  const PageFiles files = page_files(options, options.has("from") || options.has("video") || shows_own);
  if (shows_own) warn_of_repeats(run, reader);
  if (options.has("from") || shows_own) check_video_to_make(run, reader, frames, files.page, how);
  if (options.has("from")) will_read_captured(run, numbers_of(reader, frames), files.all());
  run.will_write(files.all(), files.folder);
  if (run.dry_run()) return Exit::done;

  if (options.has("from")) video = captured_video(run, reader, frames, how);
  if (shows_own) video = video_of_pictures(run, input, frames, how);
  const Step step(run, "film", video.bytes.empty() ? 0.98 : 0.98 - textures_share);
  FilmOptions film_options;
  if (files.film == PageFiles::Film::beside) film_options.blocks_name = files.blocks.filename().string();
  if (options.has("error")) film_options.error = options.number("error") / 100;
  const Film film = make_film(reader, frames, lifespan_colour, film_options, step);
  const auto segments = std::int64_t(Json::parse(film.description)["segments"].size());
  run.result["frames"] = frames.size();
  run.result["segments"] = segments;
  run.result["rate"] = rate;
  write_page(run, files, film,
             {.title = store.stem().string(), .rate = rate, .video_type = video.type, .video = video.bytes});
  run.print(fmt::format("{} in {}, {:.1f} MB; open {} in a browser\n", counted(std::ssize(frames), "frame"),
                        counted(segments, "segment"),
                        run.result["bytes"].get<double>() / 1e6, files.page.string()));
  return Exit::done;
}

}  // namespace

Verb play_verb() {
  using Type = Option::Type;
  OptionTable table("play", "Write a page in which a browser plays an evolving mesh.");
  table.example("walk.evolving -o walk.html --from captured/", "a page to send, that plays in a browser");
  table.add({.name = "evolving",
             .place = Option::Place::positional,
             .type = Type::path,
             .required = true,
             .help = "the evolving mesh, as evolve makes it, or a file that moves: .usda, .usdz, .glb or "
                     ".gltf, of export or another program",
             .details = "Pictures that such a file has are shown, unless --from or --video gives others."});
  table.add({.name = "output",
             .letter = 'o',
             .type = Type::path,
             .required = true,
             .metavar = "OUT",
             .help = "a folder for index.html, or a page of another name (.html)",
             .details = "The page has all in it and fetches nothing, unless --beside says so."});
  table.add({.name = "beside",
             .help = "write the film and its video beside the page, which fetches them from its server as it plays",
             .details = "For long ones: the page opens at once, and what is passed over is not fetched. From a disk "
                        "it does not play."});
  add_evolving_frames_option(table);
  table.add({.name = "rate",
             .type = Type::number,
             .unit = "frames a second",
             .least = least_rate,
             .most = most_rate,
             .help = "of the film; else that of an .mp4 given by --video, or of a file that moves, or 30"});
  table.add({.name = "error",
             .type = Type::number,
             .unit = "% of the diagonal",
             .least = 1e-7,
             .most = 10,
             .help = "how far positions may be off; else 1/65536 of the largest extent",
             .details = "Where the store was rounded to more, that stays."});
  add_codec_option(table);
  table.add({.name = "video",
             .type = Type::path,
             .group = "Textures",
             .help = "a texture video that is there already, .mp4 or .webm",
             .details =
                 "Such as export or relight make, with a picture for each of the frames. What an "
                 ".mp4 says of their count and rate must be true of the film."});
  add_captured_texture_options(table);
  return {table, run_play, {}, captured_fields()};
}

}  // namespace mq::app
