#include "mq/fem/detail/node_position.h"

namespace mq {

std::array<float, 3> node_position(const Texels& fine, const GridTransfer& transfer, int node,
                                   std::vector<WeightedIndex>& children) {
  children.clear();
  transfer.children(node, children);
  std::array<double, 3> sum = {0, 0, 0};
  double total = 0;
  for (const WeightedIndex& c : children) {
    if (c.weight == 1) return fine.positions[c.index];
    for (int i = 0; i < 3; ++i) sum[i] += double(c.weight) * fine.positions[c.index][i];
    total += c.weight;
  }
  return {float(sum[0] / total), float(sum[1] / total), float(sum[2] / total)};
}

}  // namespace mq
