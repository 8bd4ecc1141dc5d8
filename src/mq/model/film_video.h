#pragma once
/// Texture videos that a browser is given with the film of an evolving mesh.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mq/base/progress.h"
#include "mq/io/bytes.h"
#include "mq/io/video.h"
#include "mq/model/captured_files.h"
#include "mq/model/messages.h"

namespace mq {

struct FilmVideo {
  std::string type = "video/mp4";   ///< or video/webm
  Bytes bytes = {};                 ///< empty: there is none
  std::optional<double> rate = {};  ///< its own, where its index says it
};

/// The type of videos of this name that browsers play. Throws `InvalidInput` where they play
/// none.
std::string film_video_type(const std::filesystem::path& path);

struct FilmVideoOptions {
  std::int64_t frames = 0;          ///< of the film
  std::optional<double> rate = {};  ///< that is asked for
};

/// Reads a video that is there already, .mp4 or .webm. Browsers say nothing of a file that is no
/// video, and show nothing; of one with other pictures than the film's they show the wrong ones. So
/// throws `InvalidInput` where an .mp4's index counts other pictures than the film has frames, or
/// its rate is another than is asked for by half a frame at the end; and where a .webm does not
/// begin as one. Remarks where it is another by less, as the film takes the video's. Warns of
/// codecs that few browsers play. Throws `IoError` as `read_file` and `mp4_video`.
FilmVideo read_film_video(const std::filesystem::path& path, const FilmVideoOptions& options,
                          Messages& messages);

/// Warns that few browsers play what is kept so.
void warn_of_unplayed_codec(const std::string& name, const std::string& codec, Messages& messages);

struct CapturedFilmVideo {
  FilmVideo video;
  std::vector<CapturedFigures> figures;  ///< what was seen
};

/// What captured frames show, as an .mp4 made in a folder of its own that is gone afterwards.
/// Throws as `write_captured`.
CapturedFilmVideo captured_film_video(CapturedTextures& captured, const VideoOptions& options,
                                      Messages& messages, const Progress& progress = {});

/// Pictures, one for each frame in turn, as an .mp4 made in the same way, `rate` of them a second. Smaller ones are
/// scaled to the largest; what has no pixels is grey. Throws as `VideoWriter`.
FilmVideo picture_film_video(const std::vector<const Image<float>*>& pictures, const VideoOptions& options,
                             const Progress& progress = {});

}  // namespace mq
