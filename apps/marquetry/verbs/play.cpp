// marquetry play EVOLVING -o OUT: a page in which a browser plays an evolving mesh.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "verbs/shared/captured_textures.h"
#include "verbs/shared/evolving_frames.h"
#include "mq/base/error.h"
#include "mq/draw/lifespans.h"
#include "mq/io/atomic_file.h"
#include "mq/io/film.h"
#include "mq/io/frame_files.h"
#include "mq/io/mp4.h"
#include "mq/io/uri.h"
#include "mq/io/video.h"
#include "options/video_options.h"
#include "shell/results.h"
#include "player_files.h"
#include "shell/run.h"
#include "shell/verb.h"

namespace mq::app {
namespace {

namespace fs = std::filesystem;

/// A browser keeps at most this many characters in one string; base64 makes four of three bytes.
constexpr std::size_t most_bytes = 380'000'000;

/// H.264, AV1, VP9 and VP8 as MP4 calls them.
constexpr std::string_view played_codecs[] = {"avc1", "avc3", "av01", "vp09", "vp08"};

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

/// A texture video that is there already.
struct GivenVideo {
  std::string kind;
  Bytes bytes;
  std::optional<double> rate;  ///< its own, where its index says it
};

void warn_of_codec(Run& run, const std::string& name, const std::string& codec) {
  run.terminal().warning(
      fmt::format("{}: its pictures are kept as {}, which few browsers play: others show the shape "
                  "without them; make it again with --codec h264, av1 or vp9",
                  name, codec));
}

/// Browsers say nothing of a file that is no video, and show nothing; of one with other pictures
/// than the film's they show the wrong ones.
GivenVideo given_video(Run& run, std::size_t frames) {
  const OptionValues& options = run.options();
  const std::string name = options.text("video");
  GivenVideo video{kind_of_video(name), read_file(name), {}};
  if (video.kind == "video/webm") {
    require(text_of(video.bytes).starts_with("\x1a\x45\xdf\xa3"),
            fmt::format("{}: it is no WebM ({} bytes); make it again with export or relight", name,
                        video.bytes.size()));
    return video;
  }
  const Mp4Video found = mp4_video(video.bytes, name);
  video.rate = found.rate;
  if (found.codec == "hvc1" || found.codec == "hev1")
    warn_of_codec(run, name, fmt::format("H.265 ({})", found.codec));
  else if (std::ranges::count(played_codecs, found.codec) == 0)
    warn_of_codec(run, name, shown(found.codec));
  require(!found.pictures || *found.pictures == std::int64_t(frames),
          fmt::format("{}: it has {} pictures, and the film {} frames: name the frames it was made "
                      "of with --frames, or make it again of these",
                      name, found.pictures.value_or(0), frames));
  if (found.rate && options.has("rate")) {
    const double rate = options.number("rate");
    require(std::abs(rate / *found.rate - 1) * double(frames) < 0.5,
            fmt::format("--rate: found {:g} frames a second, and {} has {:.6g}; leave --rate out, "
                        "which takes that",
                        rate, name, *found.rate));
  }
  return video;
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
  if (options.has("video")) {
    kind_of_video(options.text("video"));
    run.will_read(options.text("video"));
  }
  const EvolvingReader reader(store);
  warn_of_broken(run.terminal(), reader);
  const std::vector<int> frames = wanted_frames(options, reader);
  require(std::ranges::is_sorted(frames), "--frames: time runs forwards in a film");
  if (options.has("from") || options.has("video")) require_atlas(reader);
  GivenVideo video{"video/mp4", {}, {}};
  if (options.has("video")) video = given_video(run, frames.size());
  const double rate =
      video.rate.value_or(options.has("rate") ? options.number("rate") : VideoOptions{}.rate);
  const fs::path output = options.text("output");
  const bool is_page = output.extension() == ".html";
  const fs::path page = is_page ? output : output / "index.html";
  if (options.has("from")) {
    require_video_program(page);
    require_video_options("textures.mp4", video_options(options));
    find_frames(options.text("from"), numbers_of(reader, frames));  // refused now if one is missing
    if (video_options(options).codec == VideoCodec::h265) warn_of_codec(run, "--codec", "H.265");
  }
  run.will_write({page}, is_page ? output.parent_path() : output);
  if (run.dry_run()) return Exit::done;

  if (options.has("from")) {
    const WorkFolder work;
    write_captured_textures(run, reader, frames, work / "textures.mp4");
    video.bytes = read_file(work / "textures.mp4");
  }
  const Step step(run, "film", 0.9);
  const Film film = make_film(reader, frames, lifespan_colour, step);
  Json description = Json::parse(film.description);
  description["title"] = store.stem().string();
  description["rate"] = rate;
  description["blocks"] = Json::array();
  for (const Bytes& block : film.blocks)
    description["blocks"].push_back(
        uri_of("application/octet-stream", block, "a segment of the film"));
  description["video"] = video.bytes.empty()
                             ? Json(nullptr)
                             : Json(uri_of(video.kind, video.bytes, "the texture video"));
  // "</" would end the script; in JSON it may be written so.
  std::string text = description.dump(-1, ' ', true, Json::error_handler_t::replace);
  for (std::size_t at = 0; (at = text.find("</", at)) != std::string::npos; at += 3)
    text.insert(at + 1, "\\");
  const std::string html = page_of(*files, fmt::format("const film = {};", text));
  write_file(page, bytes_of(html));
  run.result["frames"] = frames.size();
  run.result["segments"] = film.blocks.size();
  run.result["rate"] = rate;
  run.result["video_bytes"] = video.bytes.size();
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
  table.add({.name = "rate",
             .type = Type::number,
             .unit = "frames a second",
             .least = 0.001,
             .most = 1000,
             .help = "of the film; else that of an .mp4 given by --video, or 30"});
  add_codec_option(table);
  table.add({.name = "video",
             .type = Type::path,
             .group = "Textures",
             .help = "a texture video that is there already, .mp4 or .webm",
             .details =
                 "Such as export or relight make, with a picture for each of the frames. What an "
                 ".mp4 says of their count and rate must be true of the film."});
  add_captured_texture_options(table);
  return {table, run_play};
}

}  // namespace mq::app
