#include "mq/model/captured_files.h"

#include <fmt/format.h>

#include <algorithm>

#include "mq/base/error.h"
#include "mq/image/colour.h"
#include "mq/io/animation.h"
#include "mq/io/file_names.h"
#include "mq/io/frame_files.h"
#include "mq/io/model.h"
#include "mq/model/frame_textures.h"
#include "mq/model/stored_frames.h"

namespace mq {
namespace {

namespace fs = std::filesystem;

void require_atlas_unless_models(const EvolvingReader& reader, const std::string& output) {
  require(has_atlas(reader) || (names_model(output) && !names_animation(output)),
          fmt::format("{}: it has no texture coordinates: unwrap it first, or "
                      "export models (frame_%04d.ply), which get colours at vertices",
                      reader.manifest().string()));
}

CapturedFigures figures(const CapturedTextures::Textured& shown) {
  const TextureFrame& texture = shown.texture;
  CapturedFigures found{.number = shown.number,
                        .count = texture.texels,
                        .unseen = texture.unseen,
                        .filled = texture.filled,
                        .accuracy = texture.accuracy};
  if (shown.steps_were_taken_out)
    found.steps = CapturedFigures::Steps{texture.before, texture.after};
  found.changed = shown.changed;
  return found;
}

CapturedFigures figures(const CapturedTextures::Coloured& shown) {
  return {.number = shown.number,
          .of = CapturedFigures::Of::vertices,
          .count = shown.model.mesh.vertex_count(),
          .unseen = shown.unseen,
          .filled = shown.unseen,
          .accuracy = shown.accuracy};
}

/// The frames from the first of these numbers to the last.
AnimationPart part_of(const EvolvingReader& reader, const std::vector<int>& numbers) {
  const auto index = [&](int number) {
    return int(std::ranges::find(reader.frames(), number, &StoredFrame::number) - reader.frames().begin());
  };
  return {.first = index(numbers.front()), .last = index(numbers.back())};
}

/// As files want it; of what must stay.
FrameTextures::Frame as_frame(const CapturedTextures::Textured& shown) {
  return {.number = shown.number,
          .mesh = shown.mesh,
          .inside = shown.texture.inside,
          .pixels = shown.texture.picture,
          .values = shown.is_light ? FrameTextures::Values::light : FrameTextures::Values::display,
          .depth = shown.depth};
}

/// In the unit of the files that are written.
void bring_to_unit(Mesh& mesh, const std::string& output, const EvolvingReader& reader) {
  for (Vector3& p : mesh.positions) p *= unit_in(output, reader);
}

/// As a display is given it.
Image<float> displayed(const CapturedTextures::Textured& shown) {
  const Image<float>& picture = shown.texture.picture;
  return shown.is_light ? encode(picture, ColourSpace::linear, TransferFunction::srgb) : picture;
}

std::vector<CapturedFigures> write_captured_animation(CapturedTextures& captured,
                                                      const std::string& output, double rate,
                                                      Compression compression, const Progress& progress) {
  std::vector<CapturedFigures> found;
  write_animation(
      output, captured.reader(), {captured.frames().front(), captured.frames().back(), rate, compression},
      [&](int frame) {
        const CapturedTextures::Textured shown = captured.texture(frame);
        found.push_back(figures(shown));
        return displayed(shown);
      },
      progress.step("write", 1));
  return found;
}

/// A step of the progress for each frame, after which it is written.
template <class Write>
std::vector<CapturedFigures> for_each_captured(const CapturedTextures& captured,
                                               const Progress& progress, const Write& write) {
  const std::vector<int>& frames = captured.frames();
  std::vector<CapturedFigures> found;
  for (const int f : frames)
    found.push_back(write(
        f, progress.step(fmt::format("frame {}", captured.reader().frames()[std::size_t(f)].number),
                         1.0 / double(frames.size()))));
  return found;
}

}  // namespace

std::vector<fs::path> captured_files(const EvolvingReader& reader, const std::vector<int>& numbers,
                                     const std::string& output) {
  if (!names_animation(output)) {
    const FrameTextures files(output);
    if (has_atlas(reader)) return files.paths(numbers);
  }
  require_atlas_unless_models(reader, output);
  if (names_animation(output))
    return animation_files(output, reader, part_of(reader, numbers), [](int) { return true; });
  std::vector<fs::path> paths;
  for (const int number : numbers) paths.emplace_back(frame_name(output, number));
  return paths;
}

void require_holds_captured(const EvolvingReader& reader, const std::string& output, int side,
                            const VideoOptions& video) {
  require_atlas_unless_models(reader, output);
  if (!names_video(output)) return;
  require_video_options(output, video);
  require_whole_video(output, side, side);
}

std::vector<CapturedFigures> write_captured(CapturedTextures& captured, const std::string& output,
                                            const VideoOptions& video, Compression compression,
                                            Messages& messages,
                                            const Progress& progress) {
  require_holds_captured(captured.reader(), output, captured.side(), video);
  if (names_animation(output))
    return write_captured_animation(captured, output, video.rate, compression, progress);
  if (!has_atlas(captured.reader()))
    return for_each_captured(captured, progress, [&](int frame, const Progress&) {
      CapturedTextures::Coloured shown = captured.at_vertices(frame);
      bring_to_unit(shown.model.mesh, output, captured.reader());
      write_model(frame_name(output, shown.number), shown.model);
      return figures(shown);
    });
  FrameTextures files(output);
  std::vector<CapturedFigures> found = for_each_captured(captured, progress, [&](int frame, const Progress& part) {
    CapturedTextures::Textured shown = captured.texture(frame, part);
    bring_to_unit(shown.mesh, output, captured.reader());
    files.write(as_frame(shown), video, messages, progress);
    return figures(shown);
  });
  files.finish();
  return found;
}

}  // namespace mq
