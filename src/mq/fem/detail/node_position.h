#pragma once
/// Where the nodes of a coarse grid lie.

#include <array>
#include <vector>

#include "mq/fem/texels.h"
#include "mq/linear/transfer.h"

namespace mq {

/// The place of a node: that of its own texel, or the mean of those it serves. `children` is
/// working space.
std::array<float, 3> node_position(const Texels& fine, const GridTransfer& transfer, int node,
                                   std::vector<WeightedIndex>& children);

}  // namespace mq
