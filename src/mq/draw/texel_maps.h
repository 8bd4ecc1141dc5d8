#pragma once
/// Pictures of which texels charts use, and for what.

#include <cstdint>
#include <vector>

#include "mq/atlas/atlas.h"
#include "mq/base/defect.h"
#include "mq/base/progress.h"
#include "mq/image/image.h"

namespace mq {

enum class TexelUse {
  active,    ///< white: a lookup on the surface reads the texel
  boundary,  ///< white: those of them that a seam or an end of the surface touches
  chart,     ///< of those a colour for each chart
  triangle,  ///< a colour for each triangle that covers centres of texels; of several the first
  overlap,   ///< white: two triangles or more cover the centre
  depth      ///< how many triangles cover the centre, as n/255, at most 1
};

struct TexelMaps {
  std::vector<Image<float>> pictures;  ///< one per texture, in colours or grey; black: not so used
  std::int64_t marked = 0;             ///< texels that are not black
  Defects defects;                     ///< of the texel space, where one was made
};

/// Where marked texels hang together, the largest places first.
std::vector<Defect::Place> marked_places(const TexelMaps& maps);

/// Marks the texels within so many columns and rows of a marked one too, so that a few can be seen; `marked`
/// stays. Of pictures in black and white.
void grow(TexelMaps& maps, int texels);

/// Colours are three times 8 bits, another for each of the first 2²⁴ − 1 charts or triangles, far
/// apart for neighbours in number. Throws what `TexelSpace` throws for the first three uses.
TexelMaps texel_maps(const Surface& surface, const Atlas& atlas, TexelUse use,
                     const Progress& progress = {});

}  // namespace mq
