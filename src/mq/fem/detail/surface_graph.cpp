/// Sampling: points in order; one that no chosen point has reached is chosen, and reaches others along
/// the graph by Dijkstra's algorithm as far as its radius. A point belongs to the chosen one from
/// which the way is shortest (graph Voronoi cells). Cells are adjacent where an edge of the graph
/// runs between them. Of very many points consecutive ones are sampled by themselves, so that threads can do it side by
/// side; a cell more for every fifty, where they meet, is the price.

#include "mq/fem/detail/surface_graph.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <queue>
#include <span>

#include <Eigen/Dense>

#include "mq/base/inverse_lists.h"
#include "mq/base/parallel.h"

namespace mq {

namespace {

using Point = Eigen::Vector3f;

constexpr std::ptrdiff_t most_kept = 10;  // one of so many points; where there are more, none is

Point point(const SurfacePoints& points, int i) {
  return Eigen::Map<const Point>(points.positions[i].data());
}

/// Chosen points and the cell each point belongs to.
struct Cells {
  std::vector<int> centres;
  std::vector<int> owner;
};

/// The spacings, nowhere larger than `grading` times the way from a point added to that point's. Where
/// two charts meet whose texels differ in size, waves that only the finer one can tell apart reach into
/// the other: its points must stay close there until those of the finer one have grown as far apart.
std::vector<float> graded(const SparseMatrix& A, const SurfacePoints& points) {
  constexpr float grading = 0.5f;
  constexpr int passes = 6;  // points on the way from one spacing to another
  std::vector<float> spacing = points.spacing, next = spacing;
  std::vector<char> open(spacing.size(), 1);  // points beside one whose spacing has changed
  for (int pass = 0; pass < passes; ++pass) {
    std::atomic<bool> changed = false;
    parallel_for(A.rows(), [&](std::int64_t i) {
      if (!open[i]) return;
      for (SparseMatrix::InnerIterator entry(A, i); entry; ++entry) {
        const int j = int(entry.col());
        if (spacing[j] < next[i])
          next[i] = std::min(next[i], spacing[j] + grading * (point(points, int(i)) - point(points, j)).norm());
      }
      if (next[i] < 0.9f * spacing[i]) changed = true;
    });
    std::ranges::fill(open, 0);
    for (std::size_t i = 0; i < next.size(); ++i) {
      if (next[i] == spacing[i]) continue;
      spacing[i] = next[i];
      for (SparseMatrix::InnerIterator entry(A, Eigen::Index(i)); entry; ++entry) open[entry.col()] = 1;
    }
    if (!changed) break;
  }
  return spacing;
}

constexpr int sampled_at_once = 1 << 18;

/// Samples points `begin` … `end` − 1. Their owners are counted from the first centre that is returned.
std::vector<int> sample_some(const SparseMatrix& A, const SurfacePoints& points, double radius, int begin, int end,
                             std::vector<int>& owner) {
  std::vector<int> centres;
  std::vector<float> distance(std::size_t(end - begin), std::numeric_limits<float>::infinity());
  const auto way_to = [&](int i) -> float& { return distance[std::size_t(i - begin)]; };
  using Reached = std::pair<float, int>;
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> queue;
  for (int centre = begin; centre < end; ++centre) {
    if (owner[centre] >= 0) continue;
    const int cell = int(centres.size());
    centres.push_back(centre);
    owner[centre] = cell;
    way_to(centre) = 0;
    queue.emplace(0.0f, centre);
    while (!queue.empty()) {
      const auto [way, i] = queue.top();
      queue.pop();
      if (way > way_to(i) || owner[i] != cell) continue;
      for (SparseMatrix::InnerIterator entry(A, i); entry; ++entry) {
        const int j = int(entry.col());
        if (j < begin || j >= end) continue;
        const float to_j = way + (point(points, i) - point(points, j)).norm();
        const float reach = float(radius) * std::min(points.spacing[centre], points.spacing[j]);
        if (to_j > reach || to_j >= way_to(j)) continue;
        way_to(j) = to_j;
        owner[j] = cell;
        queue.emplace(to_j, j);
      }
    }
  }
  return centres;
}

Cells sample(const SparseMatrix& A, const SurfacePoints& points, double radius) {
  const int n = int(A.rows());
  Cells cells;
  cells.owner.assign(n, -1);
  std::vector<std::vector<int>> centres(n / sampled_at_once + 1);
  parallel_blocks(n, sampled_at_once, [&](std::int64_t begin, std::int64_t end) {
    centres[begin / sampled_at_once] = sample_some(A, points, radius, int(begin), int(end), cells.owner);
  });
  std::vector<int> before(1, 0);
  for (const auto& some : centres) {
    before.push_back(before.back() + int(some.size()));
    cells.centres.insert(cells.centres.end(), some.begin(), some.end());
  }
  parallel_for(n, [&](std::int64_t i) { cells.owner[i] += before[i / sampled_at_once]; });
  return cells;
}

/// Sorted neighbours of every cell, as compressed lists.
struct Adjacency {
  std::vector<int> starts;
  std::vector<int> cells;

  const int* begin(int cell) const { return cells.data() + starts[cell]; }
  const int* end(int cell) const { return cells.data() + starts[cell + 1]; }
  bool adjacent(int a, int b) const { return std::binary_search(begin(a), end(a), b); }
};

/// The points of every cell.
class Members {
 public:
  explicit Members(const Cells& cells)
      : lists_(inverse_lists<int>(std::ssize(cells.owner), std::ssize(cells.centres),
                                  [&](std::int64_t i, const auto& name) { name(cells.owner[i], int(i)); })) {}

  std::span<const int> of(std::int64_t cell) const {
    return {lists_.items.data() + lists_.starts[cell], std::size_t(lists_.starts[cell + 1] - lists_.starts[cell])};
  }

 private:
  InverseLists<int> lists_;
};

Adjacency adjacency_of(const SparseMatrix& A, const Cells& cells, const Members& members) {
  constexpr std::size_t few = 16;  // are faster looked through than sorted
  const int count = int(cells.centres.size());
  std::vector<std::vector<int>> lists(count);
  parallel_for(count, [&](std::int64_t c) {
    thread_local std::vector<int> list;
    list.clear();
    for (const int member : members.of(c))
      for (SparseMatrix::InnerIterator entry(A, member); entry; ++entry) {
        const int other = cells.owner[entry.col()];
        if (other == c) continue;
        const bool known = list.size() <= few && std::ranges::find(list, other) != list.end();
        if (!known) list.push_back(other);
      }
    std::sort(list.begin(), list.end());
    lists[c].assign(list.begin(), std::unique(list.begin(), list.end()));
  });
  Adjacency result;
  result.starts.assign(count + 1, 0);
  for (int c = 0; c < count; ++c) result.starts[c + 1] = result.starts[c] + int(lists[c].size());
  result.cells.resize(result.starts[count]);
  parallel_for(count, [&](std::int64_t c) {
    std::copy(lists[c].begin(), lists[c].end(), result.cells.begin() + result.starts[c]);
  });
  return result;
}

/// Where charts are crumbs that share texels a cell has thousands of neighbours, and pairs of them
/// are millions; what is farther than so many does not hold the point.
constexpr int most_neighbours = 48;

/// Of every cell's neighbours those whose centres are nearest to its own, in order of their numbers.
Adjacency nearest(const Adjacency& all, const SurfacePoints& points, const Cells& cells) {
  const int count = int(cells.centres.size());
  Adjacency result;
  result.starts.assign(count + 1, 0);
  for (int c = 0; c < count; ++c)
    result.starts[c + 1] =
        result.starts[c] + std::min(most_neighbours, all.starts[c + 1] - all.starts[c]);
  result.cells.resize(result.starts[count]);
  parallel_for(count, [&](std::int64_t c) {
    const int kept = result.starts[c + 1] - result.starts[c];
    std::vector<int> list(all.begin(int(c)), all.end(int(c)));
    if (kept < int(list.size())) {
      const Point origin = point(points, cells.centres[c]);
      std::vector<std::pair<float, int>> ways;
      for (const int other : list)
        ways.emplace_back((point(points, cells.centres[other]) - origin).squaredNorm(), other);
      std::ranges::nth_element(ways, ways.begin() + kept);
      for (int k = 0; k < kept; ++k) list[k] = ways[k].second;
      list.resize(kept);
      std::ranges::sort(list);
    }
    std::ranges::copy(list, result.cells.begin() + result.starts[c]);
  });
  return result;
}

/// A combination of up to three cells.
struct Combination {
  int count = 1;
  std::array<WeightedIndex, 3> entries;
};

/// What the points of one cell are interpolated from: its edges to the cells near it, and the triangles with two
/// of them that are adjacent.
class Surroundings {
 public:
  void start(int own, const SurfacePoints& points, const Cells& cells, const Adjacency& near,
             const Adjacency& adjacency) {
    own_ = own;
    origin_ = point(points, cells.centres[own]);
    edges_.clear();
    triangles_.clear();
    for (const int* a = near.begin(own); a != near.end(own); ++a) {
      const Point u = point(points, cells.centres[*a]) - origin_;
      edges_.push_back({*a, u, u.dot(u), u.norm()});
    }
    for (std::size_t a = 0; a < edges_.size(); ++a)
      for (std::size_t b = a + 1; b < edges_.size(); ++b) {
        const Edge &u = edges_[a], &v = edges_[b];
        if (!adjacency.adjacent(u.cell, v.cell)) continue;
        const float uv = u.way.dot(v.way), determinant = u.squared * v.squared - uv * uv;
        if (determinant > 1e-4f * u.squared * v.squared) triangles_.push_back({int(a), int(b), uv, determinant});
      }
  }

  Combination interpolate(const Point& p) const {
    const Point q = p - origin_;
    Combination best;
    best.entries[0] = {own_, 1};
    if (q.squaredNorm() == 0) return best;

    // The triangle that holds the projection of p and is nearest to it, the smaller at a tie.
    float best_distance = std::numeric_limits<float>::infinity();
    for (const Triangle& triangle : triangles_) {
      const Edge &u = edges_[triangle.a], &v = edges_[triangle.b];
      const float uq = u.way.dot(q), vq = v.way.dot(q);
      const float s = (v.squared * uq - triangle.uv * vq) / triangle.determinant,
                  t = (u.squared * vq - triangle.uv * uq) / triangle.determinant;
      if (s < 0 || t < 0 || s + t > 1) continue;
      const float distance = (q - s * u.way - t * v.way).norm() + 1e-3f * (u.length + v.length);
      if (distance >= best_distance) continue;
      best_distance = distance;
      best = {3, {{{own_, 1 - s - t}, {u.cell, s}, {v.cell, t}}}};
    }
    if (best.count == 3) return best;

    // Else the nearest edge of the own cell.
    best_distance = q.norm();
    for (const Edge& u : edges_) {
      if (!(u.squared > 0)) continue;
      const float s = std::clamp(u.way.dot(q) / u.squared, 0.0f, 1.0f);
      const float distance = (q - s * u.way).norm();
      if (distance >= best_distance) continue;
      best_distance = distance;
      best = {2, {{{own_, 1 - s}, {u.cell, s}, {}}}};
    }
    return best;
  }

 private:
  struct Edge {
    int cell;
    Point way;  ///< from the own cell's centre
    float squared, length;
  };
  struct Triangle {
    int a, b;  ///< edges
    float uv, determinant;
  };

  int own_ = 0;
  Point origin_;
  std::vector<Edge> edges_;
  std::vector<Triangle> triangles_;
};

}  // namespace

SurfacePoints in_own_unit(SurfacePoints points) {
  float largest = 0;
  for (const float spacing : points.spacing)
    if (std::isfinite(spacing)) largest = std::max(largest, spacing);
  if (!(largest > 0)) return points;
  const int power = -std::ilogb(largest);
  parallel_for(std::ssize(points.spacing), [&](std::int64_t i) {
    points.spacing[i] = std::ldexp(points.spacing[i], power);
    for (float& x : points.positions[i]) x = std::ldexp(x, power);
  });
  return points;
}

GraphCoarsening coarsen_graph(const SparseMatrix& A, const SurfacePoints& given, double radius) {
  const SurfacePoints points{given.positions, graded(A, given), given.kept};
  const Cells cells = sample(A, points, radius);
  const Members members(cells);
  const Adjacency adjacency = adjacency_of(A, cells, members), near = nearest(adjacency, points, cells);
  const int n = int(A.rows()), count = int(cells.centres.size());

  std::vector<Combination> rows(n);
  parallel_blocks(count, 256, [&](std::int64_t begin, std::int64_t end) {
    Surroundings around;
    for (std::int64_t c = begin; c < end; ++c) {
      around.start(int(c), points, cells, near, adjacency);
      for (const int i : members.of(c)) rows[i] = around.interpolate(point(points, i));
    }
  });
  std::vector<int> starts(n + 1, 0);
  for (int i = 0; i < n; ++i) starts[i + 1] = starts[i] + rows[i].count;
  std::vector<WeightedIndex> entries(starts[n]);
  parallel_for(
      n, [&](std::int64_t i) { std::copy_n(rows[i].entries.begin(), rows[i].count, entries.begin() + starts[i]); });

  GraphCoarsening result;
  result.transfer = std::make_unique<SparseTransfer>(std::move(starts), std::move(entries), count);
  result.coarse.positions.resize(count);
  result.coarse.spacing.resize(count);
  const bool keeps = std::ranges::count(points.kept, 1) * most_kept > 0 &&
                     std::ranges::count(points.kept, 1) * most_kept <= count;
  if (keeps) result.coarse.kept.resize(count);
  for (int c = 0; c < count; ++c) {
    result.coarse.positions[c] = points.positions[cells.centres[c]];
    const bool kept = keeps && points.kept[cells.centres[c]];
    result.coarse.spacing[c] = (kept ? 1 : float(radius)) * points.spacing[cells.centres[c]];
    if (keeps) result.coarse.kept[c] = kept;
  }
  return result;
}

}  // namespace mq
