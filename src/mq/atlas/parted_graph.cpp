// Greedy growth and a few rounds of moves that cut fewer edges: graphs of blocks have thousands of nodes, for which
// what a multilevel partitioner would gain over this is a few per cent of the halo.

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>
#include <tuple>

#include "mq/atlas/texel_blocks.h"
#include "mq/base/error.h"

namespace mq {
namespace {

constexpr double most_weight = 1.05, as_good_as_even = 1.1;
constexpr int no_part = -1;

/// Steps from the nodes of any part, or from node `start` where there is none; nodes that are not reached are farthest.
int farthest_free_node(const WeightedGraph& graph, const std::vector<int>& part) {
  std::vector<int> steps(part.size(), -1);
  std::queue<int> waiting;
  for (int n = 0; n < graph.size(); ++n)
    if (part[std::size_t(n)] != no_part) steps[std::size_t(n)] = 0, waiting.push(n);
  int last = -1;
  const auto walk = [&] {
    while (!waiting.empty()) {
      const int n = waiting.front();
      waiting.pop();
      if (part[std::size_t(n)] == no_part && graph.weights[std::size_t(n)] > 0) last = n;
      for (const WeightedGraph::Edge& edge : graph.edges[std::size_t(n)])
        if (steps[std::size_t(edge.to)] < 0) {
          steps[std::size_t(edge.to)] = steps[std::size_t(n)] + 1;
          waiting.push(edge.to);
        }
    }
  };
  walk();
  for (int n = 0; n < graph.size(); ++n)  // another component, or the first part: from its first node to its far end
    if (steps[std::size_t(n)] < 0 && graph.weights[std::size_t(n)] > 0) {
      steps[std::size_t(n)] = 0;
      waiting.push(n);
      walk();
      return last;
    }
  return last;
}

/// Grows a part from a node until it has about `share`.
void grow(const WeightedGraph& graph, int which, double share, std::vector<int>& part) {
  double weight = 0;
  std::vector<double> pull(part.size(), 0);
  using Candidate = std::tuple<double, int>;  // pull, −node: of equals the first
  std::priority_queue<Candidate> border;
  const auto take = [&](int n) {
    part[std::size_t(n)] = which;
    weight += graph.weights[std::size_t(n)];
    for (const WeightedGraph::Edge& edge : graph.edges[std::size_t(n)]) {
      if (part[std::size_t(edge.to)] != no_part) continue;
      pull[std::size_t(edge.to)] += edge.weight;
      border.push({pull[std::size_t(edge.to)], -edge.to});
    }
  };
  while (weight < share) {
    int next = -1;
    while (!border.empty() && next < 0) {
      const auto [strength, negative] = border.top();
      border.pop();
      if (part[std::size_t(-negative)] == no_part && strength == pull[std::size_t(-negative)]) next = -negative;
    }
    if (next < 0) next = farthest_free_node(graph, part);
    if (next < 0) return;
    // The last node is left where the part would end farther from its share with it.
    if (weight > 0 && weight + graph.weights[std::size_t(next)] - share > share - weight) return;
    take(next);
  }
}

std::vector<double> part_weights(const WeightedGraph& graph, const std::vector<int>& part, int parts) {
  std::vector<double> weight(std::size_t(parts), 0);
  for (int n = 0; n < graph.size(); ++n)
    if (part[std::size_t(n)] >= 0) weight[std::size_t(part[std::size_t(n)])] += graph.weights[std::size_t(n)];
  return weight;
}

/// Moves nodes to the part they are joined to most strongly; false: none was moved.
bool refine(const WeightedGraph& graph, double share, std::vector<int>& part, std::vector<double>& weight) {
  bool moved = false;
  std::vector<double> pull(weight.size(), 0);
  for (int n = 0; n < graph.size(); ++n) {
    const int from = part[std::size_t(n)];
    const double own = graph.weights[std::size_t(n)];
    if (from < 0 || own <= 0) continue;
    std::ranges::fill(pull, 0);
    for (const WeightedGraph::Edge& edge : graph.edges[std::size_t(n)])
      if (part[std::size_t(edge.to)] >= 0) pull[std::size_t(part[std::size_t(edge.to)])] += edge.weight;
    int best = from;
    for (int p = 0; p < int(weight.size()); ++p)
      if (pull[std::size_t(p)] > pull[std::size_t(best)] && weight[std::size_t(p)] + own <= most_weight * share)
        best = p;
    if (best == from) continue;
    part[std::size_t(n)] = best;
    weight[std::size_t(from)] -= own;
    weight[std::size_t(best)] += own;
    moved = true;
  }
  return moved;
}

/// Blocks that no chart covers, which hold hardly a texel, go with one beside them.
void give_empty_blocks(const TexelBlocks& blocks, std::vector<int>& part) {
  for (int b = 0; b < blocks.count(); ++b) {
    if (part[std::size_t(b)] != no_part) continue;
    const TexelBlocks::Extent at = blocks.extent(b);
    const auto beside = [&](int x, int y) {
      const TexelBlocks::Extent last = blocks.extent(blocks.last(at.texture));
      if (x < 0 || y < 0 || x >= last.x1 || y >= last.y1) return;
      const int n = blocks.block(at.texture, x, y);
      if (blocks.graph().weights[std::size_t(n)] > 0 && part[std::size_t(b)] == no_part)
        part[std::size_t(b)] = part[std::size_t(n)];
    };
    for (const int y : {at.y0, at.y0 - 1, at.y1})
      for (const int x : {at.x0, at.x0 - 1, at.x1}) beside(x, y);
    if (part[std::size_t(b)] == no_part) part[std::size_t(b)] = 0;
  }
}

/// One node per texture.
WeightedGraph texture_graph(const TexelBlocks& blocks) {
  const WeightedGraph& fine = blocks.graph();
  WeightedGraph graph;
  const int count = blocks.count() > 0 ? blocks.texture(blocks.count() - 1) + 1 : 0;
  graph.weights.assign(std::size_t(count), 0);
  graph.edges.resize(std::size_t(count));
  for (int b = 0; b < fine.size(); ++b) {
    const int k = blocks.texture(b);
    graph.weights[std::size_t(k)] += fine.weights[std::size_t(b)];
    for (const WeightedGraph::Edge& edge : fine.edges[std::size_t(b)]) {
      const int to = blocks.texture(edge.to);
      if (to == k) continue;
      auto& edges = graph.edges[std::size_t(k)];
      const auto at = std::ranges::find(edges, to, &WeightedGraph::Edge::to);
      if (at == edges.end())
        edges.push_back({to, edge.weight});
      else
        at->weight += edge.weight;
    }
  }
  for (auto& edges : graph.edges) std::ranges::sort(edges, {}, &WeightedGraph::Edge::to);
  return graph;
}

}  // namespace

double imbalance(const WeightedGraph& graph, const std::vector<int>& part, int parts) {
  const std::vector<double> weight = part_weights(graph, part, parts);
  const double sum = std::accumulate(weight.begin(), weight.end(), 0.0);
  return sum > 0 ? *std::ranges::max_element(weight) * parts / sum : 1;
}

std::vector<int> parted(const WeightedGraph& graph, int parts) {
  require(parts >= 1, "a graph is parted into one part or more");
  std::vector<int> part(std::size_t(graph.size()), no_part);
  double left = std::accumulate(graph.weights.begin(), graph.weights.end(), 0.0);
  const double share = left / parts;
  for (int p = 0; p < parts; ++p) {
    grow(graph, p, p + 1 == parts ? left * 2 : left / (parts - p), part);
    left -= part_weights(graph, part, parts)[std::size_t(p)];
  }
  std::vector<double> weight = part_weights(graph, part, parts);
  for (int round = 0; round < 8 && refine(graph, share, part, weight);) ++round;
  return part;
}

std::vector<int> parted(const TexelBlocks& blocks, int parts) {
  const WeightedGraph textures = texture_graph(blocks);
  if (textures.size() >= parts) {
    const std::vector<int> part = parted(textures, parts);
    if (imbalance(textures, part, parts) <= as_good_as_even) {
      std::vector<int> of_block(std::size_t(blocks.count()));
      for (int b = 0; b < blocks.count(); ++b) of_block[std::size_t(b)] = part[std::size_t(blocks.texture(b))];
      return of_block;
    }
  }
  std::vector<int> part = parted(blocks.graph(), parts);
  give_empty_blocks(blocks, part);
  return part;
}

}  // namespace mq
