#pragma once
/// Videos, made by the program `ffmpeg`, to which pictures are sent one by one.
///
///     VideoWriter video("clip.mp4", 640, 480, {.rate = 30});
///     for (...) video.write(picture);
///     video.finish();
///
/// The name says how pictures are kept: .mp4 and .mov as H.264, .webm as VP9 (both of constant
/// quality, 4:2:0, BT.709), .mkv without any loss of their 8 bits (FFV1). Nobody sees half a video:
/// it is written under a temporary name and renamed by `finish`.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "mq/base/progress.h"
#include "mq/image/image.h"

namespace mq {

/// Whether a name ends like a video that can be written: .mp4, .mov, .webm or .mkv.
bool names_video(const std::filesystem::path& path);

/// Throws `IoError`, saying how to install it, where there is no `ffmpeg` to make videos with:
/// asked before long work whose result is one.
void require_video_program(const std::filesystem::path& path);

/// `automatic`: as said above, by the name.
enum class VideoCodec { automatic, h264, h265, av1, vp9, ffv1 };

/// auto, h264, h265, av1, vp9 and ffv1, and what they name. Throws `InvalidInput` for others.
std::vector<std::string> video_codec_names();
VideoCodec video_codec(const std::string& name);

struct VideoOptions {
  double rate = 30;  ///< frames per second, 1/1000 to 1000
  VideoCodec codec = VideoCodec::automatic;
};

/// Throws `InvalidInput` where a file of this name does not hold the codec, with those that do, and
/// for a rate out of range.
void require_video_options(const std::filesystem::path& path, const VideoOptions& options);

class VideoWriter {
 public:
  /// Starts `ffmpeg`. Throws `IoError` when it is not installed (it says how to install it) or the
  /// place cannot be written to, `InvalidInput` for a name of another kind, for pictures without
  /// pixels or with a side above 16384, and as `require_video_options`. Waiting for `ffmpeg` ends
  /// with `Cancelled` when `progress` is asked to stop.
  VideoWriter(const std::filesystem::path& path, int width, int height,
              const VideoOptions& options = {}, const Progress& progress = {});

  /// Stops `ffmpeg` and removes what it has written, unless the video is finished.
  ~VideoWriter();

  /// The next frame, in display values from 0 to 1, rounded to 8 bits: grey or colours; what is
  /// transparent is seen before black. A side of odd length loses its last row or column except in
  /// .mkv. Throws `InvalidInput` for another size than was announced, `IoError` with what `ffmpeg`
  /// says when it has ended early.
  void write(const Image<float>& picture);

  /// What is worth telling: that sides of odd length are cut.
  std::vector<std::string> notes() const;

  /// Waits for `ffmpeg`, then puts the video in its place. Throws `IoError` as `write` does.
  void finish();

 private:
  class Process;
  std::filesystem::path path_;
  int width_, height_;
  std::unique_ptr<Process> process_;
};

}  // namespace mq
