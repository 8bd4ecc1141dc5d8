#pragma once
/// What captured frames show, as files: textures of the evolving mesh that follows them as models,
/// pictures, a video or an animation; or where it has no atlas models with colours at vertices.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mq/base/progress.h"
#include "mq/io/evolving_file.h"
#include "mq/io/model.h"
#include "mq/io/video.h"
#include "mq/model/captured_textures.h"
#include "mq/model/messages.h"

namespace mq {

/// The files that frames with these numbers make, where `output` is what `FrameTextures` takes or
/// an animation (`names_animation`). Throws `InvalidInput` where it is none of these, and where the
/// store has no atlas and it names anything else than models.
std::vector<std::filesystem::path> captured_files(const EvolvingReader& reader,
                                                  const std::vector<int>& numbers,
                                                  const std::string& output);

/// Throws `InvalidInput` where files of this name cannot hold textures with sides of so many
/// texels: as `captured_files`, `require_video_options` and `require_whole_video` do.
void require_holds_captured(const EvolvingReader& reader, const std::string& output, int side,
                            const VideoOptions& video);

/// How much of a frame was seen.
struct CapturedFigures {
  int number = 0;
  enum class Of { texels, vertices } of = Of::texels;
  std::int64_t count = 0;   ///< of these, in charts
  std::int64_t unseen = 0;  ///< nothing was captured for them
  std::int64_t filled = 0;  ///< of these: have values from the surface around them
  double accuracy = 0;      ///< of the surface, model units

  /// Steps across borders of captured charts, where they were taken out.
  struct Steps {
    BorderJump before, after;
  };
  std::optional<Steps> steps = {};
  std::optional<double> changed = {};  ///< of photographs: `PhotographedFrames::changed`
};

/// Resamples the captured frames one by one and writes them to files of this name. An animation
/// takes all frames from the first to the last, at the rate of `video`, and has a texture for each
/// segment: figures are of these; `compression` is of an animation (`AnimationPart`). Throws as the functions above, `CapturedTextures` and what writes
/// the files.
std::vector<CapturedFigures> write_captured(CapturedTextures& captured, const std::string& output,
                                            const VideoOptions& video, Compression compression,
                                            Messages& messages,
                                            const Progress& progress = {});

}  // namespace mq
