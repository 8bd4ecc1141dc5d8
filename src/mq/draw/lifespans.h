#pragma once
/// How long charts of an evolving mesh live, as a picture.

#include "mq/base/progress.h"
#include "mq/draw/render.h"
#include "mq/evolving/lifespan_atlas.h"

namespace mq {

/// The colour of a chart that lives from frame `first` to `last` of `count` (thesis, figure 6.9):
/// grey where that is all of them, the more saturated the shorter it lives; red at the beginning of
/// the sequence, green in its middle, blue at its end.
Colour lifespan_colour(int first, int last, int count);

/// The surface in a frame (counted from 0) and its texture, side by side, each `side` pixels high,
/// in the colours of the charts' lives. `evolving` is what `atlas` was laid out for.
Image<float> draw_lifespans(const EvolvingMesh& evolving, const LifespanAtlas& atlas, int frame,
                            const View& view, int side, const Progress& progress = {});

/// Up to six of the frames so, evenly chosen, with their numbers; each `side` pixels high.
Image<float> draw_lifespan_sheet(const EvolvingMesh& evolving, const LifespanAtlas& atlas,
                                 const View& view, int side = 400, const Progress& progress = {});

}  // namespace mq
