#pragma once
/// The textures of an atlas in square blocks of texels, and how blocks hang together on the surface: what is
/// handed out where several processes share the work on a model.

#include <array>
#include <vector>

#include "mq/atlas/seams.h"

namespace mq {

/// Nodes with weights, joined by edges with weights.
struct WeightedGraph {
  struct Edge {
    int to = 0;
    double weight = 0;
  };
  std::vector<double> weights;           ///< per node, 0 or more
  std::vector<std::vector<Edge>> edges;  ///< per node, both ways, `to` increasing

  int size() const { return int(weights.size()); }
};

class TexelBlocks {
 public:
  /// Blocks of `side`² texels, the last of a row or column perhaps smaller. Linear in the triangles and in the
  /// blocks that they cross. Throws `InvalidInput` where the side is below 8, narrower than what couples across
  /// a texel line.
  TexelBlocks(const Surface& surface, const Atlas& atlas, const Seams& seams, int side);

  int side() const { return side_; }
  int count() const { return first_.back(); }

  /// The block of a texel of a texture.
  int block(int texture, int x, int y) const {
    return first_[std::size_t(texture)] + y / side_ * columns_[std::size_t(texture)] + x / side_;
  }
  int texture(int block) const;
  /// Of a texture, the block in its far corner.
  int last(int texture) const { return first_[std::size_t(texture) + 1] - 1; }

  /// The texels of a block: columns and rows, the ends one past the last.
  struct Extent {
    int texture = 0, x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  };
  Extent extent(int block) const;

  /// A node for each block. Its weight is how many texels charts cover in it; that of an edge is how many
  /// couple over it, inside a texture or across seams.
  const WeightedGraph& graph() const { return graph_; }

 private:
  void join_beside();
  void join_across(const Seams& seams);
  void join(int a, int b, double weight);

  void weigh(const Surface& surface, const Atlas& atlas);

  std::vector<TextureSize> textures_;
  int side_ = 0;
  std::vector<int> columns_, first_;  ///< per texture
  WeightedGraph graph_;
};

/// Which part each node is of, `parts` of about equal weight: parts grow one after another from the node farthest
/// from all before, always by the node that is joined to them most strongly, until they have their share of what is
/// left; then nodes at borders change to where fewer edges are cut, while no part gets heavier than 1.05 of its
/// share. Nodes without weight are of none, −1. The same for equal input. O(nodes · log).
std::vector<int> parted(const WeightedGraph& graph, int parts);

/// The heaviest part over the mean.
double imbalance(const WeightedGraph& graph, const std::vector<int>& part, int parts);

/// Which part each block is of, those without a chart too: whole textures go to parts where these then weigh about the
/// same (to a tenth), so that few pictures are wanted in several places; blocks do elsewhere.
std::vector<int> parted(const TexelBlocks& blocks, int parts);

/// A side of blocks for that many parts: a power of two from 16 to 512 that gives each about 64 blocks or more.
int block_side(const Atlas& atlas, int parts);

}  // namespace mq
