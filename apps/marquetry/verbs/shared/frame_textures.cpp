#include "verbs/shared/frame_textures.h"

#include <fmt/format.h>

#include <algorithm>

#include "mq/base/error.h"
#include "mq/image/colour.h"
#include "mq/io/file_names.h"
#include "mq/io/frame_files.h"
#include "mq/io/model.h"
#include "mq/video/gutter.h"
#include "shell/arguments.h"
#include "shell/results.h"
#include "options/signal_options.h"

namespace mq::app {
namespace {

namespace fs = std::filesystem;

/// Of a model's file, that of its picture.
fs::path picture_of(fs::path model) { return model.replace_extension(".png"); }

/// EXR holds halves at least, the others 16 bits at most.
Texture as_texture(const FrameTextures::Frame& frame, const std::string& name,
                   const fs::path& path) {
  const bool exr = path.extension() == ".exr";
  Texture texture;
  texture.name = name;
  texture.pixels = frame.values == FrameTextures::Values::light && !exr
                       ? encode(frame.pixels, ColourSpace::linear, TransferFunction::srgb)
                       : frame.pixels;
  texture.format.depth =
      exr ? std::max(frame.depth, Depth::half) : std::min(frame.depth, Depth::u16);
  return texture;
}

}  // namespace

FrameTextures::FrameTextures(const std::string& output) : output_(output) {
  require(is_video() || ((names_model(output) || names_picture(output)) && has_frame_place(output)),
          fmt::format("--output: found '{}', wanted a model or a picture with a place for the "
                      "frame's number, such as frame_%04d.obj or texture_%04d.png, or a video",
                      output));
}

void require_whole_video(const fs::path& path, int width, int height) {
  require(path.extension() == ".mkv" || (width % 2 == 0 && height % 2 == 0),
          fmt::format("textures of {} × {} texels: {} videos halve both sides, so wanted are even "
                      "ones (.mkv holds all)",
                      width, height, path.extension().string()));
}

bool FrameTextures::is_video() const { return names_video(output_); }

std::vector<fs::path> FrameTextures::paths(const std::vector<int>& numbers) const {
  if (is_video()) return {output_};
  std::vector<fs::path> paths;
  for (const int number : numbers) {
    paths.emplace_back(frame_name(output_, number));
    if (names_model(output_)) paths.push_back(picture_of(paths.back()));
  }
  return paths;
}

std::vector<std::string> FrameTextures::write(const Frame& frame, const VideoOptions& options,
                                              const Progress& progress) {
  if (is_video()) {
    Image<float> pixels = as_texture(frame, "", output_).pixels;
    const bool first = !video_;
    if (first) {
      require_whole_video(output_, pixels.width(), pixels.height());
      video_ = std::make_unique<VideoWriter>(output_, pixels.width(), pixels.height(), options,
                                             progress);
    }
    if (!first) hold_gutter(frame.inside, seen_margin, shown_, pixels);
    video_->write(pixels);
    shown_ = std::move(pixels);
    return first ? video_->notes() : std::vector<std::string>();
  }
  const fs::path path = frame_name(output_, frame.number);
  if (!names_model(output_)) {
    write_texture(path, as_texture(frame, "", path));
    return {};
  }
  const fs::path picture = picture_of(path);
  Model model;
  model.mesh = frame.mesh;
  model.textures = {as_texture(frame, picture.filename().string(), picture)};
  write_model(path, model);
  return {};
}

void FrameTextures::finish() {
  if (video_) video_->finish();
}

void add_codec_option(OptionTable& table) {
  table.add({.name = "codec",
             .type = Option::Type::choice,
             .default_value = "auto",
             .choices = video_codec_names(),
             .metavar = "NAME",
             .help = "of a video: auto, h264, h265, av1, vp9 or ffv1",
             .details = "auto: H.264 in .mp4 and .mov, VP9 in .webm, FFV1, which loses nothing, in "
                        ".mkv. Not all players know H.265 and AV1, which are smaller."});
}

VideoOptions video_options(const OptionValues& options) {
  return {.rate = options.has("rate") ? options.number("rate") : VideoOptions{}.rate,
          .codec = video_codec(options.text("codec"))};
}

void require_video_for_codec(const OptionValues& options, bool is_made) {
  require(is_made || !asks_for(options, "codec"), "--codec: it is of videos, and none is made");
}

void add_rate_option(OptionTable& table) {
  table.add({.name = "rate",
             .type = Option::Type::number,
             .default_value = as_typed(VideoOptions{}.rate),
             .unit = "frames a second",
             .least = 0.001,
             .most = 100000,
             .help = "of an animation, or a video, which has 1000 at most"});
}

}  // namespace mq::app
