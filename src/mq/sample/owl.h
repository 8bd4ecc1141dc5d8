#pragma once
/// The bust that most samples show: an owl on a round plinth, as a solid and as colours in space.

#include "mq/sample/implicit.h"
#include "mq/sample/paint.h"

namespace mq {

/// Inside [-1, 1]³, y up, facing +z.
double owl_solid(const Vector3& p);

ColorField owl_colors(std::uint64_t seed);

}  // namespace mq
