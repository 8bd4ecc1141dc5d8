#pragma once
/// Textures of the frames of an evolving mesh as files: a model a frame with its picture beside it,
/// a picture a frame, or a video.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "mq/base/options.h"
#include "mq/image/image.h"
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
  };

  /// The next frame; `rate` is that of a video. Returns what is worth telling of the
  /// video, with its first frame.
  std::vector<std::string> write(const Frame& frame, double rate);

  /// After the last.
  void finish();

 private:
  std::string output_;
  std::unique_ptr<VideoWriter> video_;
  Image<float> shown_;  ///< the frame before, of a video
};

/// Adds --rate.
void add_rate_option(OptionTable& table);

}  // namespace mq::app
