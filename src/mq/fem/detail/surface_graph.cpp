/// Sampling: points in order; one that no chosen point has reached is chosen, and reaches others along
/// the graph by Dijkstra's algorithm as far as its radius. A point belongs to the chosen one from
/// which the way is shortest (graph Voronoi cells). Cells are adjacent where an edge of the graph
/// runs between them.

#include "mq/fem/detail/surface_graph.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <queue>

#include <Eigen/Dense>

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
  for (int pass = 0; pass < passes; ++pass) {
    std::atomic<bool> changed = false;
    parallel_for(A.rows(), [&](std::int64_t i) {
      for (SparseMatrix::InnerIterator entry(A, i); entry; ++entry) {
        const int j = int(entry.col());
        if (spacing[j] < next[i])
          next[i] = std::min(next[i], spacing[j] + grading * (point(points, int(i)) - point(points, j)).norm());
      }
      if (next[i] < 0.9f * spacing[i]) changed = true;
    });
    spacing = next;
    if (!changed) break;
  }
  return spacing;
}

Cells sample(const SparseMatrix& A, const SurfacePoints& points, double radius) {
  const int n = int(A.rows());
  Cells cells;
  cells.owner.assign(n, -1);
  std::vector<float> distance(n, std::numeric_limits<float>::infinity());
  using Reached = std::pair<float, int>;
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> queue;
  for (int centre = 0; centre < n; ++centre) {
    if (cells.owner[centre] >= 0) continue;
    const int cell = int(cells.centres.size());
    cells.centres.push_back(centre);
    cells.owner[centre] = cell;
    distance[centre] = 0;
    queue.emplace(0.0f, centre);
    while (!queue.empty()) {
      const auto [way, i] = queue.top();
      queue.pop();
      if (way > distance[i] || cells.owner[i] != cell) continue;
      for (SparseMatrix::InnerIterator entry(A, i); entry; ++entry) {
        const int j = int(entry.col());
        const float to_j = way + (point(points, i) - point(points, j)).norm();
        const float reach = float(radius) * std::min(points.spacing[centre], points.spacing[j]);
        if (to_j > reach || to_j >= distance[j]) continue;
        distance[j] = to_j;
        cells.owner[j] = cell;
        queue.emplace(to_j, j);
      }
    }
  }
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

Adjacency adjacency_of(const SparseMatrix& A, const Cells& cells) {
  const int count = int(cells.centres.size());
  std::vector<int> starts(count + 1, 0), members(cells.owner.size());
  for (const int c : cells.owner) ++starts[c + 1];
  for (int c = 0; c < count; ++c) starts[c + 1] += starts[c];
  std::vector<int> at(starts.begin(), starts.end() - 1);
  for (int i = 0; i < int(cells.owner.size()); ++i) members[at[cells.owner[i]]++] = i;

  std::vector<std::vector<int>> lists(count);
  parallel_for(count, [&](std::int64_t c) {
    std::vector<int>& list = lists[c];
    for (int m = starts[c]; m < starts[c + 1]; ++m)
      for (SparseMatrix::InnerIterator entry(A, members[m]); entry; ++entry)
        if (const int other = cells.owner[entry.col()]; other != c) list.push_back(other);
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  });
  Adjacency result;
  result.starts.assign(count + 1, 0);
  for (int c = 0; c < count; ++c) result.starts[c + 1] = result.starts[c] + int(lists[c].size());
  result.cells.resize(result.starts[count]);
  for (int c = 0; c < count; ++c)
    std::copy(lists[c].begin(), lists[c].end(), result.cells.begin() + result.starts[c]);
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

/// Interpolates point p of cell `own` from the cells around, which are `near`.
Combination interpolate(const Point& p, int own, const SurfacePoints& points, const Cells& cells,
                        const Adjacency& near, const Adjacency& adjacency) {
  const Point origin = point(points, cells.centres[own]), q = p - origin;
  Combination best;
  best.entries[0] = {own, 1};
  if (q.squaredNorm() == 0) return best;

  // The triangle that holds the projection of p and is nearest to it, the smaller at a tie.
  float best_distance = std::numeric_limits<float>::infinity();
  const int* end = near.end(own);
  for (const int* a = near.begin(own); a != end; ++a) {
    const Point u = point(points, cells.centres[*a]) - origin;
    for (const int* b = a + 1; b != end; ++b) {
      if (!adjacency.adjacent(*a, *b)) continue;
      const Point v = point(points, cells.centres[*b]) - origin;
      const float uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), uq = u.dot(q), vq = v.dot(q);
      const float determinant = uu * vv - uv * uv;
      if (!(determinant > 1e-4f * uu * vv)) continue;
      const float s = (vv * uq - uv * vq) / determinant, t = (uu * vq - uv * uq) / determinant;
      if (s < 0 || t < 0 || s + t > 1) continue;
      const float distance = (q - s * u - t * v).norm() + 1e-3f * (u.norm() + v.norm());
      if (distance >= best_distance) continue;
      best_distance = distance;
      best = {3, {{{own, 1 - s - t}, {*a, s}, {*b, t}}}};
    }
  }
  if (best.count == 3) return best;

  // Else the nearest edge of the own cell.
  best_distance = q.norm();
  for (const int* a = near.begin(own); a != end; ++a) {
    const Point u = point(points, cells.centres[*a]) - origin;
    const float uu = u.dot(u);
    if (!(uu > 0)) continue;
    const float s = std::clamp(u.dot(q) / uu, 0.0f, 1.0f);
    const float distance = (q - s * u).norm();
    if (distance >= best_distance) continue;
    best_distance = distance;
    best = {2, {{{own, 1 - s}, {*a, s}, {}}}};
  }
  return best;
}

}  // namespace

GraphCoarsening coarsen_graph(const SparseMatrix& A, const SurfacePoints& given, double radius) {
  const SurfacePoints points{given.positions, graded(A, given), given.kept};
  const Cells cells = sample(A, points, radius);
  const Adjacency adjacency = adjacency_of(A, cells), near = nearest(adjacency, points, cells);
  const int n = int(A.rows()), count = int(cells.centres.size());

  std::vector<Combination> rows(n);
  parallel_for(n, [&](std::int64_t i) {
    rows[i] = interpolate(point(points, int(i)), cells.owner[i], points, cells, near,
                          adjacency);
  });
  std::vector<int> starts(n + 1, 0);
  for (int i = 0; i < n; ++i) starts[i + 1] = starts[i] + rows[i].count;
  std::vector<WeightedIndex> entries(starts[n]);
  for (int i = 0; i < n; ++i)
    std::copy_n(rows[i].entries.begin(), rows[i].count, entries.begin() + starts[i]);

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
