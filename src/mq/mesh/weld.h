#pragma once
/// Which vertices of a mesh are one vertex of its surface.

#include <algorithm>
#include <numeric>
#include <vector>

#include "mq/mesh/surface.h"

namespace mq {

/// Disjoint sets of 0 to count - 1. A set's root is its lowest member, whatever the order of joins.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int root(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(int i, int j) {
    i = root(i), j = root(j);
    parent_[std::max(i, j)] = std::min(i, j);
  }

 private:
  std::vector<int> parent_;
};

/// Per vertex the lowest vertex it is joined with, itself if there is none; vertices that are not
/// `referenced` are joined with none. Closeness is not transitive but being joined is: a chain of
/// vertices, each within `distance` of the next, becomes one vertex. Expected time linear.
/// Throws `InvalidInput` on a distance that is not positive and finite.
std::vector<int> weld_vertices(const Mesh& mesh, const std::vector<char>& referenced,
                               const WeldOptions& options);

}  // namespace mq
