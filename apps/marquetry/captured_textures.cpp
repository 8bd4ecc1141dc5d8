#include "captured_textures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>

#include "mq/base/error.h"
#include "mq/image/colour.h"
#include "mq/io/frame_files.h"
#include "mq/io/model.h"
#include "mq/io/vertex_colours.h"
#include "mq/io/video.h"
#include "mq/sequence/texture_frame.h"
#include "outputs.h"

namespace mq::app {
namespace {

namespace fs = std::filesystem;

/// The pictures that can be written.
constexpr std::array picture_endings = {".png", ".exr",  ".tif", ".tiff",
                                        ".jpg", ".jpeg", ".bmp", ".tga"};

bool names_picture(const fs::path& path) {
  return std::ranges::find(picture_endings, path.extension().string()) != picture_endings.end();
}

/// Of a model's file, that of its picture.
fs::path picture_of(fs::path model) { return model.replace_extension(".png"); }

Texture as_texture(const Image<float>& pixels, bool light, const std::string& name,
                   const fs::path& path) {
  Texture texture;
  texture.name = name;
  const bool as_light = light && path.extension() == ".exr";
  texture.pixels =
      light && !as_light ? encode(pixels, ColourSpace::linear, Transfer::srgb) : pixels;
  texture.format.depth = path.extension() == ".exr" ? Depth::half : Depth::u8;
  return texture;
}

}  // namespace

void add_captured_texture_options(OptionTable& table) {
  using Type = Option::Type;
  const std::string group = "Textures";
  table.add({.name = "from",
             .type = Type::path,
             .metavar = "SEQUENCE",
             .group = group,
             .help = "the captured frames: what they show is written as textures",
             .details = "frame_%04d.ply, or a folder, with the numbers of the evolving mesh's "
                        "frames. The evolving mesh must have an atlas (unwrap, evolve). OUT is a "
                        "model a frame, a picture a frame, such as texture_%04d.png, or a video "
                        "(.mp4, .mov, .webm, .mkv)."});
  table.add({.name = "texture",
             .type = Type::path,
             .group = group,
             .help = "pictures instead of those the captured frames name, %04d for the number"});
  table.add({.name = "size",
             .letter = 's',
             .type = Type::integer,
             .default_value = "1024",
             .unit = "texels",
             .least = 1,
             .most = 16384,
             .group = group,
             .help = "side of the textures"});
  table.add({.name = "samples",
             .type = Type::integer,
             .default_value = "2",
             .least = 1,
             .most = 8,
             .group = group,
             .help = "per texel and direction"});
}

std::vector<fs::path> captured_texture_paths(const OptionValues& options,
                                             const EvolvingReader& reader,
                                             const std::vector<int>& frames) {
  const std::string output = options.text("output");
  if (names_video(output)) return {output};
  require((names_model(output) || names_picture(output)) && has_frame_place(output),
          fmt::format("--output: found '{}', wanted a model or a picture with a place for the "
                      "frame's number, such as frame_%04d.obj or texture_%04d.png, or a video",
                      output));
  std::vector<fs::path> paths;
  for (const int f : frames) {
    paths.emplace_back(frame_name(output, reader.frames()[std::size_t(f)].number));
    if (names_model(output)) paths.push_back(picture_of(paths.back()));
  }
  return paths;
}

void write_captured_textures(Run& run, const EvolvingReader& reader,
                             const std::vector<int>& frames) {
  const OptionValues& options = run.options();
  const std::string output = options.text("output");
  std::vector<int> numbers;
  for (const int f : frames) numbers.push_back(reader.frames()[std::size_t(f)].number);
  const std::vector<FrameFile> files = find_frames(options.text("from"), numbers);
  for (const FrameFile& file : files) run.will_read(file.path);
  const int size = int(options.integer("size"));
  const TextureFrameOptions how{
      .width = size, .height = size, .samples = int(options.integer("samples"))};
  const Step step(run, "textures", 0.9);
  std::unique_ptr<VideoWriter> video;
  run.result["textures"] = Json::array();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const Progress part =
        step.progress().step(fmt::format("frame {}", numbers[i]), 1.0 / double(frames.size()));
    const EvolvingSegment segment = reader.segment(reader.frames()[frames[i]].segment);
    require(!segment.uvs.empty(),
            fmt::format("{}: it has no texture coordinates: give it some with the verb unwrap",
                        reader.manifest().string()));
    ReadModelOptions reading;
    if (options.has("texture"))
      reading.textures = {frame_name(options.text("texture"), numbers[i])};
    const Model captured = read_model(files[i].path, reading);
    require(has_colours(captured),
            fmt::format("{}: --from wants colours at vertices or a texture, and it has neither",
                        files[i].path.string()));
    Model model;
    model.mesh = mesh_of(segment, reader.positions(frames[i]));
    const TextureFrame frame =
        resample_texture(model.mesh, captured.mesh, surface_colours(captured), how, part);
    run.result["textures"].push_back(
        {{"frame", numbers[i]}, {"texels", frame.texels}, {"unseen", frame.unseen}});
    const bool light = captured.colors.channels == 0 && holds_light(captured.textures[0].format);
    if (names_video(output)) {
      if (!video)
        video = std::make_unique<VideoWriter>(output, size, size,
                                              VideoOptions{.rate = options.number("rate")});
      video->write(as_texture(frame.picture, light, "", output).pixels);
      continue;
    }
    const fs::path path = frame_name(output, numbers[i]);
    if (names_model(output)) {
      const fs::path picture = picture_of(path);
      model.textures = {as_texture(frame.picture, light, picture.filename().string(), picture)};
      write_model(path, model);
    } else
      write_texture(path, as_texture(frame.picture, light, "", path));
  }
  if (video) video->finish();
}

}  // namespace mq::app
