#pragma once
/// Whether pictures are those an atlas was made for. Used inside this room.

#include <vector>

#include "mq/atlas/atlas.h"
#include "mq/image/image.h"

namespace mq {

/// Throws `InvalidInput` unless there is one picture per texture of the atlas, of its size.
void check_textures(const Atlas& atlas, const std::vector<const Image<float>*>& textures);

}  // namespace mq
