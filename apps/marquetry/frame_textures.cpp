#include "frame_textures.h"

#include <fmt/format.h>


#include "mq/base/error.h"
#include "mq/image/colour.h"
#include "mq/io/frame_files.h"
#include "mq/io/model.h"
#include "mq/sequence/gutter.h"
#include "outputs.h"

namespace mq::app {
namespace {

namespace fs = std::filesystem;

/// Of a model's file, that of its picture.
fs::path picture_of(fs::path model) { return model.replace_extension(".png"); }

Texture as_texture(const Image<float>& pixels, FrameTextures::Values values,
                   const std::string& name, const fs::path& path) {
  const bool exr = path.extension() == ".exr";
  Texture texture;
  texture.name = name;
  texture.pixels = values == FrameTextures::Values::light && !exr
                       ? encode(pixels, ColourSpace::linear, Transfer::srgb)
                       : pixels;
  texture.format.depth = exr ? Depth::half : Depth::u8;
  return texture;
}

}  // namespace

FrameTextures::FrameTextures(const std::string& output) : output_(output) {
  require(is_video() || ((names_model(output) || names_picture(output)) && has_frame_place(output)),
          fmt::format("--output: found '{}', wanted a model or a picture with a place for the "
                      "frame's number, such as frame_%04d.obj or texture_%04d.png, or a video",
                      output));
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

std::vector<std::string> FrameTextures::write(const Frame& frame, double rate) {
  if (is_video()) {
    Image<float> pixels = as_texture(frame.pixels, frame.values, "", output_).pixels;
    const bool first = !video_;
    if (first)
      video_ = std::make_unique<VideoWriter>(output_, pixels.width(), pixels.height(),
                                             VideoOptions{.rate = rate});
    else
      hold_gutter(frame.inside, seen_margin, shown_, pixels);
    video_->write(pixels);
    shown_ = std::move(pixels);
    return first ? video_->notes() : std::vector<std::string>();
  }
  const fs::path path = frame_name(output_, frame.number);
  if (!names_model(output_)) {
    write_texture(path, as_texture(frame.pixels, frame.values, "", path));
    return {};
  }
  const fs::path picture = picture_of(path);
  Model model;
  model.mesh = frame.mesh;
  model.textures = {as_texture(frame.pixels, frame.values, picture.filename().string(), picture)};
  write_model(path, model);
  return {};
}

void FrameTextures::finish() {
  if (video_) video_->finish();
}

void add_rate_option(OptionTable& table) {
  table.add({.name = "rate",
             .type = Option::Type::number,
             .default_value = "30",
             .unit = "frames a second",
             .least = 0.001,
             .most = 100000,
             .help = "of an animation, or a video"});
}

}  // namespace mq::app
