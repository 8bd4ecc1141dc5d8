#pragma once
/// Which triangles cover the centres of texels.

#include <cstdint>
#include <span>
#include <vector>

#include "mq/atlas/atlas.h"
#include "mq/base/progress.h"
#include "mq/image/image.h"

namespace mq {

/// Per texel of one texture. A centre on an edge between two triangles that lie side by side is
/// covered once, by either; decided exactly (integers of texel_point.h).
struct Coverage {
  Image<int> triangle;  ///< the lowest of those that cover the centre, -1: none
  Image<int> count;     ///< how many do: 2 and more where charts overlap
};

/// One for each texture of the atlas. Charts that leave [0, 1] wrap around where the texture
/// repeats, and are cut off where it does not. Linear in the texels of the triangles' boxes.
std::vector<Coverage> texel_coverage(const Surface& surface, const Atlas& atlas,
                                     const Progress& progress = {});

/// How many texels' centres more than one triangle covers: 0 where no two charts overlap and none
/// folds over itself.
std::int64_t overlapping_texels(std::span<const Coverage> coverage);

}  // namespace mq
