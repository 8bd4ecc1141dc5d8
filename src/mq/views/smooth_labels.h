#pragma once
/// A label for each node of a graph, such that what each costs and where neighbours differ is little:
///
///     E(l) = Σ_p D_p(l_p) + Σ_{p,q} w_pq [l_p ≠ l_q] (1 + b_p(l_p) + b_q(l_q)),
///
/// b telling where a border is seen more, and each node having a list of labels of its own. Exact for trees, else near the least, by sequential
/// tree-reweighted message passing ([kolmogorov2006convergent]), then single labels changed as long as that lowers E.

#include <span>
#include <vector>

#include "mq/base/progress.h"

namespace mq {

struct LabelGraph {
  std::vector<std::int64_t> offsets;  ///< per node its candidates: [offsets[p], offsets[p + 1])
  std::vector<int> labels;            ///< increasing within a node
  std::vector<float> costs;           ///< D of each, finite
  std::vector<float> borders = {};    ///< b of each, not negative; empty: 0

  struct Edge {
    int a, b;      ///< a < b
    float weight;  ///< not negative
  };
  std::vector<Edge> edges;

  int nodes() const { return int(offsets.size()) - 1; }
};

/// Per node the number of its candidate, counted from 0 within the node; −1 where it has none. The same
/// for any number of threads. Throws `InvalidInput` for a graph as it must not be.
std::vector<int> smooth_labels(const LabelGraph& graph, int rounds = 30, const Progress& progress = {});

/// E of these candidates; an edge to a node without candidates costs nothing.
double label_energy(const LabelGraph& graph, std::span<const int> chosen);

}  // namespace mq
