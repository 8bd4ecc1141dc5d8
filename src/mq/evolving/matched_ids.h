#pragma once
/// Ids of vertices and triangles for segments that come without, as those of other programs' files do.

#include <vector>

#include "mq/evolving/evolving_mesh.h"

namespace mq {

/// Gives every segment ids. A triangle has that of one of the segment before where all three of its texture
/// coordinates are equal to the bit, as they are while a chart lives, no other triangle of either has them, and
/// its vertices have no other ids yet. Its corners then begin with the same one. Whatever is left has ids of its
/// own. Without texture coordinates nothing lives on. O(n log n).
void match_ids(std::vector<EvolvingSegment>& segments);

}  // namespace mq
