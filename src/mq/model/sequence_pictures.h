#pragma once
/// How well a sequence was followed, as pictures: a plot over time, and a strip of frames.

#include <functional>
#include <vector>

#include "mq/base/progress.h"
#include "mq/draw/render.h"
#include "mq/image/image.h"
#include "mq/io/evolving_file.h"
#include "mq/io/followed_frame.h"
#include "mq/io/model.h"

namespace mq {

/// Distances, triangles, distortion, time and drift over the frames' numbers, of which there is at
/// least one. What is not known of any frame is left out; an empty picture where nothing is.
Image<float> sequence_plot(const std::vector<FollowedFrame>& frames);

/// Up to eight frames of a store, evenly chosen: what was captured, what follows it in the colours
/// of the first frame, or of places in it where it has none (grey: added later), and how far that
/// is from what was captured. `captured` reads the frame of the store with this index.
Image<float> sequence_strip(const EvolvingReader& reader,
                            const std::function<Model(int frame)>& captured, const View& view,
                            const Progress& progress = {});

}  // namespace mq
