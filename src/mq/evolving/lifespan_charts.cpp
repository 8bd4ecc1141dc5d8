// Areas, perimeters and common lengths are kept as sums over the periods before each, which charts
// share with what they were made of: a split changes two indices. With them
//
//   ‖C_j ∪ C_k‖_S = ‖C_j‖_S + ‖C_k‖_S − 2 s_jk   over the periods in common
//
// and the change of energy by any edit is known from a few differences.

#include "mq/evolving/lifespan_charts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <queue>
#include <unordered_map>

namespace mq {
namespace {

/// Caps, in mean areas of a frame, below which no chart is taken to be: triangles without area.
constexpr double least_cap = 0x1p-30;

/// Energies are multiples of its inverse; larger ones count as the largest.
constexpr double energy_unit = 0x1p24, most_energy = 0x1p30;

/// Something per period, as sums over the periods before.
class Series {
 public:
  Series() = default;
  Series(int first, const std::vector<std::int64_t>& values) : first_(first) {
    auto sums = std::make_shared<std::vector<std::int64_t>>(values.size() + 1);
    std::partial_sum(values.begin(), values.end(), sums->begin() + 1);
    sums_ = std::move(sums);
  }

  bool empty() const { return !sums_; }

  /// From period a to period b, both included; 0 outside of what it knows.
  std::int64_t sum(int a, int b) const {
    if (!sums_) return 0;
    const int count = int(sums_->size()) - 1;
    const int from = std::clamp(a - first_, 0, count), to = std::clamp(b + 1 - first_, 0, count);
    return to > from ? (*sums_)[to] - (*sums_)[from] : 0;
  }

 private:
  int first_ = 0;
  std::shared_ptr<const std::vector<std::int64_t>> sums_;
};

/// one + factor · other over the periods from a to b.
Series sum(const Series& one, const Series& other, int factor, int a, int b) {
  if (other.empty()) return one;
  if (one.empty() && factor == 1) return other;
  std::vector<std::int64_t> values(b - a + 1);
  for (int i = a; i <= b; ++i) values[i - a] = one.sum(i, i) + factor * other.sum(i, i);
  return {a, values};
}

/// Energy of a chart as said in the header.
class Energy {
 public:
  Energy(const NeighbourGraph& graph, double beta, int frames)
      : weight_(beta * graph.radius /
                (frames > 0
                     ? double(frames)
                     : std::accumulate(graph.frame_counts.begin(), graph.frame_counts.end(), 0.0))),
        frames_(0,
                std::vector<std::int64_t>(graph.frame_counts.begin(), graph.frame_counts.end())) {}

  /// Area and perimeter summed over all frames of the periods from `first` to `last`.
  std::int64_t operator()(std::int64_t area, std::int64_t side, int first, int last) const {
    return of_cap(cap(area, first, last), side);
  }

  /// Twice the mean area.
  double cap(std::int64_t area, int first, int last) const {
    return 2 * double(area) * 0x1p-40 / double(frames_.sum(first, last));
  }

  std::int64_t of_cap(double cap, std::int64_t side) const {
    cap = std::max(cap, least_cap);
    const double energy = cap + weight_ * (double(side) * 0x1p-40) / cap;
    return std::int64_t(std::nearbyint(std::min(energy, most_energy) * energy_unit));
  }

 private:
  double weight_;
  Series frames_;
};

struct Prism {
  int first = 0, last = 0;
  Series area, side;
  std::map<int, Series> neighbours;  // length in common; only those with some
  int members = 0;                   // a node of the tree of unions
  int goes_on = -1;                  // the chart of the past that it is a part of
  bool is_alive = true;
  std::int64_t energy = 0;
};

/// Groups of chains in contact with equal lives, of one chart of the past, which they may have joined when it
/// was over: each one's lowest chain.
std::vector<int> equal_lives(const NeighbourGraph& graph, const std::vector<int>& chart_of) {
  std::vector<int> parent(graph.chains.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int c) {
    while (parent[c] != c) c = parent[c] = parent[parent[c]];
    return c;
  };
  for (const NeighbourGraph::Contact& contact : graph.contacts) {
    const auto& one = graph.chains[contact.one];
    const auto& other = graph.chains[contact.other];
    if (one.last() != other.last()) continue;
    if (!chart_of.empty() && chart_of[contact.one] != chart_of[contact.other]) continue;
    if (one.first != other.first && (chart_of.empty() || chart_of[contact.one] < 0)) continue;
    const int a = root(contact.one), b = root(contact.other);
    parent[std::max(a, b)] = std::min(a, b);
  }
  for (std::size_t c = 0; c < parent.size(); ++c) parent[c] = root(int(c));
  return parent;
}

/// Sums over the chains of a chart: per period of its life its area, and its perimeter.
struct Sums {
  std::vector<std::int64_t> area, side;
};

void add(const std::vector<std::int64_t>& values, int from, int first, int last, int factor,
         std::vector<std::int64_t>& sums) {
  for (int i = first; i <= last; ++i)
    if (i >= from && i - from < int(values.size())) sums[i - first] += factor * values[i - from];
}

class Charting {
 public:
  Charting(const NeighbourGraph& graph, const ChartingOptions& options)
      : energy_of_(graph, options.beta, options.frames), past_(options.past) {
    const std::vector<int> group = equal_lives(graph, options.chart_of);
    std::vector<int> chart(graph.chains.size()), begin(graph.chains.size(), std::numeric_limits<int>::max());
    std::vector<Sums> sums;
    for (int c = 0; c < int(group.size()); ++c)
      begin[group[c]] = std::min(begin[group[c]], graph.chains[c].first);
    for (int c = 0; c < int(group.size()); ++c) {
      const NeighbourGraph::Chain& chain = graph.chains[c];
      if (group[c] == c) {
        chart[c] = int(charts_.size());
        charts_.emplace_back();
        charts_.back().first = begin[c];
        charts_.back().last = chain.last();
        charts_.back().members = chart[c];
        if (!options.chart_of.empty()) charts_.back().goes_on = options.chart_of[c];
        leaves_.emplace_back();
        const auto periods = std::size_t(chain.last() - begin[c] + 1);
        sums.push_back({std::vector<std::int64_t>(periods), std::vector<std::int64_t>(periods)});
      }
      const int mine = chart[c] = chart[group[c]];
      leaves_[mine].push_back(c);
      const Prism& prism = charts_[mine];
      add(chain.area, chain.first, prism.first, prism.last, 1, sums[mine].area);
      add(chain.perimeter, chain.first, prism.first, prism.last, 1, sums[mine].side);
    }
    std::map<std::pair<int, int>, std::vector<std::int64_t>> common;  // over the life of the first
    for (const NeighbourGraph::Contact& contact : graph.contacts) {
      const auto [a, b] = std::minmax(chart[contact.one], chart[contact.other]);
      const Prism& prism = charts_[a];
      if (a == b) {
        add(contact.length, contact.first, prism.first, prism.last, -2, sums[a].side);
        continue;
      }
      auto& lengths = common[{a, b}];
      lengths.resize(prism.last - prism.first + 1);
      add(contact.length, contact.first, prism.first, prism.last, 1, lengths);
    }
    for (std::size_t c = 0; c < charts_.size(); ++c) {
      charts_[c].area = {charts_[c].first, sums[c].area};
      charts_[c].side = {charts_[c].first, sums[c].side};
      set_energy(charts_[c]);
    }
    for (const auto& [pair, lengths] : common) {
      const Series series(charts_[pair.first].first, lengths);
      charts_[pair.first].neighbours[pair.second] = series;
      charts_[pair.second].neighbours[pair.first] = series;
    }
    living_ = int(charts_.size());
  }

  double energy() const { return double(total_) / energy_unit; }
  int living() const { return living_; }

  /// Returns the number of edits.
  int descend(const Progress& progress) {
    for (int c = 0; c < int(charts_.size()); ++c)
      for (const auto& [other, length] : charts_[c].neighbours)
        if (other > c) offer(c, other);
    int edits = 0;
    const int begun = living_;
    while (!offers_.empty()) {
      const auto [change, j, k] = offers_.top();
      offers_.pop();
      if (!charts_[j].is_alive || !charts_[k].is_alive) continue;
      edit(j, k);
      if (++edits % 256 == 0) progress.at(1 - double(living_) / begun);
    }
    return edits;
  }

  std::vector<LifespanChart> charts() const {
    std::vector<LifespanChart> result;
    for (const Prism& prism : charts_) {
      if (!prism.is_alive) continue;
      result.push_back({{}, prism.first, prism.last, prism.goes_on});
      std::vector<int> open = {prism.members};
      while (!open.empty()) {
        const int node = open.back();
        open.pop_back();
        if (node < int(leaves_.size())) {
          result.back().chains.insert(result.back().chains.end(), leaves_[node].begin(),
                                      leaves_[node].end());
          continue;
        }
        const auto& parts = unions_[node - leaves_.size()];
        open.insert(open.end(), parts.begin(), parts.end());
      }
      std::ranges::sort(result.back().chains);
    }
    std::ranges::sort(result, [](const LifespanChart& a, const LifespanChart& b) {
      return std::pair(a.first, a.chains.front()) < std::pair(b.first, b.chains.front());
    });
    return result;
  }

 private:
  using Offer = std::tuple<std::int64_t, int, int>;  // change of energy, two charts

  void set_energy(Prism& prism) {
    prism.energy = energy_of_(prism.area.sum(prism.first, prism.last),
                              prism.side.sum(prism.first, prism.last), prism.first, prism.last);
    total_ += prism.energy;
  }

  std::int64_t energy_within(const Prism& prism, int first, int last) const {
    if (first > last) return 0;
    return energy_of_(prism.area.sum(first, last), prism.side.sum(first, last), first, last);
  }

  /// The periods in which two may become one.
  std::pair<int, int> in_common(const Prism& a, const Prism& b) const {
    return {std::max({a.first, b.first, past_}), std::min(a.last, b.last)};
  }

  /// ΔE of making one chart of two for the periods that they have in common.
  std::int64_t change(const Prism& a, const Prism& b, const Series& common) const {
    const auto [first, last] = in_common(a, b);
    std::int64_t energy =
        energy_of_(a.area.sum(first, last) + b.area.sum(first, last),
                   a.side.sum(first, last) + b.side.sum(first, last) - 2 * common.sum(first, last),
                   first, last);
    for (const Prism* prism : {&a, &b})
      energy += energy_within(*prism, prism->first, first - 1) +
                energy_within(*prism, last + 1, prism->last);
    return energy - a.energy - b.energy;
  }

  void offer(int j, int k) {
    if (charts_[j].goes_on >= 0 && charts_[j].goes_on == charts_[k].goes_on) return;
    const auto [first, last] = in_common(charts_[j], charts_[k]);
    if (first > last) return;
    const std::int64_t gain = change(charts_[j], charts_[k], charts_[j].neighbours.at(k));
    if (gain < 0) offers_.push({gain, std::min(j, k), std::max(j, k)});
  }

  void edit(int j, int k) {
    const auto [first, last] = in_common(charts_[j], charts_[k]);
    const int begin = int(charts_.size());
    Prism joined;
    joined.first = first;
    joined.last = last;
    joined.area = sum(charts_[j].area, charts_[k].area, 1, first, last);
    joined.side = sum(sum(charts_[j].side, charts_[k].side, 1, first, last),
                      charts_[j].neighbours.at(k), -2, first, last);
    joined.members = int(leaves_.size() + unions_.size());
    unions_.push_back({charts_[j].members, charts_[k].members});
    charts_.push_back(std::move(joined));
    std::vector<int> sources = {-1};
    for (const int c : {j, k}) {
      for (const auto& [from, to] :
           {std::pair(charts_[c].first, first - 1), std::pair(last + 1, charts_[c].last)}) {
        if (from > to) continue;
        Prism rest;
        rest.first = from;
        rest.last = to;
        rest.area = charts_[c].area;
        rest.side = charts_[c].side;
        rest.members = charts_[c].members;
        if (from < past_) rest.goes_on = charts_[c].goes_on;
        charts_.push_back(std::move(rest));
        sources.push_back(c);
      }
    }
    for (const int c : {j, k}) {
      charts_[c].is_alive = false;
      total_ -= charts_[c].energy;
      for (const auto& [other, length] : charts_[c].neighbours) charts_[other].neighbours.erase(c);
    }
    for (int c = begin; c < int(charts_.size()); ++c) {
      set_energy(charts_[c]);
      const int source = sources[c - begin];
      if (source != k) take_neighbours(c, source < 0 ? j : source, k);
      if (source < 0 || source == k) take_neighbours(c, k, j);
      for (const auto& [other, length] : charts_[c].neighbours) offer(c, other);
    }
    living_ += int(charts_.size()) - begin - 2;
    for (const int c : {j, k}) {
      charts_[c] = {};
      charts_[c].is_alive = false;
    }
  }

  /// Gives a new chart the neighbours of an old one.
  void take_neighbours(int fresh, int old, int partner) {
    Prism& chart = charts_[fresh];
    for (const auto& [other, length] : charts_[old].neighbours) {
      if (other == partner) continue;
      Prism& neighbour = charts_[other];
      const int first = std::max(chart.first, neighbour.first);
      const int last = std::min(chart.last, neighbour.last);
      if (first > last || length.sum(first, last) == 0) continue;
      Series& common = chart.neighbours[other];
      common = sum(common, length, 1, first, last);
      neighbour.neighbours[fresh] = common;
    }
  }

  Energy energy_of_;
  int past_;                              // periods that are over
  std::vector<Prism> charts_;             // every one there ever was
  std::vector<std::vector<int>> leaves_;  // chains of the first charts
  std::vector<std::array<int, 2>> unions_;
  std::int64_t total_ = 0;
  int living_ = 0;
  std::priority_queue<Offer, std::vector<Offer>, std::greater<>> offers_;
};

}  // namespace

LifespanCharts find_lifespan_charts(const NeighbourGraph& graph, const ChartingOptions& options,
                                    const Progress& progress) {
  Charting charting(graph, options);
  LifespanCharts result;
  result.first_energy = charting.energy();
  result.first_charts = charting.living();
  if (options.edits == ChartingOptions::Edits::descend) result.edits = charting.descend(progress);
  result.energy = charting.energy();
  result.charts = charting.charts();
  return result;
}

double charting_energy(const NeighbourGraph& graph, const std::vector<LifespanChart>& charts,
                       double beta) {
  std::vector<WaningChart> all;
  for (const LifespanChart& chart : charts)
    all.push_back({chart.first, chart.chains, std::vector<int>(chart.chains.size(), chart.last)});
  return charting_energy(graph, all, beta);
}

double charting_energy(const NeighbourGraph& graph, const std::vector<WaningChart>& charts,
                       double beta) {
  const Energy energy_of(graph, beta, 0);
  const auto within = [](const std::vector<std::int64_t>& values, int from, int first, int last) {
    std::int64_t total = 0;
    for (int i = std::max(first, from); i <= last && i - from < int(values.size()); ++i)
      total += values[i - from];
    return total;
  };
  struct Stay {
    int chart, last;
  };
  std::vector<std::vector<Stay>> stays(graph.chains.size());     // of each chain
  std::vector<std::map<int, std::int64_t>> area(charts.size());  // by last period
  std::vector<std::int64_t> side(charts.size());
  for (int c = 0; c < int(charts.size()); ++c)
    for (std::size_t i = 0; i < charts[c].chains.size(); ++i) {
      const NeighbourGraph::Chain& chain = graph.chains[charts[c].chains[i]];
      const int first = charts[c].first, last = charts[c].last[i];
      stays[charts[c].chains[i]].push_back({c, last});
      area[c][last] += within(chain.area, chain.first, first, last);
      side[c] += within(chain.perimeter, chain.first, first, last);
    }
  for (const NeighbourGraph::Contact& contact : graph.contacts)
    for (const Stay& one : stays[contact.one])
      for (const Stay& other : stays[contact.other])
        if (one.chart == other.chart)
          side[one.chart] -= 2 * within(contact.length, contact.first, charts[one.chart].first,
                                        std::min(one.last, other.last));
  std::int64_t total = 0;
  for (std::size_t c = 0; c < charts.size(); ++c) {
    double cap = 0;
    for (const auto& [last, sum] : area[c]) cap += energy_of.cap(sum, charts[c].first, last);
    total += energy_of.of_cap(cap, side[c]);
  }
  return double(total) / energy_unit;
}

}  // namespace mq
