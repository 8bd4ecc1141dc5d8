#pragma once
/// Textures of the frames of an evolving mesh as files: a model a frame with its picture beside it,
/// a picture a frame, or a video.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "mq/base/options.h"
#include "mq/image/image.h"
#include "mq/io/model.h"
#include "mq/io/video.h"
#include "mq/mesh/mesh.h"

namespace mq::app {

class FrameTextures {
 public:
  /// `output` is --output. Throws `InvalidInput` where it names none of these; nothing is written
  /// yet.
  explicit FrameTextures(const std::string& output);

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
  /// Returns what is worth telling of the video, with its first frame. Throws `InvalidInput` as
  /// `require_whole_video` does.
  std::vector<std::string> write(const Frame& frame, const VideoOptions& options,
                                 const Progress& progress);

  /// After the last.
  void finish();

 private:
  std::string output_;
  std::unique_ptr<VideoWriter> video_;
  Image<float> shown_;  ///< the frame before, of a video
};

/// Texture coordinates count all texels: throws `InvalidInput` where a video of this name would
/// lose a row or column of so many.
void require_whole_video(const std::filesystem::path& path, int width, int height);

/// Adds --rate, and --codec; what they say.
void add_rate_option(OptionTable& table);
void add_codec_option(OptionTable& table);
VideoOptions video_options(const OptionValues& options);

/// Throws `InvalidInput` where --codec is given and no video is made.
void require_video_for_codec(const OptionValues& options, bool is_made);

}  // namespace mq::app
