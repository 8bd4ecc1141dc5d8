#include "mq/views/smooth_labels.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "mq/base/error.h"

namespace mq {
namespace {

/// Nodes with two to four of five labels, and costs between 0 and 1.
LabelGraph random_nodes(int count, std::mt19937& random) {
  LabelGraph graph;
  graph.offsets = {0};
  std::uniform_real_distribution<float> cost(0, 1);
  for (int p = 0; p < count; ++p) {
    const int first = int(random() % 2), number = 2 + int(random() % 3);
    for (int l = 0; l < number; ++l) graph.labels.push_back(first + l), graph.costs.push_back(cost(random));
    graph.offsets.push_back(std::ssize(graph.labels));
  }
  return graph;
}

/// The least energy of all choices.
double least_energy(const LabelGraph& graph) {
  std::vector<int> chosen(std::size_t(graph.nodes()), 0);
  double least = std::numeric_limits<double>::infinity();
  for (;;) {
    least = std::min(least, label_energy(graph, chosen));
    int p = 0;
    while (p < graph.nodes() && ++chosen[std::size_t(p)] == graph.offsets[p + 1] - graph.offsets[p])
      chosen[std::size_t(p++)] = 0;
    if (p == graph.nodes()) return least;
  }
}

TEST(SmoothLabels, TreesAreSolvedExactly) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> weight(0, 0.6F);
  for (int trial = 0; trial < 30; ++trial) {
    LabelGraph graph = random_nodes(8, random);
    for (int p = 1; p < 8; ++p) graph.edges.push_back({int(random() % unsigned(p)), p, weight(random)});
    EXPECT_NEAR(label_energy(graph, smooth_labels(graph)), least_energy(graph), 1e-5) << trial;
  }
}

/// Borders that cost more at some labels than at others.
TEST(SmoothLabels, TreesAreSolvedExactlyWhateverBordersCost) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> weight(0, 0.3F), border(0, 3);
  int moved = 0;
  for (int trial = 0; trial < 30; ++trial) {
    LabelGraph graph = random_nodes(8, random);
    for (int p = 1; p < 8; ++p) graph.edges.push_back({int(random() % unsigned(p)), p, weight(random)});
    const std::vector<int> before = smooth_labels(graph);
    for (std::size_t l = 0; l < graph.labels.size(); ++l) graph.borders.push_back(border(random));
    const std::vector<int> found = smooth_labels(graph);
    EXPECT_NEAR(label_energy(graph, found), least_energy(graph), 1e-5) << trial;
    moved += found != before;
  }
  EXPECT_GT(moved, 5);
}

TEST(SmoothLabels, GridsComeNearTheLeast) {
  std::mt19937 random(3);
  double found = 0, least = 0;
  for (int trial = 0; trial < 20; ++trial) {
    LabelGraph graph = random_nodes(9, random);
    for (int p = 0; p < 9; ++p) {
      if (p % 3 < 2) graph.edges.push_back({p, p + 1, 0.3F});
      if (p < 6) graph.edges.push_back({p, p + 3, 0.3F});
    }
    const double own = label_energy(graph, smooth_labels(graph)), best = least_energy(graph);
    EXPECT_GE(own, best - 1e-5);
    found += own, least += best;
  }
  EXPECT_LE(found, 1.01 * least);
}

TEST(SmoothLabels, NodesWithoutLabelsAreLeftOut) {
  LabelGraph graph;
  graph.offsets = {0, 2, 2, 4};
  graph.labels = {0, 1, 0, 1};
  graph.costs = {0, 1, 1, 0.9F};
  graph.edges = {{0, 1, 5}, {1, 2, 5}};
  EXPECT_EQ(smooth_labels(graph), (std::vector<int>{0, -1, 1}));
}

TEST(SmoothLabels, WhatIsNoGraphIsRefused) {
  LabelGraph graph;
  graph.offsets = {0, 2};
  graph.labels = {1, 0};
  graph.costs = {0, 0};
  EXPECT_THROW(smooth_labels(graph), InvalidInput);
  graph.labels = {0, 1};
  graph.edges = {{0, 3, 1}};
  EXPECT_THROW(smooth_labels(graph), InvalidInput);
  graph.edges = {{0, 0, 1}};
  EXPECT_THROW(smooth_labels(graph), InvalidInput);
  graph.edges.clear();
  graph.borders = {0, -1};
  EXPECT_THROW(smooth_labels(graph), InvalidInput);
  graph.borders = {0};
  EXPECT_THROW(smooth_labels(graph), InvalidInput);
}

}  // namespace
}  // namespace mq
