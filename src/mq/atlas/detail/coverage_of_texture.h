#pragma once
/// Which triangles cover the centres of texels of one texture: no other takes memory. Used inside this room.

#include "mq/atlas/coverage.h"

namespace mq {

/// That of `texel_coverage` for this texture.
Coverage coverage_of_texture(const Surface& surface, const Atlas& atlas, int texture);

}  // namespace mq
