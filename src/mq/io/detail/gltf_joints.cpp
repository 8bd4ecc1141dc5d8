// A border is made of the edges that one triangle of a primitive has, its vertices at equal positions
// being one. Vertices lie in a hash of cells as large as the largest tolerance: the nearest is in a
// vertex's own cell or in one beside it.
#include "mq/io/detail/gltf_joints.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>
#include <unordered_map>

namespace mq {
namespace {

/// Beyond the roundings themselves: floats of the decoder.
constexpr double joint_slack = 1 + 1e-3;

class GridJoiner {
 public:
  GridJoiner(GltfScene& scene, const GltfFile& file) : scene_(scene), mesh_(scene.file.mesh) {
    for (const GltfBlock& block : scene.blocks) {
      const double scale = block.matrix.topLeftCorner<3, 3>().colwise().norm().maxCoeff();
      reach_.push_back(0.5 * std::sqrt(3.0) * scale * file.step(block.positions) * joint_slack);
    }
    const double largest = reach_.empty() ? 0 : *std::ranges::max_element(reach_);
    cell_ = 2 * largest;
  }

  GltfJoints join() {
    if (scene_.blocks.size() < 2 || !(cell_ > 0)) return {};
    find_borders();
    for (std::size_t b = 0; b < scene_.blocks.size(); ++b) join_block(b);
    return joints_;
  }

 private:
  using Cell = std::array<std::int64_t, 3>;
  struct CellHash {
    std::size_t operator()(const Cell& c) const {
      std::uint64_t hash = 0;
      for (const std::int64_t k : c) hash = (hash ^ std::uint64_t(k)) * 0x9E3779B97F4A7C15;
      return hash ^ (hash >> 32);
    }
  };
  /// A vertex at the border of a block; `taken` by the last block that has joined it.
  struct BorderVertex {
    Vector3 position;
    std::size_t block;
    std::size_t taken;
  };

  /// Per vertex the first of its block at its position.
  void weld_blocks() {
    first_.resize(mesh_.positions.size());
    std::iota(first_.begin(), first_.end(), 0);
    const auto less = [&](int a, int b) {
      const Vector3 &p = mesh_.positions[std::size_t(a)], &q = mesh_.positions[std::size_t(b)];
      return std::tie(p.x(), p.y(), p.z(), a) < std::tie(q.x(), q.y(), q.z(), b);
    };
    for (const GltfBlock& block : scene_.blocks) {
      std::vector<int> order(std::size_t(block.count));
      std::iota(order.begin(), order.end(), block.begin);
      std::ranges::sort(order, less);
      for (std::size_t i = 1; i < order.size(); ++i)
        if (mesh_.positions[std::size_t(order[i])] == mesh_.positions[std::size_t(order[i - 1])])
          first_[std::size_t(order[i])] = first_[std::size_t(order[i - 1])];
    }
  }

  void find_borders() {
    weld_blocks();
    std::vector<std::array<int, 2>> edges;
    for (const Triangle& t : mesh_.triangles)
      for (std::size_t k = 0; k < 3; ++k) {
        const int a = first_[std::size_t(t[k])], b = first_[std::size_t(t[(k + 1) % 3])];
        if (a != b) edges.push_back({std::min(a, b), std::max(a, b)});
      }
    std::ranges::sort(edges);
    at_border_.resize(mesh_.positions.size());
    for (std::size_t i = 0; i < edges.size(); ++i) {
      const bool alone = (i == 0 || edges[i - 1] != edges[i]) &&
                         (i + 1 == edges.size() || edges[i + 1] != edges[i]);
      if (alone)
        for (const int v : edges[i]) at_border_[std::size_t(v)] = 1;
    }
  }

  Cell cell_of(const Vector3& p) const {
    Cell cell;
    for (int k = 0; k < 3; ++k)
      cell[std::size_t(k)] = std::int64_t(std::clamp(std::floor(p[k] / cell_), -1e18, 1e18));
    return cell;
  }

  /// The nearest vertex within reach that this block has not taken; null: none.
  BorderVertex* nearest(const Vector3& p, std::size_t block) {
    const Cell middle = cell_of(p);
    BorderVertex* best = nullptr;
    double distance = 0;
    for (int i = 0; i < 27; ++i) {
      const auto found =
          cells_.find({middle[0] + i % 3 - 1, middle[1] + i / 3 % 3 - 1, middle[2] + i / 9 - 1});
      if (found == cells_.end()) continue;
      for (const std::size_t id : found->second) {
        BorderVertex& there = vertices_[id];
        const double d = (there.position - p).norm();
        if (there.taken == block || d > reach_[block] + reach_[there.block]) continue;
        if (!best || d < distance) best = &there, distance = d;
      }
    }
    return best;
  }

  void join_block(std::size_t b) {
    const GltfBlock& block = scene_.blocks[b];
    std::vector<std::size_t> added;
    for (int v = block.begin; v < block.begin + block.count; ++v) {
      if (!at_border_[std::size_t(v)] || first_[std::size_t(v)] != v) continue;
      const Vector3 p = mesh_.positions[std::size_t(v)];
      if (BorderVertex* there = nearest(p, b)) {
        there->taken = b;
        if (there->position != p) move(v, there->position);
      } else {
        added.push_back(vertices_.size());
        vertices_.push_back({p, b, b});
      }
    }
    for (int v = block.begin; v < block.begin + block.count; ++v)  // others at the same position follow
      mesh_.positions[std::size_t(v)] = mesh_.positions[std::size_t(first_[std::size_t(v)])];
    for (const std::size_t id : added) cells_[cell_of(vertices_[id].position)].push_back(id);
  }

  void move(int vertex, const Vector3& to) {
    Vector3& from = mesh_.positions[std::size_t(vertex)];
    joints_.farthest = std::max(joints_.farthest, (to - from).norm());
    ++joints_.moved;
    from = to;
  }

  GltfScene& scene_;
  Mesh& mesh_;
  std::vector<double> reach_;  ///< per block: how far rounding can have moved a vertex
  double cell_ = 0;
  std::vector<int> first_;
  std::vector<char> at_border_;
  std::vector<BorderVertex> vertices_;
  std::unordered_map<Cell, std::vector<std::size_t>, CellHash> cells_;
  GltfJoints joints_;
};

}  // namespace

GltfJoints join_grids(GltfScene& scene, const GltfFile& file) {
  return GridJoiner(scene, file).join();
}

}  // namespace mq
