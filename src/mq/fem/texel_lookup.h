#pragma once
/// From a texel of a picture to its unknown.

#include <algorithm>
#include <array>

#include "mq/fem/texels.h"

namespace mq {

/// The unknown of a texel, the first where several are there; −1: none is. In logarithmic time.
inline int unknown_of(const Texels& texels, const Texels::Place& at) {
  const auto key = [](const Texels::Place& p) { return std::array{p.texture, p.y, p.x}; };
  const auto found = std::ranges::lower_bound(texels.places, key(at), {}, key);
  return found != texels.places.end() && key(*found) == key(at) ? int(found - texels.places.begin())
                                                                 : -1;
}

}  // namespace mq
