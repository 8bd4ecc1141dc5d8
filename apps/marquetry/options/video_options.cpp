#include "options/video_options.h"

#include "mq/base/error.h"
#include "options/signal_options.h"
#include "shell/arguments.h"

namespace mq::app {

void add_codec_option(OptionTable& table) {
  table.add({.name = "codec",
             .type = Option::Type::choice,
             .default_value = "auto",
             .choices = video_codec_names(),
             .metavar = "NAME",
             .help = "of a video: auto, h264, h265, av1, vp9 or ffv1",
             .details = "auto: H.264 in .mp4 and .mov, VP9 in .webm, FFV1, which loses nothing, in "
                        ".mkv. Not all players know H.265 and AV1, which are smaller."});
}

VideoOptions video_options(const OptionValues& options) {
  return {.rate = options.has("rate") ? options.number("rate") : VideoOptions{}.rate,
          .codec = video_codec(options.text("codec"))};
}

void require_video_for_codec(const OptionValues& options, bool is_made) {
  require(is_made || !asks_for(options, "codec"), "--codec: it is of videos, and none is made");
}

void add_rate_option(OptionTable& table) {
  table.add({.name = "rate",
             .type = Option::Type::number,
             .default_value = as_typed(VideoOptions{}.rate),
             .unit = "frames a second",
             .least = 0.001,
             .most = 100000,
             .help = "of an animation, or a video, which has 1000 at most"});
}

}  // namespace mq::app
