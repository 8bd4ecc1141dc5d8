#pragma once
/// Options of verbs that may write a video.

#include "mq/base/options.h"
#include "mq/io/video.h"

namespace mq::app {

/// Adds --rate, and --codec; what they say.
void add_rate_option(OptionTable& table);
void add_codec_option(OptionTable& table);
VideoOptions video_options(const OptionValues& options);

/// Throws `InvalidInput` where --codec is given and no video is made.
void require_video_for_codec(const OptionValues& options, bool is_made);

}  // namespace mq::app
