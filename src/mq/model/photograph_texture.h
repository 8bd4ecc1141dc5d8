#pragma once
/// A texture of many photographs with cameras, which are read one after another.

#include <cstdint>
#include <span>
#include <vector>

#include "mq/draw/photograph.h"
#include "mq/filter/stitch.h"
#include "mq/io/cameras.h"
#include "mq/model/model_signal.h"
#include "mq/views/view_choice.h"

namespace mq {

struct PhotographTextureOptions {
  PhotographOptions projection = {};
  ChooseOptions choice = {};
  RejectOptions rejection = {};
  bool align = false;          ///< move cameras a little, so that photographs agree
  bool match_exposure = true;  ///< even out how photographs were exposed; else their colours are kept
  bool reject_outliers = true;
  int patch = 8;  ///< texels, the side of the squares that photographs are chosen for
};

struct PhotographTexture {
  Signal values;            ///< per unknown, of the photograph chosen for it; the mean where unseen
  std::vector<int> labels;  ///< its number, or `unseen`
  BeyondBorders beyond;     ///< what photographs show past their borders
  Signal offset;            ///< per unknown: to the mean of all photographs that agree on its patch
  int patches = 0;

  struct View {
    std::int64_t texels = 0;    ///< that come from it
    std::int64_t patches = 0;   ///< that it shows
    std::int64_t rejected = 0;  ///< of these, where it does not agree with the others
    LightColour gain = {1, 1, 1};
    double moved = 0;  ///< by alignment, pixels
  };
  std::vector<View> views;
  std::vector<std::int64_t> seen_by;  ///< texels whose patch 0, 1, 2, ... photographs show
};

/// Every photograph is read twice, for choosing and for colours, and forgotten; what is kept of each is a
/// colour and two numbers per patch that it shows.
///
/// 0. Where asked, cameras are aligned (`align_photographs`), for which photographs are read once more, and
///    their brightness is held at a million pixels at most.
/// 1. At a few texels of each patch (views/patches.h) it is found how well each photograph shows it
///    (`Projector`), in which colour, and with how much detail.
/// 2. Photographs are chosen (views/view_choice.h).
/// 3. A texel that the one chosen for its patch does not show has the next best that does.
/// 4. Colours are taken from photographs that are reduced to about a pixel per texel, their exposure
///    evened out in light.
///
/// Throws what `partials_of_photographs` throws. Equal bits for any number of threads.
PhotographTexture texture_of_photographs(const TexturedModel& model, const TextureSignal& signal,
                                         std::span<const Photograph> photographs,
                                         const PhotographTextureOptions& options, Messages& messages,
                                         const Progress& progress = {});

/// How far steps between photographs spread, unless asked otherwise.
inline constexpr Length usual_photograph_length = {3, Length::Unit::percent};

/// Red, green and blue, a row per label: neighbouring numbers in unlike hues; what is unseen is black.
Signal colours_of_labels(std::span<const int> labels);

/// The side of a square texture, the nearest power of two from 256 to 8192, in which a texel is about as large as a
/// pixel of the photographs where these show the surface best: the median over the area
/// of the triangles, by the closest camera that faces each, whether or not something is in front. `occupancy`: the share of
/// the texture that charts will fill. 1024 where no camera faces any.
int side_for_photographs(const Surface& surface, std::span<const Photograph> photographs,
                         double occupancy = 0.7);

}  // namespace mq
