#include "mq/model/film_video.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/image/colour.h"
#include "mq/image/resample.h"
#include "mq/io/mp4.h"
#include "mq/io/temporary_folder.h"

namespace mq {
namespace {

namespace fs = std::filesystem;

constexpr float untextured_grey = 0.8F;
constexpr double same_rate = 1e-6;  // relative: rates of files are fractions
/// H.264, AV1, VP9 and VP8 as MP4 calls them.
constexpr std::string_view played_codecs[] = {"avc1", "avc3", "av01", "vp09", "vp08"};

TemporaryFolder work_folder() { return {"marquetry-play-", "the video"}; }

void warn_of_codec(const std::string& name, const std::string& codec, Messages& messages) {
  if (codec == "hvc1" || codec == "hev1")
    warn_of_unplayed_codec(name, fmt::format("H.265 ({})", codec), messages);
  else if (std::ranges::count(played_codecs, codec) == 0)
    warn_of_unplayed_codec(name, shown(codec), messages);
}

}  // namespace

std::string film_video_type(const fs::path& path) {
  const std::string ending = path.extension().string();
  if (ending == ".mp4") return "video/mp4";
  if (ending == ".webm") return "video/webm";
  throw InvalidInput(fmt::format("{}: found '{}', wanted a video that browsers play, .mp4 or .webm",
                                 option_name("video"), path.string()));
}

void warn_of_unplayed_codec(const std::string& name, const std::string& codec, Messages& messages) {
  messages.warning(
      fmt::format("{}: its pictures are kept as {}, which few browsers play: others show the shape "
                  "without them; make it again with {} h264, av1 or vp9",
                  name, codec, option_name("codec")));
}

FilmVideo read_film_video(const fs::path& path, const FilmVideoOptions& options,
                          Messages& messages) {
  const std::string name = path.string();
  FilmVideo video{.type = film_video_type(path), .bytes = read_file(path)};
  if (video.type == "video/webm") {
    require(text_of(video.bytes).starts_with("\x1a\x45\xdf\xa3"),
            fmt::format("{}: it is no WebM ({} bytes); make it again with export or relight", name,
                        video.bytes.size()));
    return video;
  }
  const Mp4Video found = mp4_video(video.bytes, name);
  video.rate = found.rate;
  warn_of_codec(name, found.codec, messages);
  require(!found.pictures || *found.pictures == options.frames,
          fmt::format("{}: it has {} pictures, and the film {} frames: name the frames it "
                      "was made of with {}, or make it again of these",
                      name, found.pictures.value_or(0), options.frames, option_name("frames")));
  if (!found.rate || !options.rate) return video;
  const std::string both = fmt::format("{}: found {:.6g} frames a second, and {} has {:.6g}", option_name("rate"),
                                       *options.rate, name, *found.rate);
  require(std::abs(*options.rate / *found.rate - 1) * double(options.frames) < 0.5,
          fmt::format("{}; leave {} out, which takes that", both, option_name("rate")));
  if (std::abs(*options.rate / *found.rate - 1) > same_rate)
    messages.remark(both + ": the film has that of the video, which is less than half a frame away at its end");
  return video;
}

CapturedFilmVideo captured_film_video(CapturedTextures& captured, const VideoOptions& options,
                                      Messages& messages, const Progress& progress) {
  const TemporaryFolder work = work_folder();
  const fs::path path = work / "textures.mp4";
  CapturedFilmVideo made;
  made.figures = write_captured(captured, path.string(), options, Compression::none, messages, progress);
  made.video.bytes = read_file(path);
  return made;
}

FilmVideo picture_film_video(const std::vector<const Image<float>*>& pictures, const VideoOptions& options,
                             const Progress& progress) {
  // Videos have even sides, and texture coordinates count all texels.
  int width = 2, height = 2;
  for (const Image<float>* picture : pictures) {
    width = std::max(width, picture->width() + picture->width() % 2);
    height = std::max(height, picture->height() + picture->height() % 2);
  }
  const TemporaryFolder work = work_folder();
  VideoWriter video(work / "textures.mp4", width, height, options, progress);
  const Image<float>* last = nullptr;
  Image<float> scaled(width, height, 3, untextured_grey);
  for (std::size_t f = 0; f < pictures.size(); ++f) {
    if (pictures[f] != last)  // videos have no opacity: what lies under alpha is shown
      scaled = pictures[f]->values().empty() ? Image<float>(width, height, 3, untextured_grey)
                                             : area_scaled(as_rgb(*pictures[f], std::nullopt), width, height);
    last = pictures[f];
    video.write(scaled);
    progress.at(double(f + 1) / double(pictures.size()));
  }
  video.finish();
  return {.bytes = read_file(work / "textures.mp4")};
}

}  // namespace mq
