// marquetry play EVOLVING -o OUT: a page in which a browser plays an evolving mesh.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "captured_textures.h"
#include "evolving_frames.h"
#include "frame_textures.h"
#include "mq/base/error.h"
#include "mq/draw/lifespans.h"
#include "mq/io/atomic_file.h"
#include "mq/io/film.h"
#include "mq/io/uri.h"
#include "mq/io/video.h"
#include "outputs.h"
#include "player_files.h"
#include "run.h"
#include "verb.h"

namespace mq::app {
namespace {

namespace fs = std::filesystem;

/// A browser keeps at most this many characters in one string; base64 makes four of three bytes.
constexpr std::size_t most_bytes = 380'000'000;

/// The kinds of video that browsers play.
std::string kind_of_video(const fs::path& path) {
  const std::string ending = path.extension().string();
  if (ending == ".mp4") return "video/mp4";
  if (ending == ".webm") return "video/webm";
  throw InvalidInput(
      fmt::format("--video: found '{}', wanted a video that browsers play, .mp4 or "
                  ".webm",
                  path.string()));
}

std::string uri_of(const std::string& kind, const Bytes& bytes, const std::string& what) {
  require(bytes.size() <= most_bytes,
          fmt::format("{} has {} MB, and a browser takes {} at once: take fewer frames (--frames), "
                      "or smaller textures (--size)",
                      what, bytes.size() / 1'000'000, most_bytes / 1'000'000));
  return data_uri(kind, bytes);
}

/// A folder of its own for as long as it is wanted.
class WorkFolder {
 public:
  WorkFolder() {
    std::string name = (fs::temp_directory_path() / "marquetry-play-XXXXXX").string();
    if (!mkdtemp(name.data()))
      throw IoError(
          fmt::format("{}: no folder can be made there", fs::temp_directory_path().string()));
    path_ = name;
  }
  ~WorkFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;

  fs::path operator/(const std::string& name) const { return path_ / name; }

 private:
  fs::path path_;
};

/// The page with each script inside that it names.
std::string page_of(const PlayerFiles& files, const std::string& film) {
  std::string page(files.page);
  const std::pair<std::string_view, std::string_view> scripts[] = {
      {"three.min.js", files.three},
      {"OrbitControls.js", files.orbit_controls},
      {"film.js", film},
      {"player.js", files.player}};
  for (const auto& [name, script] : scripts) {
    const std::string place = fmt::format("<script src=\"{}\">", name);
    const std::size_t at = page.find(place);
    if (at == std::string::npos) throw std::logic_error(fmt::format("the page has no {}", name));
    page.replace(at, place.size(), fmt::format("<script>\n{}", script));
  }
  return page;
}

/// Browsers say nothing of a file that is no video, and show nothing.
void require_video(const std::string& name, const Bytes& bytes) {
  const auto holds = [&](std::size_t at, std::string_view word) {
    return bytes.size() >= at + word.size() &&
           std::memcmp(bytes.data() + at, word.data(), word.size()) == 0;
  };
  require(holds(4, "ftyp") || holds(0, "\x1a\x45\xdf\xa3"),
          fmt::format("{}: it is no MP4 or WebM ({} bytes); make it again with export or relight",
                      name, bytes.size()));
}

Exit run_play(Run& run) {
  const OptionValues& options = run.options();
  const std::optional<PlayerFiles> files = player_files();
  if (!files)
    throw InvalidInput(
        "this program was built without three.js, which pages need: install libjs-three "
        "(scripts/install_packages) and build again");
  const fs::path store = options.text("evolving");
  run.will_read(store);
  require(!options.has("from") || !options.has("video"),
          "--video: with --from the textures are those captured");
  require_video_for_codec(options, options.has("from"));
  std::string kind = "video/mp4";
  if (options.has("video")) {
    kind = kind_of_video(options.text("video"));
    run.will_read(options.text("video"));
  }
  const EvolvingReader reader(store);
  if (!reader.broken().empty()) run.terminal().warning(reader.broken());
  const std::vector<int> frames = wanted_frames(options, reader);
  require(std::ranges::is_sorted(frames), "--frames: time runs forwards in a film");
  const fs::path output = options.text("output");
  const bool is_page = output.extension() == ".html";
  const fs::path page = is_page ? output : output / "index.html";
  if (options.has("from")) {
    require_video_program(page);
    require_video_options("textures.mp4", video_options(options));
  }
  run.will_write({page}, is_page ? output.parent_path() : output);
  if (run.dry_run()) return Exit::done;

  Bytes video;
  if (options.has("from")) {
    const WorkFolder work;
    write_captured_textures(run, reader, frames, work / "textures.mp4");
    video = read_file(work / "textures.mp4");
  } else if (options.has("video")) {
    video = read_file(options.text("video"));
    require_video(options.text("video"), video);
  }
  const Step step(run, "film", 0.9);
  const Film film = make_film(reader, frames, lifespan_colour, step);
  Json description = Json::parse(film.description);
  description["title"] = store.stem().string();
  description["rate"] = options.number("rate");
  description["blocks"] = Json::array();
  for (const Bytes& block : film.blocks)
    description["blocks"].push_back(
        uri_of("application/octet-stream", block, "a segment of the film"));
  description["video"] =
      video.empty() ? Json(nullptr) : Json(uri_of(kind, video, "the texture video"));
  // "</" would end the script; in JSON it may be written so.
  std::string text = description.dump(-1, ' ', true, Json::error_handler_t::replace);
  for (std::size_t at = 0; (at = text.find("</", at)) != std::string::npos; at += 3)
    text.insert(at + 1, "\\");
  const std::string html = page_of(*files, fmt::format("const film = {};", text));
  write_file(page, bytes_of(html));
  run.result["frames"] = frames.size();
  run.result["segments"] = film.blocks.size();
  run.result["video_bytes"] = video.size();
  run.result["bytes"] = html.size();
  run.print(fmt::format("{} frames in {} segments, {:.1f} MB; open {} in a browser\n",
                        frames.size(), film.blocks.size(), double(html.size()) / 1e6,
                        page.string()));
  say_written(run, {page});
  return Exit::done;
}

}  // namespace

Verb play_verb() {
  using Type = Option::Type;
  OptionTable table("play", "Write a page in which a browser plays an evolving mesh.");
  table.add({.name = "evolving",
             .place = Option::Place::positional,
             .type = Type::path,
             .required = true,
             .help = "the evolving mesh, as evolve makes it"});
  table.add({.name = "output",
             .letter = 'o',
             .type = Type::path,
             .required = true,
             .metavar = "OUT",
             .help = "a folder for index.html, or a page of another name (.html)",
             .details = "The page has all in it and fetches nothing."});
  add_evolving_frames_option(table);
  add_rate_option(table);
  add_codec_option(table);
  table.add({.name = "video",
             .type = Type::path,
             .group = "Textures",
             .help = "a texture video that is there already, .mp4 or .webm",
             .details = "Such as export or relight make, with a picture for each of the frames, at "
                        "the same --rate."});
  add_captured_texture_options(table);
  return {table, run_play};
}

}  // namespace mq::app
