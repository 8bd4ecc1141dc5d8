// Dijkstra over triangles (charts) and over vertices (trees of cuts). A chart is a disc if its
// vertices - edges + triangles is 1, where vertices are counted as fans inside the chart; what is
// no disc is halved until it is, and the largest charts are halved until there are enough.

#include "mq/sample/detail/segment.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>

#include "mq/base/infinity.h"
#include "mq/base/random.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/weld.h"
#include "mq/sample/noise.h"

namespace mq {
namespace {


struct Site {
  int triangle;
  double start;  // distance it begins with
};

struct Dual {
  const Surface& surface;
  std::vector<Vector3> centers;
  std::vector<Vector3> normals;
  std::vector<double> areas;

  explicit Dual(const Surface& s)
      : surface(s), normals(triangle_normals(s.mesh)), areas(triangle_areas(s.mesh)) {
    for (int t = 0; t < s.triangle_count(); ++t)
      centers.push_back((s.mesh.position(t, 0) + s.mesh.position(t, 1) + s.mesh.position(t, 2)) /
                        3);
  }

  /// Distance between neighbours; a right angle between them counts as five times the way.
  double length(int a, int b) const {
    return (centers[a] - centers[b]).norm() * (1 + 4 * (1 - normals[a].dot(normals[b])));
  }

  /// Per triangle that `inside` allows the nearest site (its index), -1 elsewhere.
  template <class Inside>
  std::vector<int> nearest(const std::vector<Site>& sites, const Inside& inside,
                           std::vector<double>* distances = nullptr) const {
    using Entry = std::tuple<double, int, int>;  // distance, triangle, site
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    std::vector<int> found(centers.size(), -1);
    std::vector<double> best(centers.size(), infinity);
    for (std::size_t i = 0; i < sites.size(); ++i)
      queue.emplace(sites[i].start, sites[i].triangle, int(i));
    for (const Site& site : sites) best[site.triangle] = -infinity;  // a site keeps its triangle
    while (!queue.empty()) {
      const auto [distance, t, site] = queue.top();
      queue.pop();
      if (found[t] >= 0) continue;
      found[t] = site;
      best[t] = distance;
      for (int k = 0; k < 3; ++k) {
        const HalfEdge twin = surface.twins[3 * t + k];
        if (twin < 0 || found[twin / 3] >= 0 || !inside(twin / 3)) continue;
        const double through = distance + length(t, twin / 3);
        if (through < best[twin / 3]) {
          best[twin / 3] = through;
          queue.emplace(through, twin / 3, site);
        }
      }
    }
    if (distances) *distances = std::move(best);
    return found;
  }
};

/// Euler characteristic of each chart as a surface of its own; 1 for discs.
std::vector<int> euler_characteristics(const Surface& surface, const std::vector<int>& charts,
                                       int count) {
  const auto joined = [&](HalfEdge h) {
    return surface.twins[h] >= 0 && charts[surface.twins[h] / 3] == charts[h / 3];
  };
  std::vector<int> euler(count);
  DisjointSets corners(surface.twins.size());
  for (HalfEdge h = 0; h < HalfEdge(surface.twins.size()); ++h) {
    if (h % 3 == 0) ++euler[charts[h / 3]];
    if (!joined(h) || h > surface.twins[h]) --euler[charts[h / 3]];
    if (joined(h)) corners.join(h, next(surface.twins[h]));
  }
  for (HalfEdge h = 0; h < HalfEdge(surface.twins.size()); ++h)
    if (corners.root(h) == h) ++euler[charts[h / 3]];
  return euler;
}

/// Gives the half of `chart` around one of two triangles far apart the number `fresh`.
void halve(const Dual& dual, std::vector<int>& charts, const std::vector<int>& members, int fresh) {
  const int chart = charts[members.front()];
  const auto inside = [&](int t) { return charts[t] == chart; };
  const auto farthest = [&](int from) {
    std::vector<double> distances;
    dual.nearest({{from, 0}}, inside, &distances);
    return *std::max_element(members.begin(), members.end(),
                             [&](int a, int b) { return distances[a] < distances[b]; });
  };
  const int a = farthest(members.front()), b = farthest(a);
  const std::vector<int> half = dual.nearest({{a, 0}, {b, 0}}, inside);
  for (const int t : members)
    if (half[t] == 1) charts[t] = fresh;
}

std::vector<std::vector<int>> members_of(const std::vector<int>& charts, int count) {
  std::vector<std::vector<int>> members(count);
  for (int t = 0; t < int(charts.size()); ++t) members[charts[t]].push_back(t);
  return members;
}

/// Halves charts until all are discs; returns how many there are.
int make_discs(const Dual& dual, std::vector<int>& charts, int count) {
  for (;;) {
    const std::vector<int> euler = euler_characteristics(dual.surface, charts, count);
    const auto members = members_of(charts, count);
    const int before = count;
    for (int c = 0; c < before; ++c)
      if (euler[c] != 1 && members[c].size() > 1) halve(dual, charts, members[c], count++);
    if (count == before) return count;
  }
}

/// Triangles at random, by area; uneven ones crowd in some places, and begin with a handicap.
std::vector<Site> random_sites(const Dual& dual, int count, const SegmentOptions& options) {
  double area = 0;
  for (const double a : dual.areas) area += a;
  const double radius = std::sqrt(area / count);
  const Noise noise(options.seed);
  std::vector<double> sums(dual.areas.size());
  double sum = 0;
  for (std::size_t t = 0; t < sums.size(); ++t) {
    const double crowding = noise.octaves(dual.centers[t] * 5 / std::sqrt(area), 3);
    sums[t] = sum += dual.areas[t] * std::exp2(16 * options.unevenness * crowding);
  }
  const Random random(options.seed, 1);
  std::vector<Site> sites;
  std::vector<char> taken(sums.size());
  for (std::uint64_t i = 0; int(sites.size()) < count; ++i) {
    const auto at = std::lower_bound(sums.begin(), sums.end(), random.uniform(2 * i, 0, sum));
    const int t = int(std::min(at, sums.end() - 1) - sums.begin());
    if (taken[t]) continue;
    taken[t] = 1;
    sites.push_back({t, options.unevenness * radius * random.uniform(2 * i + 1)});
  }
  return sites;
}

/// Sites move to the triangle nearest to the middle of their chart.
void move_to_centers(const Dual& dual, const std::vector<int>& charts, std::vector<Site>& sites) {
  const auto members = members_of(charts, int(sites.size()));
  for (std::size_t c = 0; c < sites.size(); ++c) {
    Vector3 middle = Vector3::Zero();
    double area = 0;
    for (const int t : members[c]) {
      middle += dual.areas[t] * dual.centers[t];
      area += dual.areas[t];
    }
    middle /= area;
    sites[c].triangle = *std::min_element(members[c].begin(), members[c].end(), [&](int a, int b) {
      return (dual.centers[a] - middle).squaredNorm() < (dual.centers[b] - middle).squaredNorm();
    });
  }
}

void split_largest(const Dual& dual, std::vector<int>& charts, int& count, int wanted) {
  while (count < wanted) {
    std::vector<double> areas(count);
    for (std::size_t t = 0; t < charts.size(); ++t) areas[charts[t]] += dual.areas[t];
    auto members = members_of(charts, count);
    std::vector<int> order(count);
    for (int c = 0; c < count; ++c) order[c] = c;
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return areas[a] > areas[b]; });
    const int at_once = std::max(1, (wanted - count) / 4), before = count;
    for (int i = 0; i < at_once && i < before; ++i)
      if (members[order[i]].size() > 1) halve(dual, charts, members[order[i]], count++);
    if (count == before) return;
    count = make_discs(dual, charts, count);
  }
}

}  // namespace

std::vector<int> segment(const Surface& surface, const SegmentOptions& options) {
  const Dual dual(surface);
  const int wanted = std::clamp(options.charts, 1, std::max(1, surface.triangle_count()));
  std::vector<int> charts;
  for (int begin = wanted;; begin = begin * 9 / 10) {  // fewer, where discs take too many
    std::vector<Site> sites = random_sites(dual, begin, options);
    const auto everywhere = [](int) { return true; };
    charts = dual.nearest(sites, everywhere);
    for (int round = 0; round < options.rounds; ++round) {
      move_to_centers(dual, charts, sites);
      charts = dual.nearest(sites, everywhere);
    }
    int count = make_discs(dual, charts, int(sites.size()));
    split_largest(dual, charts, count, wanted);
    if (count == wanted || begin <= 1) return charts;
  }
}

std::vector<char> seams_between(const Surface& surface, const std::vector<int>& charts) {
  std::vector<char> seams(surface.twins.size());
  for (HalfEdge h = 0; h < HalfEdge(seams.size()); ++h)
    seams[h] = surface.twins[h] >= 0 && charts[h / 3] != charts[surface.twins[h] / 3];
  return seams;
}

std::vector<char> seams_along_tree(const Surface& surface, int root, int tips) {
  const Mesh& mesh = surface.mesh;
  std::vector<std::vector<HalfEdge>> leaving(mesh.positions.size());
  for (HalfEdge h = 0; h < HalfEdge(surface.twins.size()); ++h)
    leaving[mesh.triangles[h / 3][h % 3]].push_back(h);
  const auto to = [&](HalfEdge h) { return mesh.triangles[h / 3][(h % 3 + 1) % 3]; };

  std::vector<char> seams(surface.twins.size());
  std::vector<int> tree{root};
  for (int tip = 0; tip < tips; ++tip) {
    std::vector<double> distances(mesh.positions.size(), infinity);
    std::vector<HalfEdge> arrival(mesh.positions.size(), -1);
    std::priority_queue<std::pair<double, int>, std::vector<std::pair<double, int>>, std::greater<>>
        queue;
    for (const int v : tree) queue.emplace(distances[v] = 0, v);
    int last = root;
    while (!queue.empty()) {
      const auto [distance, v] = queue.top();
      queue.pop();
      if (distance > distances[v]) continue;
      last = v;  // in the end the vertex farthest from the tree
      for (const HalfEdge h : leaving[v]) {
        const double through = distance + (mesh.positions[to(h)] - mesh.positions[v]).norm();
        if (through >= distances[to(h)]) continue;
        distances[to(h)] = through;
        arrival[to(h)] = h;
        queue.emplace(through, to(h));
      }
    }
    for (int v = last; arrival[v] >= 0; v = mesh.triangles[arrival[v] / 3][arrival[v] % 3]) {
      const HalfEdge h = arrival[v], twin = surface.twins[h];
      if (twin >= 0) seams[h] = seams[twin] = 1;
      tree.push_back(v);
    }
  }
  return seams;
}

}  // namespace mq
