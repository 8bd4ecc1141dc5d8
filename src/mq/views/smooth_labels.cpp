// Messages M_pq(l), one for each direction of an edge, over the candidates of the node they go to. In a
// pass over the nodes in their order, and then back, node p with
//
//     θ_p(l) = D_p(l) + Σ_q M_qp(l),    γ_p = 1 / max(edges to earlier nodes, edges to later ones),
//
// sends to those that come after it M_pq(m) = min_l (γ_p θ_p(l) − M_qp(l) + w [l ≠ m] (1 + b_p(l) + b_q(m))), less its
// minimum. This is the cheaper of staying with m, where p has it, and the cheapest of all, each plus w b_p(l), plus
// w (1 + b_q(m)).

#include "mq/views/smooth_labels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mq/base/error.h"

namespace mq {
namespace {

constexpr float infinite = std::numeric_limits<float>::infinity();

class MessagePassing {
 public:
  explicit MessagePassing(const LabelGraph& graph)
      : graph_(graph), borders_(graph.borders), offsets_(graph.nodes() + 1, 0) {
    borders_.resize(graph.costs.size(), 0.0F);
    std::int64_t sizes = 0;
    for (const LabelGraph::Edge& edge : graph.edges) ++offsets_[edge.a + 1], ++offsets_[edge.b + 1];
    for (int p = 0; p < graph.nodes(); ++p) offsets_[p + 1] += offsets_[p];
    half_edges_.resize(offsets_.back());
    std::vector<std::int64_t> next(offsets_.begin(), offsets_.end() - 1);
    for (const LabelGraph::Edge& edge : graph.edges) {
      const std::int64_t to_b = sizes, to_a = sizes + candidates(edge.b);
      sizes = to_a + candidates(edge.a);
      half_edges_[next[edge.a]++] = {edge.b, edge.weight, to_b, to_a};
      half_edges_[next[edge.b]++] = {edge.a, edge.weight, to_a, to_b};
    }
    messages_.assign(sizes, 0.0F);
    for (int p = 0; p < graph.nodes(); ++p) {
      int later = 0;
      for (const HalfEdge& edge : edges_of(p)) later += edge.node > p;
      const int all = int(edges_of(p).size());
      shares_.push_back(1.0F / float(std::max({later, all - later, 1})));
    }
  }

  void pass(bool forward) {
    const int n = graph_.nodes();
    for (int k = 0; k < n; ++k) {
      const int p = forward ? k : n - 1 - k;
      gather(p);
      for (const HalfEdge& edge : edges_of(p))
        if ((edge.node > p) == forward) send(p, edge);
    }
  }

  /// In the order of the nodes, each given the labels that earlier ones have taken.
  std::vector<int> choose() {
    std::vector<int> chosen(graph_.nodes(), -1);
    for (int p = 0; p < graph_.nodes(); ++p) {
      sums_.assign(graph_.costs.begin() + graph_.offsets[p], graph_.costs.begin() + graph_.offsets[p + 1]);
      for (const HalfEdge& edge : edges_of(p)) {
        if (edge.node > p)
          for (std::size_t l = 0; l < sums_.size(); ++l) sums_[l] += messages_[edge.in + std::int64_t(l)];
        else
          add_difference(p, edge, chosen[edge.node]);
      }
      chosen[p] = least();
    }
    return chosen;
  }

  /// Changes one label after another while any lowers E.
  void improve(std::vector<int>& chosen) {
    constexpr int most = 10;
    bool changed = true;
    for (int round = 0; round < most && changed; ++round) {
      changed = false;
      for (int p = 0; p < graph_.nodes(); ++p) {
        if (chosen[p] < 0) continue;
        sums_.assign(graph_.costs.begin() + graph_.offsets[p], graph_.costs.begin() + graph_.offsets[p + 1]);
        for (const HalfEdge& edge : edges_of(p)) add_difference(p, edge, chosen[edge.node]);
        const int best = least();
        if (!(sums_[best] < sums_[chosen[p]])) continue;
        chosen[p] = best;
        changed = true;
      }
    }
  }

 private:
  struct HalfEdge {
    int node;  ///< at the other end
    float weight;
    std::int64_t out, in;  ///< messages to it and from it
  };

  std::int64_t candidates(int p) const { return graph_.offsets[p + 1] - graph_.offsets[p]; }
  std::span<const int> labels_of(int p) const {
    return {graph_.labels.data() + graph_.offsets[p], std::size_t(candidates(p))};
  }
  const float* borders_of(int p) const { return borders_.data() + graph_.offsets[p]; }
  std::span<const HalfEdge> edges_of(int p) const {
    return {half_edges_.data() + offsets_[p], std::size_t(offsets_[p + 1] - offsets_[p])};
  }

  void gather(int p) {
    sums_.assign(graph_.costs.begin() + graph_.offsets[p], graph_.costs.begin() + graph_.offsets[p + 1]);
    for (const HalfEdge& edge : edges_of(p))
      for (std::size_t l = 0; l < sums_.size(); ++l) sums_[l] += messages_[edge.in + std::int64_t(l)];
    for (float& sum : sums_) sum *= shares_[p];
  }

  void send(int p, const HalfEdge& edge) {
    const std::span<const int> own = labels_of(p), theirs = labels_of(edge.node);
    if (own.empty() || theirs.empty()) return;
    float cheapest = infinite;
    const float* const own_borders = borders_of(p);
    const float* const their_borders = borders_of(edge.node);
    for (std::size_t l = 0; l < own.size(); ++l)
      cheapest = std::min(cheapest, sums_[l] - messages_[edge.in + std::int64_t(l)] + edge.weight * own_borders[l]);
    std::size_t l = 0;
    float least = infinite;
    for (std::size_t m = 0; m < theirs.size(); ++m) {
      while (l < own.size() && own[l] < theirs[m]) ++l;
      float value = cheapest + edge.weight * (1 + their_borders[m]);
      if (l < own.size() && own[l] == theirs[m])
        value = std::min(value, sums_[l] - messages_[edge.in + std::int64_t(l)]);
      messages_[edge.out + std::int64_t(m)] = value;
      least = std::min(least, value);
    }
    for (std::size_t m = 0; m < theirs.size(); ++m) messages_[edge.out + std::int64_t(m)] -= least;
  }

  void add_difference(int p, const HalfEdge& edge, int chosen) {
    if (chosen < 0) return;
    const int label = labels_of(edge.node)[std::size_t(chosen)];
    const float border = 1 + borders_of(edge.node)[chosen];
    for (std::size_t l = 0; l < sums_.size(); ++l)
      if (labels_of(p)[l] != label) sums_[l] += edge.weight * (border + borders_of(p)[l]);
  }

  int least() const { return sums_.empty() ? -1 : int(std::ranges::min_element(sums_) - sums_.begin()); }

  const LabelGraph& graph_;
  std::vector<float> borders_;
  std::vector<std::int64_t> offsets_;  ///< per node its half-edges
  std::vector<HalfEdge> half_edges_;
  std::vector<float> messages_, shares_;
  std::vector<float> sums_;  ///< of the node that is looked at
};

void require_graph(const LabelGraph& graph) {
  require(!graph.offsets.empty() && graph.offsets.front() == 0 && std::ranges::is_sorted(graph.offsets) &&
              graph.offsets.back() == std::ssize(graph.labels) && graph.labels.size() == graph.costs.size(),
          "a graph of labels needs an offset per node, and a cost per label");
  for (int p = 0; p < graph.nodes(); ++p)
    for (std::int64_t k = graph.offsets[p] + 1; k < graph.offsets[p + 1]; ++k)
      require(graph.labels[k - 1] < graph.labels[k], "the labels of a node must increase");
  for (const float cost : graph.costs) require(std::isfinite(cost), "costs of labels must be finite");
  require(graph.borders.empty() || graph.borders.size() == graph.labels.size(),
          "what borders cost is wanted of each label or of none");
  for (const float border : graph.borders)
    require(border >= 0 && std::isfinite(border), "what borders cost must be finite and not negative");
  for (const LabelGraph::Edge& edge : graph.edges)
    require(edge.a >= 0 && edge.a < edge.b && edge.b < graph.nodes() && edge.weight >= 0 &&
                std::isfinite(edge.weight),
            "an edge goes from a node to one of a higher number, with a weight that is not negative");
}

}  // namespace

std::vector<int> smooth_labels(const LabelGraph& graph, int rounds, const Progress& progress) {
  require_graph(graph);
  MessagePassing passing(graph);
  std::vector<int> best = passing.choose();
  double least = label_energy(graph, best);
  for (int round = 0; round < rounds; ++round) {
    passing.pass(true);
    passing.pass(false);
    std::vector<int> chosen = passing.choose();
    passing.improve(chosen);
    const double energy = label_energy(graph, chosen);
    if (energy < least) least = energy, best = std::move(chosen);
    progress.at(double(round + 1) / rounds);
  }
  return best;
}

double label_energy(const LabelGraph& graph, std::span<const int> chosen) {
  double energy = 0;
  for (int p = 0; p < graph.nodes(); ++p)
    if (chosen[p] >= 0) energy += graph.costs[graph.offsets[p] + chosen[p]];
  for (const LabelGraph::Edge& edge : graph.edges) {
    if (chosen[edge.a] < 0 || chosen[edge.b] < 0) continue;
    const auto a = std::size_t(graph.offsets[edge.a] + chosen[edge.a]);
    const auto b = std::size_t(graph.offsets[edge.b] + chosen[edge.b]);
    if (graph.labels[a] == graph.labels[b]) continue;
    energy += edge.weight * (graph.borders.empty() ? 1.0 : 1.0 + graph.borders[a] + graph.borders[b]);
  }
  return energy;
}

}  // namespace mq
