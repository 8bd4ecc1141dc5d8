// Every length is rounded once, from the positions of its two vertices in the order of their
// indices, so that the two triangles of an edge agree on it to the bit.

#include "mq/evolving/neighbour_graph.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>
#include <unordered_set>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/mesh/surface.h"

namespace mq {
namespace {

constexpr double one = 0x1p40;

/// Areas and lengths of one triangle.
struct Shape {
  double area = 0;
  std::array<double, 3> edges{};
};

Shape shape(const Triangle& t, const std::array<Vector3, 3>& p) {
  Shape s;
  s.area = (p[1] - p[0]).cross(p[2] - p[0]).norm() / 2;
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3;
    s.edges[k] = t[k] < t[l] ? (p[l] - p[k]).norm() : (p[k] - p[l]).norm();
  }
  return s;
}

std::int64_t rounded(double value) { return std::int64_t(std::nearbyint(value * one)); }

std::unordered_set<int> collapsed_triangles(const EvolvingMesh& evolving,
                                            const std::vector<Period>& periods) {
  std::unordered_set<int> ids;
  for (const Period& period : periods) {
    const EvolvingSegment& segment = evolving.segments[period.segment];
    for (int t = 0; t < segment.triangle_count(); ++t) {
      const auto& [a, b, c] = segment.triangles[t];
      if (a == b || b == c || c == a) ids.insert(segment.triangle_ids[t]);
    }
  }
  return ids;
}

}  // namespace

std::vector<Period> periods_of(const EvolvingMesh& evolving) {
  std::vector<Period> periods;
  for (int f = 0; f < int(evolving.frames.size()); ++f) {
    const int segment = evolving.frames[f].segment;
    if (periods.empty() || periods.back().segment != segment) periods.push_back({segment, f, f});
    periods.back().last = f;
  }
  return periods;
}

NeighbourGraph neighbour_graph(const EvolvingMesh& given, const Progress& progress) {
  check(given);
  const EvolvingMesh evolving = on_unit_grid(given);
  const std::vector<Period> periods = periods_of(evolving);
  const std::vector<Lifespan> spans = triangle_lifespans(evolving);
  const auto corners = [&](const EvolvingFrame& frame, const Triangle& t) {
    return std::array{frame.positions[t[0]], frame.positions[t[1]], frame.positions[t[2]]};
  };

  double area = 0;
  std::int64_t triangles = 0;
  for (const EvolvingFrame& frame : evolving.frames) {
    const auto& all = evolving.segments[frame.segment].triangles;
    triangles += std::ssize(all);
    area += parallel_sum(std::ssize(all), 0.0, [&](std::int64_t begin, std::int64_t end) {
      double sum = 0;
      for (std::int64_t t = begin; t < end; ++t) sum += shape(all[t], corners(frame, all[t])).area;
      return sum;
    });
  }
  require(area > 0, "no frame has an area, so there are no charts");
  const double per_area = double(evolving.frames.size()) / area, per_length = std::sqrt(per_area);

  NeighbourGraph graph;
  graph.radius = std::sqrt(4 / (3 * std::sqrt(3.0)) * area / double(triangles)) * per_length;
  std::unordered_map<int, int> chain_of;
  const std::unordered_set<int> collapsed = collapsed_triangles(evolving, periods);
  for (const Lifespan& span : spans) {
    if (collapsed.contains(span.id)) continue;
    chain_of[span.id] = int(graph.chains.size());
    graph.chains.push_back({span.id, -1, {}, {}});
  }
  std::unordered_map<std::uint64_t, int> contact_of;
  for (int i = 0; i < int(periods.size()); ++i) {
    const Period& period = periods[i];
    graph.frame_counts.push_back(period.frame_count());
    const EvolvingSegment& segment = evolving.segments[period.segment];
    struct Sums {
      std::int64_t area = 0;
      std::array<std::int64_t, 3> edges{};
    };
    std::vector<Sums> sums(segment.triangles.size());
    parallel_for(std::ssize(sums), [&](std::int64_t t) {
      for (int f = period.first; f <= period.last; ++f) {
        const Shape s =
            shape(segment.triangles[t], corners(evolving.frames[f], segment.triangles[t]));
        sums[t].area += rounded(s.area * per_area);
        for (int k = 0; k < 3; ++k)
          sums[t].edges[k] += std::max(std::int64_t(1), rounded(s.edges[k] * per_length));
      }
    });
    const Surface surface = make_surface(mesh_of(segment, evolving.frames[period.first].positions),
                                         {.kind = WeldOptions::Kind::none});
    for (int t = 0; t < segment.triangle_count(); ++t) {
      const auto found = chain_of.find(segment.triangle_ids[t]);
      if (found == chain_of.end()) continue;
      const int c = found->second;
      NeighbourGraph::Chain& chain = graph.chains[c];
      if (chain.first < 0) chain.first = i;
      chain.area.push_back(sums[t].area);
      chain.perimeter.push_back(sums[t].edges[0] + sums[t].edges[1] + sums[t].edges[2]);
      for (int k = 0; k < 3; ++k) {
        const HalfEdge h = 3 * t + k, twin = surface.twins[h];
        if (twin < h) continue;  // none, or seen from there
        const int d = chain_of.at(segment.triangle_ids[twin / 3]);
        if (d == c) continue;
        const auto [lower, upper] = std::minmax(c, d);
        const auto [place, is_new] = contact_of.try_emplace(
            std::uint64_t(lower) << 32 | std::uint64_t(upper), int(graph.contacts.size()));
        if (is_new) graph.contacts.push_back({lower, upper, i, {}});
        NeighbourGraph::Contact& contact = graph.contacts[place->second];
        contact.length.resize(i - contact.first + 1);
        contact.length.back() += sums[t].edges[k];
      }
    }
    progress.at(double(i + 1) / double(periods.size()));
  }
  return graph;
}

}  // namespace mq
