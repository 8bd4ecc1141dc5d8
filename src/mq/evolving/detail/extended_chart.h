#pragma once
/// A patch laid beside what is there of a chart, where only a part of its boundary is given.

#include <optional>
#include <vector>

#include "mq/evolving/detail/filled_hole.h"

namespace mq {

struct ExtendedChart {
  std::vector<Vector2> places;  ///< per vertex of the patch
  std::vector<char> sound;      ///< per triangle 1 where it is not turned over, nor distorted by two
};

/// Places of all vertices of a connected patch: those that are fixed where they are, the others as rigid as
/// possible ([liu2008local]) from the least squares conformal map ([levy2002least]). So what lies flat beside
/// its fixed boundary is laid as it is in space. None with fewer than two fixed vertices.
std::optional<ExtendedChart> extended_chart(const HolePatch& patch);

}  // namespace mq
