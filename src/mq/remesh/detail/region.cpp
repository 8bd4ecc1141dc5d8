// Every call of `mark` makes a mesh of what is new and a hierarchy over it, so that the cost of
// growing by little is little.

#include "mq/remesh/detail/region.h"

#include <cmath>
#include <limits>

#include "mq/base/parallel.h"
#include "mq/mesh/geometry.h"

namespace mq {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// Triangles all of whose corners are marked, edges and points of the others as triangles without
/// area.
Mesh spanned(const SurfacePair& pair, const std::vector<char>& marked,
             const std::vector<char>& fresh) {
  Mesh mesh;
  mesh.positions = pair.mesh.positions;
  std::vector<char> covered(marked.size(), 0);
  for (const auto& [a, b, c] : pair.mesh.triangles) {
    if (!(fresh[a] || fresh[b] || fresh[c])) continue;
    if (marked[a] && marked[b] && marked[c]) {
      mesh.triangles.push_back({a, b, c});
      covered[a] = covered[b] = covered[c] = 1;
      continue;
    }
    for (const auto& [i, j] : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}})
      if (marked[i] && marked[j]) {
        mesh.triangles.push_back({i, j, j});
        covered[i] = covered[j] = 1;
      }
  }
  for (std::size_t v = 0; v < marked.size(); ++v)
    if (fresh[v] && !covered[v]) mesh.triangles.push_back({int(v), int(v), int(v)});
  return mesh;
}

}  // namespace

double MarkedRegion::Piece::distance(const Vector3& point) const {
  return farther + std::sqrt((*finder)(point).squared_distance);
}

void MarkedRegion::mark(const SurfacePair& pair, const std::vector<char>& marked,
                        const std::vector<char>& fresh, double farther) {
  auto piece = std::make_unique<Piece>();
  piece->farther = farther;
  piece->mesh = spanned(pair, marked, fresh);
  follow(pair);
  if (piece->mesh.triangles.empty()) return;
  const Box box = bounding_box(piece->mesh);
  piece->low = box.low - Vector3::Constant(2 * radius_);
  piece->high = box.high + Vector3::Constant(2 * radius_);
  piece->finder = std::make_unique<ClosestPointFinder>(piece->mesh);
  pieces_.push_back(std::move(piece));
  parallel_for(
      pair.mesh.vertex_count(),
      [&](std::int64_t v) {
        const Vector3& point = pair.mesh.positions[std::size_t(v)];
        const Piece& last = *pieces_.back();
        if ((point - last.low).minCoeff() < 0 || (last.high - point).minCoeff() < 0) return;
        double& distance = distances_[std::size_t(v)];
        distance = std::min(distance, last.distance(point));
      },
      256);
}

void MarkedRegion::follow(const SurfacePair& pair) {
  const std::size_t before = distances_.size();
  distances_.resize(pair.mesh.positions.size(), infinite);
  for (std::size_t v = before; v < distances_.size(); ++v)
    distances_[v] = (*this)(pair.mesh.positions[v]);
}

double MarkedRegion::operator()(const Vector3& point) const {
  double distance = infinite;
  for (const auto& piece : pieces_) distance = std::min(distance, piece->distance(point));
  return distance;
}

std::vector<char> spread_seeds(const SurfacePair& pair, const std::vector<double>& scores,
                               double keep) {
  std::vector<char> marked(scores.size(), 0);
  for (std::size_t v = 0; v < scores.size(); ++v) marked[v] = scores[v] > 1;
  std::vector<int> first(scores.size() + 1, 0), around(3 * pair.mesh.triangles.size());
  for (const Triangle& t : pair.mesh.triangles)
    for (const int v : t) ++first[std::size_t(v) + 1];
  for (std::size_t v = 0; v < scores.size(); ++v) first[v + 1] += first[v];
  std::vector<int> place(first.begin(), first.end() - 1);
  for (int t = 0; t < pair.mesh.triangle_count(); ++t)
    for (const int v : pair.mesh.triangles[t]) around[std::size_t(place[std::size_t(v)]++)] = t;

  std::vector<int> front;
  for (std::size_t v = 0; v < scores.size(); ++v)
    if (marked[v]) front.push_back(int(v));
  while (!front.empty()) {
    const int v = front.back();
    front.pop_back();
    for (int i = first[std::size_t(v)]; i < first[std::size_t(v) + 1]; ++i)
      for (const int w : pair.mesh.triangles[around[std::size_t(i)]])
        if (!marked[std::size_t(w)] && scores[std::size_t(w)] > keep) {
          marked[std::size_t(w)] = 1;
          front.push_back(w);
        }
  }
  return marked;
}

}  // namespace mq
