#include "mq/evolving/lifespan_charts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>

#include "evolving_models.h"
#include "mq/base/error.h"
#include "mq/base/random.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

TEST(NeighbourGraph, MeasuresTrianglesAndWhereTheyMeet) {
  EvolvingMesh evolving = patched_sheet(4, 2, 3);
  for (EvolvingFrame& frame : evolving.frames)
    for (Vector3& p : frame.positions) p.z() = 0;
  const NeighbourGraph graph = neighbour_graph(evolving);
  EXPECT_EQ(graph.frame_counts, (std::vector<int>{3, 3}));
  const double unit = 0x1p40;
  std::int64_t area = 0, outline = 0;
  for (const auto& chain : graph.chains) {
    for (const std::int64_t a : chain.area) area += a;
    for (const std::int64_t p : chain.perimeter) outline += p;
    EXPECT_NEAR(double(chain.area[0]), 3 * unit / 32, 64);
    EXPECT_NEAR(double(chain.perimeter[0]), 3 * unit * (2 + std::numbers::sqrt2) / 4, 64);
  }
  EXPECT_NEAR(double(area) / unit, 6, 1e-8);  // a mean area per frame
  for (const auto& contact : graph.contacts)
    for (const std::int64_t l : contact.length) outline -= 2 * l;
  EXPECT_NEAR(double(outline) / unit, 6 * 4, 1e-8);  // of a square of unit area
  EXPECT_NEAR(graph.radius, std::sqrt(4 / (3 * std::sqrt(3.0)) / 32), 1e-12);
}

TEST(NeighbourGraph, LeavesOutCollapsedTriangles) {
  EvolvingMesh evolving = patched_sheet(3, 1, 1);
  evolving.segments[0].triangles.push_back({2, 2, 5});
  evolving.segments[0].triangle_ids.push_back(900);
  EXPECT_EQ(neighbour_graph(evolving).chains.size(), 18U);
  for (EvolvingFrame& frame : evolving.frames)
    for (Vector3& p : frame.positions) p.y() = p.z() = 0;
  EXPECT_THROW(neighbour_graph(evolving), InvalidInput);
}

TEST(LifespanCharts, CoverEveryTriangleOnceAtEveryTime) {
  const NeighbourGraph graph = neighbour_graph(patched_sheet(16, 8, 7));
  for (const auto edits : {ChartingOptions::Edits::none, ChartingOptions::Edits::descend}) {
    const LifespanCharts found = find_lifespan_charts(graph, {.edits = edits});
    std::vector<std::set<int>> seen(graph.frame_counts.size());
    for (const LifespanChart& chart : found.charts)
      for (const int c : chart.chains) {
        EXPECT_LE(graph.chains[c].first, chart.first);
        EXPECT_GE(graph.chains[c].last(), chart.last);
        for (int i = chart.first; i <= chart.last; ++i) EXPECT_TRUE(seen[i].insert(c).second);
      }
    std::size_t covered = 0, nodes = 0;
    for (const auto& chains : seen) covered += chains.size();
    for (const auto& chain : graph.chains) nodes += chain.area.size();
    EXPECT_EQ(covered, nodes);
  }
}

TEST(LifespanCharts, KeepTheEnergyThatTheyHave) {
  for (int seed = 1; seed <= 6; ++seed) {
    const NeighbourGraph graph = neighbour_graph(patched_sheet(14, 10, seed));
    const LifespanCharts found = find_lifespan_charts(graph);
    EXPECT_GT(found.edits, 10);
    EXPECT_LT(found.energy, found.first_energy);
    EXPECT_EQ(found.energy, charting_energy(graph, found.charts, 1));
    const LifespanCharts first =
        find_lifespan_charts(graph, {.edits = ChartingOptions::Edits::none});
    EXPECT_EQ(int(first.charts.size()), found.first_charts);
    EXPECT_EQ(found.first_energy, charting_energy(graph, first.charts, 1));
    EXPECT_LT(found.charts.size(), first.charts.size());
  }
}

/// A plane of 2 × 1 squares over three periods; the right square is there in the first only.
NeighbourGraph two_squares() {
  EvolvingMesh evolving = patched_sheet(2, 1, 1);
  for (EvolvingFrame& frame : evolving.frames)
    for (Vector3& p : frame.positions) p.z() = 0;
  EvolvingSegment& segment = evolving.segments[0];
  segment.triangles.resize(4);
  segment.triangle_ids.resize(4);
  EvolvingSegment left = segment;
  left.triangles.resize(2);
  left.triangle_ids.resize(2);
  evolving.segments.push_back(left);
  evolving.frames[1].segment = evolving.frames[2].segment = 1;
  return neighbour_graph(evolving);
}

TEST(WaningCharts, HaveTheCapsOfTheirTrianglesAndTheSidesThatAreThere) {
  const NeighbourGraph graph = two_squares();  // of a mean area of 4/3, squares of 1
  ASSERT_EQ(graph.frame_counts, (std::vector<int>{1, 2}));
  const double area = 4.0 / 3, cap = 2 * 2 / area, sides = (6 + 2 * 4) / std::sqrt(area);
  EXPECT_NEAR(charting_energy(graph, {WaningChart{0, {0, 1, 2, 3}, {1, 1, 0, 0}}}, 1),
              cap + graph.radius / 3 * sides / cap, 1e-6);
  // Nothing lost: as a prism.
  EXPECT_EQ(charting_energy(graph, {WaningChart{0, {0, 1}, {1, 1}}}, 1),
            charting_energy(graph, {LifespanChart{{0, 1}, 0, 1}}, 1));
}

/// E of the thesis, from nothing but the meshes: ‖C‖_C + α ‖C‖_S / ‖C‖_C, α ten times the mean radius of a triangle.
double thesis_energy(const EvolvingMesh& evolving, const NeighbourGraph& graph, const LifespanCharts& found) {
  double area = 0, count = 0, energy = 0;
  for (int f = 0; f < int(evolving.frames.size()); ++f) {
    area += total_area(evolving.mesh(f));
    count += evolving.segments[evolving.frames[f].segment].triangle_count();
  }
  const double alpha = 10 * std::sqrt(area / count * 4 / (3 * std::sqrt(3.0)));
  for (const LifespanChart& chart : found.charts) {
    std::set<int> ids;
    for (const int c : chart.chains) ids.insert(graph.chains[c].triangle);
    double caps = 0, sides = 0, frames = 0;
    for (int f = 0; f < int(evolving.frames.size()); ++f) {
      const int period = evolving.frames[f].segment;
      if (period < chart.first || period > chart.last) continue;
      ++frames;
      const EvolvingSegment& segment = evolving.segments[period];
      const Mesh mesh = evolving.mesh(f);
      std::map<std::pair<int, int>, int> uses;
      for (int t = 0; t < mesh.triangle_count(); ++t) {
        if (!ids.contains(segment.triangle_ids[t])) continue;
        caps += 2 * triangle_area(mesh, t);
        for (int k = 0; k < 3; ++k) ++uses[std::minmax({mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]})];
      }
      for (const auto& [edge, used] : uses)
        if (used == 1) sides += (mesh.positions[edge.first] - mesh.positions[edge.second]).norm();
    }
    caps /= frames;
    energy += caps + alpha * sides / caps;
  }
  return energy;
}

TEST(LifespanCharts, HaveTheEnergyOfTheThesisWithTenTimesTheFramesPerArea) {
  for (const double side : {1.0, 1.7}) {
    const EvolvingMesh evolving = patched_sheet(12, 6, 3, side / 12);
    const NeighbourGraph graph = neighbour_graph(evolving);
    double area = 0;
    const double frames = double(evolving.frames.size());
    for (int f = 0; f < int(frames); ++f) area += total_area(evolving.mesh(f)) / frames;
    const double beta = 10 * frames / area;
    for (const auto edits : {ChartingOptions::Edits::none, ChartingOptions::Edits::descend}) {
      const LifespanCharts found = find_lifespan_charts(graph, {.beta = beta, .edits = edits});
      const double wanted = thesis_energy(evolving, graph, found);
      EXPECT_NEAR(area * charting_energy(graph, found.charts, beta), wanted, 1e-5 * wanted);
    }
  }
}

TEST(LifespanCharts, LeaveThePastAsItWas) {
  for (int seed = 1; seed <= 4; ++seed) {
    const NeighbourGraph graph = neighbour_graph(patched_sheet(14, 8, seed));
    ChartingOptions options{.past = 1};
    // The past: the left and the right half of what was there.
    for (std::size_t c = 0; c < graph.chains.size(); ++c)
      options.chart_of.push_back(graph.chains[c].first > 0            ? -1
                                 : graph.chains[c].triangle % 28 < 14 ? 10
                                                                      : 20);
    const LifespanCharts found = find_lifespan_charts(graph, options);
    EXPECT_LT(found.energy, found.first_energy);
    EXPECT_EQ(found.energy, charting_energy(graph, found.charts, 1));
    std::map<std::pair<int, int>, int> times;  // of chain and period
    for (const LifespanChart& chart : found.charts)
      for (const int c : chart.chains) {
        if (chart.first == 0)
          EXPECT_EQ(chart.goes_on, options.chart_of[c]);
        else
          EXPECT_EQ(chart.goes_on, -1);
        for (int i = chart.first; i <= chart.last; ++i) ++times[{c, i}];
      }
    std::size_t nodes = 0;
    for (const auto& chain : graph.chains) nodes += chain.area.size();
    EXPECT_EQ(times.size(), nodes);
    for (const auto& [place, count] : times) EXPECT_EQ(count, 1);
  }
}

TEST(LifespanCharts, AreConnectedAndEqualLivesNeverMeet) {
  const NeighbourGraph graph = neighbour_graph(patched_sheet(16, 8, 11));
  const LifespanCharts found = find_lifespan_charts(graph);
  for (std::size_t c = 0; c < found.charts.size(); ++c) {
    const LifespanChart& chart = found.charts[c];
    std::set<int> open(chart.chains.begin(), chart.chains.end()), reached = {chart.chains[0]};
    for (bool grew = true; grew;) {
      grew = false;
      for (const auto& contact : graph.contacts)
        if (open.contains(contact.one) && open.contains(contact.other) &&
            reached.contains(contact.one) != reached.contains(contact.other)) {
          reached.insert({contact.one, contact.other});
          grew = true;
        }
    }
    EXPECT_EQ(reached.size(), open.size());
    for (std::size_t d = 0; d < c; ++d) {
      const LifespanChart& other = found.charts[d];
      if (other.first != chart.first || other.last != chart.last) continue;
      for (const auto& contact : graph.contacts)
        for (const auto& [a, b] :
             {std::pair(contact.one, contact.other), std::pair(contact.other, contact.one)})
          EXPECT_FALSE(std::ranges::binary_search(chart.chains, a) &&
                       std::ranges::binary_search(other.chains, b));
    }
  }
}

TEST(LifespanCharts, AreTheSameInEveryUnitOfLength) {
  const LifespanCharts one = find_lifespan_charts(neighbour_graph(patched_sheet(12, 6, 5)));
  const LifespanCharts other = find_lifespan_charts(neighbour_graph(patched_sheet(12, 6, 5, 100)));
  EXPECT_EQ(one.energy, other.energy);
  ASSERT_EQ(one.charts.size(), other.charts.size());
  for (std::size_t c = 0; c < one.charts.size(); ++c) {
    EXPECT_EQ(one.charts[c].chains, other.charts[c].chains);
    EXPECT_EQ(one.charts[c].first, other.charts[c].first);
    EXPECT_EQ(one.charts[c].last, other.charts[c].last);
  }
}

TEST(LifespanCharts, AreTheSameWithEveryFrameTwice) {
  const EvolvingMesh evolving = patched_sheet(14, 10, 3);
  EvolvingMesh doubled = evolving;
  doubled.frames.clear();
  for (const EvolvingFrame& frame : evolving.frames)
    for (int k = 0; k < 2; ++k)
      doubled.frames.push_back({2 * frame.number + k, frame.segment, frame.positions});
  const LifespanCharts one = find_lifespan_charts(neighbour_graph(evolving));
  const LifespanCharts other = find_lifespan_charts(neighbour_graph(doubled));
  ASSERT_EQ(one.charts.size(), other.charts.size());
  for (std::size_t c = 0; c < one.charts.size(); ++c) {
    EXPECT_EQ(one.charts[c].chains, other.charts[c].chains);
    EXPECT_EQ(one.charts[c].first, other.charts[c].first);
  }
  EXPECT_NEAR(one.energy, other.energy, 1e-5);
}

TEST(LifespanCharts, AreOneChartWhereNothingChanges) {
  const LifespanCharts found = find_lifespan_charts(neighbour_graph(patched_sheet(10, 1, 2)));
  ASSERT_EQ(found.charts.size(), 1U);
  EXPECT_EQ(found.charts[0].chains.size(), 200U);
  EXPECT_EQ(found.edits, 0);
}

// ---- The best there is, by trying everything ----

/// Chains on a ring with a chord, of random lives, areas and contacts.
NeighbourGraph random_graph(std::uint64_t seed, int chains, int periods) {
  const Random random(seed);
  std::uint64_t draw = 0;
  NeighbourGraph graph;
  for (int i = 0; i < periods; ++i)
    graph.frame_counts.push_back(1 + int(random.uniform(draw++) * 9));
  graph.radius = 0.2 / std::sqrt(chains);
  const auto fixed = [](double value) { return std::int64_t(value * 0x1p40); };
  for (int c = 0; c < chains; ++c) {
    const int first = int(random.uniform(draw++) * periods);
    const int last = first + int(random.uniform(draw++) * (periods - first));
    NeighbourGraph::Chain chain{c, first, {}, {}};
    const double area = (0.2 + random.uniform(draw++)) / chains;
    for (int i = first; i <= last; ++i) {
      chain.area.push_back(fixed(area * graph.frame_counts[i]));
      chain.perimeter.push_back(fixed(4.5 * std::sqrt(area) * graph.frame_counts[i]));
    }
    graph.chains.push_back(chain);
  }
  for (int c = 0; c < chains; ++c)
    for (const int d : {(c + 1) % chains, (c + 3) % chains}) {
      const auto& [a, b] = std::minmax(c, d);
      const int first = std::max(graph.chains[a].first, graph.chains[b].first);
      const int last = std::min(graph.chains[a].last(), graph.chains[b].last());
      if (first > last || a == b) continue;
      NeighbourGraph::Contact contact{a, b, first, {}};
      const double length = std::sqrt(0.5 / chains) * (0.3 + 0.5 * random.uniform(draw++));
      for (int i = first; i <= last; ++i)
        contact.length.push_back(fixed(length * graph.frame_counts[i]));
      graph.contacts.push_back(contact);
    }
  return graph;
}

/// The least energy of any charts, period by period: charts under way are sets of chains with the
/// period they began in; each goes on or ends.
class BestCharts {
 public:
  BestCharts(const NeighbourGraph& graph, double beta) : graph_(graph), beta_(beta) {}
  double energy() { return from(0, {}); }

 private:
  using Open = std::vector<std::pair<int, int>>;  // chains as bits, first period

  int alive(int period) const {
    int set = 0;
    for (int c = 0; c < int(graph_.chains.size()); ++c)
      if (graph_.chains[c].first <= period && period <= graph_.chains[c].last()) set |= 1 << c;
    return set;
  }

  bool connected(int set) const {
    int reached = set & -set;
    for (int before = 0; before != reached;) {
      before = reached;
      for (const auto& contact : graph_.contacts) {
        const int pair = 1 << contact.one | 1 << contact.other;
        if ((pair & set) == pair && (pair & reached) != 0) reached |= pair;
      }
    }
    return reached == set;
  }

  double chart(int set, int first, int last) {
    const auto [place, is_new] = charts_.try_emplace({set, first, last}, 0);
    if (is_new) {
      LifespanChart chart{{}, first, last};
      for (int c = 0; c < int(graph_.chains.size()); ++c)
        if (set >> c & 1) chart.chains.push_back(c);
      place->second = charting_energy(graph_, {chart}, beta_);
    }
    return place->second;
  }

  /// The least from here on, charts of `open` not yet paid.
  double from(int period, const Open& open) {
    const int now = period < int(graph_.frame_counts.size()) ? alive(period) : 0;
    const auto [place, is_new] = known_.try_emplace({period, open}, 0);
    if (!is_new) return place->second;
    double least = std::numeric_limits<double>::infinity();
    for (int going = 0; going < 1 << open.size(); ++going) {
      double energy = 0;
      int covered = 0;
      Open next;
      for (std::size_t i = 0; i < open.size(); ++i)
        if (going >> i & 1) {
          if ((open[i].first & now) != open[i].first) energy = 1e300;
          covered |= open[i].first;
          next.push_back(open[i]);
        } else
          energy += chart(open[i].first, open[i].second, period - 1);
      if (energy >= 1e300) continue;
      if (now == 0 && period == int(graph_.frame_counts.size()))
        least = std::min(least, energy);
      else
        least = std::min(least, energy + begin(period, now & ~covered, next));
    }
    return known_[{period, open}] = least;
  }

  /// The least over all ways to begin charts of the chains left.
  double begin(int period, int left, const Open& open) {
    if (left == 0) {
      Open sorted = open;
      std::ranges::sort(sorted);
      return from(period + 1, sorted);
    }
    double least = std::numeric_limits<double>::infinity();
    const int lowest = left & -left, rest = left ^ lowest;
    for (int some = rest;; some = (some - 1) & rest) {
      if (connected(lowest | some)) {
        Open next = open;
        next.emplace_back(lowest | some, period);
        least = std::min(least, begin(period, rest & ~some, next));
      }
      if (some == 0) return least;
    }
  }

  const NeighbourGraph& graph_;
  double beta_;
  std::map<std::tuple<int, int, int>, double> charts_;
  std::map<std::pair<int, Open>, double> known_;
};

TEST(LifespanCharts, OfThePastHaveWhatWasAddedToThem) {
  // A sheet of which some is replaced when the past is over; what is new was added to the chart of all.
  const EvolvingMesh evolving = patched_sheet(8, 2, 1);
  const NeighbourGraph graph = neighbour_graph(evolving);
  const auto charts = [&](int of_new) {
    ChartingOptions options{.edits = ChartingOptions::Edits::none, .frames = 6, .past = 1};
    for (const NeighbourGraph::Chain& chain : graph.chains) options.chart_of.push_back(chain.first == 0 ? 0 : of_new);
    return find_lifespan_charts(graph, options);
  };
  const LifespanCharts added = charts(0), apart = charts(-1);
  EXPECT_LT(added.charts.size(), apart.charts.size());
  std::size_t chains = 0;
  for (const LifespanChart& chart : added.charts) {
    EXPECT_EQ(chart.goes_on, 0);
    EXPECT_EQ(chart.first, 0);  // nothing begins
    chains += chart.chains.size();
  }
  EXPECT_EQ(chains, graph.chains.size());
}

TEST(LifespanCharts, AreNearlyTheBestOfAll) {
  // From charts that split in time as soon as it saves a seam to charts that never do.
  for (const double beta : {1.0, 3.0, 10.0, 30.0, 200.0}) {
    double mean = 0, worst = 0;
    int neither = 0;  // graphs whose best charts are not those the descent begins with
    constexpr int graphs = 40;
    for (int seed = 1; seed <= graphs; ++seed) {
      const NeighbourGraph graph = random_graph(seed, 5 + seed % 4, 4);
      const double best = BestCharts(graph, beta).energy();
      const LifespanCharts found = find_lifespan_charts(graph, {.beta = beta});
      EXPECT_GE(found.energy, best - 1e-6);
      mean += found.energy / best / graphs;
      worst = std::max(worst, found.energy / best);
      neither += best < found.first_energy - 1e-3;
    }
    EXPECT_LE(mean, 1.05);  // 1.0235 at most, where this was written
    EXPECT_LE(worst, 1.25);
    EXPECT_GE(neither, graphs / 2);
  }
}

}  // namespace
}  // namespace mq
