#include "mq/model/frame_textures.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/image/colour.h"
#include "mq/io/file_names.h"
#include "mq/io/frame_files.h"
#include "mq/video/gutter.h"

namespace mq {
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

FrameTextures::FrameTextures(std::string output) : output_(std::move(output)) {
  require(
      is_video() || ((names_model(output_) || names_picture(output_)) && has_frame_place(output_)),
      fmt::format("{}: found '{}', wanted a model or a picture with a place for the frame's "
                  "number, such as frame_%04d.obj or texture_%04d.png, an animation (.glb, .usda or "
                  ".usdz), or a video (.mp4, .mov, .webm or .mkv)",
                  option_name("output"), output_));
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
    if (!names_model(output_)) continue;
    const fs::path model = paths.back();
    paths.push_back(picture_of(model));
    std::ranges::copy(files_beside_made(model, 1), std::back_inserter(paths));
  }
  return paths;
}

void FrameTextures::write(const Frame& frame, const VideoOptions& options, Messages& messages,
                          const Progress& progress) {
  if (is_video()) {
    write_to_video(as_texture(frame, "", output_).pixels, frame, options, messages, progress);
    return;
  }
  const fs::path path = frame_name(output_, frame.number);
  if (!names_model(output_)) {
    write_texture(path, as_texture(frame, "", path));
    return;
  }
  const fs::path picture = picture_of(path);
  Model model;
  model.mesh = frame.mesh;
  model.textures = {as_texture(frame, picture.filename().string(), picture)};
  write_model(path, model);
}

void FrameTextures::write_to_video(Image<float> pixels, const Frame& frame,
                                   const VideoOptions& options, Messages& messages,
                                   const Progress& progress) {
  if (video_) {
    hold_gutter(frame.inside, seen_margin, shown_, pixels);
    video_->write(pixels);
  } else {
    require_whole_video(output_, pixels.width(), pixels.height());
    video_ =
        std::make_unique<VideoWriter>(output_, pixels.width(), pixels.height(), options, progress);
    video_->write(pixels);
    for (const std::string& note : video_->notes()) messages.remark(note);
  }
  shown_ = std::move(pixels);
}

void FrameTextures::finish() {
  if (video_) video_->finish();
}

}  // namespace mq
