// Blocks of texels, and how they are handed out to parts.
#include <gtest/gtest.h>

#include <numeric>
#include <set>

#include "fixtures.h"
#include "mq/atlas/texel_blocks.h"

namespace mq {
namespace {

/// A square of nodes of weight 1, each joined to those beside it.
WeightedGraph square_graph(int side) {
  WeightedGraph graph;
  graph.weights.assign(std::size_t(side * side), 1);
  graph.edges.resize(graph.weights.size());
  for (int n = 0; n < side * side; ++n)
    for (const int to : {n - side, n - 1, n + 1, n + side})
      if (to >= 0 && to < side * side && (to / side == n / side || to % side == n % side))
        graph.edges[std::size_t(n)].push_back({to, 1});
  return graph;
}

double cut_edges(const WeightedGraph& graph, const std::vector<int>& part) {
  double cut = 0;
  for (int n = 0; n < graph.size(); ++n)
    for (const auto& edge : graph.edges[std::size_t(n)])
      if (part[std::size_t(n)] != part[std::size_t(edge.to)]) cut += edge.weight / 2;
  return cut;
}

TEST(PartedGraph, WeighsAboutTheSameEverywhere) {
  const WeightedGraph graph = square_graph(24);
  for (const int parts : {1, 2, 3, 4, 7, 16}) {
    const std::vector<int> part = parted(graph, parts);
    EXPECT_EQ(std::set<int>(part.begin(), part.end()).size(), std::size_t(parts));
    EXPECT_LT(imbalance(graph, part, parts), 1.2) << parts << " parts";
  }
}

TEST(PartedGraph, CutsFewEdges) {
  const WeightedGraph graph = square_graph(24);
  EXPECT_LT(cut_edges(graph, parted(graph, 4)), 2.5 * 48);  // 48 by four squares
}

TEST(PartedGraph, OfMoreComponentsThanPartsIsComplete) {
  WeightedGraph graph;
  graph.weights.assign(10, 1);
  graph.edges.resize(10);
  const std::vector<int> part = parted(graph, 3);
  for (const int p : part) EXPECT_GE(p, 0);
  EXPECT_LE(imbalance(graph, part, 3), 1.3);
}

TEST(TexelBlocks, WeighWhatChartsCover) {
  const Surface surface = make_surface(fixtures::two_chart_quad());
  const Atlas atlas = make_atlas(surface, {{100, 60}});
  const Seams seams(surface, atlas);
  const TexelBlocks blocks(surface, atlas, seams, 16);
  EXPECT_EQ(blocks.count(), 7 * 4);
  const auto& weights = blocks.graph().weights;
  EXPECT_NEAR(std::accumulate(weights.begin(), weights.end(), 0.0), atlas.texel_area, 1e-6 * atlas.texel_area);
  for (int b = 0; b < blocks.count(); ++b) {
    const auto at = blocks.extent(b);
    EXPECT_EQ(blocks.block(at.texture, at.x0, at.y0), b);
    EXPECT_EQ(blocks.block(at.texture, at.x1 - 1, at.y1 - 1), b);
    EXPECT_EQ(blocks.texture(b), 0);
    EXPECT_LE(weights[std::size_t(b)], double(at.x1 - at.x0) * (at.y1 - at.y0) + 1e-6);
  }
}

TEST(TexelBlocks, AreJoinedAcrossSeams) {
  const Surface surface = make_surface(fixtures::two_chart_quad());
  const Atlas atlas = make_atlas(surface, {{128, 128}});
  const Seams seams(surface, atlas);
  ASSERT_EQ(seams.count(), 1);
  const TexelBlocks blocks(surface, atlas, seams, 16);
  const auto block_at = [&](int side) {
    const TexturePlace p = seams.place(seams.half_edges(0)[std::size_t(side)], 0.5);
    return blocks.block(p.texture, p.column, p.row);
  };
  const int a = block_at(0), b = block_at(1);
  ASSERT_NE(a, b);
  bool joined = false;
  for (const auto& edge : blocks.graph().edges[std::size_t(a)]) joined |= edge.to == b;
  EXPECT_TRUE(joined);
}

TEST(TexelBlocks, AreAllHandedOut) {
  const Surface surface = make_surface(fixtures::two_chart_quad());
  const Atlas atlas = make_atlas(surface, {{128, 128}});
  const TexelBlocks blocks(surface, atlas, Seams(surface, atlas), block_side(atlas, 3));
  const std::vector<int> part = parted(blocks, 3);
  for (const int p : part) {
    EXPECT_GE(p, 0);
    EXPECT_LT(p, 3);
  }
  EXPECT_LT(imbalance(blocks.graph(), part, 3), 1.25);
}

}  // namespace
}  // namespace mq
