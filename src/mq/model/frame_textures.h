#pragma once
/// Textures of the frames of an evolving mesh as files: a model a frame with its picture beside it,
/// a picture a frame, or a video.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "mq/base/progress.h"
#include "mq/image/image.h"
#include "mq/io/model.h"
#include "mq/io/video.h"
#include "mq/mesh/mesh.h"
#include "mq/model/messages.h"

namespace mq {

class FrameTextures {
 public:
  /// `output` is a model or a picture with a place for the frame's number, or a video.
  /// Throws `InvalidInput` where it is none of these; nothing is written yet.
  explicit FrameTextures(std::string output);

  /// All files that frames of these numbers make.
  std::vector<std::filesystem::path> paths(const std::vector<int>& numbers) const;

  bool is_video() const;

  /// What a frame's values are: light (kept as it is in EXR, else brought to display values), or
  /// display values.
  enum class Values { display, light };

  struct Frame {
    int number = 0;
    const Mesh& mesh;           ///< of interest where models are written
    const Image<char>& inside;  ///< texels of charts; in a video others keep what they showed
    const Image<float>& pixels;
    Values values = Values::display;
    Depth depth = Depth::u8;  ///< as files hold it that can
  };

  /// The next frame; `options` are those of a video, and so is `progress`, as `VideoWriter` has it.
  /// Remarks what is worth telling of the video, with its first frame. Throws `InvalidInput` as
  /// `require_whole_video` does.
  void write(const Frame& frame, const VideoOptions& options, Messages& messages,
             const Progress& progress = {});

  /// After the last: a video is in its place from then on.
  void finish();

 private:
  void write_to_video(Image<float> pixels, const Frame& frame, const VideoOptions& options,
                      Messages& messages, const Progress& progress);

  std::string output_;
  std::unique_ptr<VideoWriter> video_;
  Image<float> shown_;  ///< the frame before, of a video
};

/// Texture coordinates count all texels: throws `InvalidInput` where a video of this name would
/// lose a row or column of so many.
void require_whole_video(const std::filesystem::path& path, int width, int height);

}  // namespace mq
