// Boxes are halved where the middles of their triangles are halved along the longest side, once; after that they grow
// and shrink with their triangles. Distances to boxes are exact but for rounding, and what is left out is farther than
// that can be off.

#include "mq/mesh/moving_closest_point.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"

namespace mq {
namespace {

constexpr int most_in_box = 2;   // triangles, in one that is not halved
constexpr int most_pending = 64;  // boxes; halves are as many to one, so that none is so deep
/// Of distances, and of coordinates, that rounding can be off by, and more.
constexpr double rounding_of_distance = 1e-9, rounding_of_place = 1e-12;

}  // namespace

MovingClosestPointFinder::MovingClosestPointFinder(const Mesh& mesh)
    : mesh_(mesh), triangles_(mesh.triangles.size()) {
  require(mesh.triangle_count() > 0, "there is no closest point of a mesh without triangles");
  std::iota(triangles_.begin(), triangles_.end(), 0);
  std::vector<Vector3> middles;
  middles.reserve(triangles_.size());
  for (const int t : triangles_) {
    middles.push_back(mesh.position(t, 0) + mesh.position(t, 1) + mesh.position(t, 2));
    require(middles.back().allFinite(), "the closest point of a mesh needs finite positions");
  }
  nodes_.reserve(2 * triangles_.size());
  divide(0, int(triangles_.size()), middles);
  follow();
}

void MovingClosestPointFinder::divide(int begin, int end, const std::vector<Vector3>& middles) {
  const std::size_t at = nodes_.size();
  nodes_.push_back({.low = {}, .high = {}, .begin = begin, .end = end});
  if (end - begin <= most_in_box) return;
  Vector3 low = middles[triangles_[begin]], high = low;
  for (int i = begin + 1; i < end; ++i) {
    low = low.cwiseMin(middles[triangles_[i]]);
    high = high.cwiseMax(middles[triangles_[i]]);
  }
  int longest = 0;
  (high - low).maxCoeff(&longest);
  const int half = begin + (end - begin) / 2;
  std::nth_element(triangles_.begin() + begin, triangles_.begin() + half, triangles_.begin() + end,
                   [&](int a, int b) { return middles[a][longest] < middles[b][longest]; });
  divide(begin, half, middles);
  nodes_[at].second = int(nodes_.size());
  divide(half, end, middles);
}

void MovingClosestPointFinder::follow() {
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    Node& node = nodes_[i];
    if (node.second > 0) {
      const Node &first = nodes_[i + 1], &second = nodes_[node.second];
      node.low = first.low.cwiseMin(second.low);
      node.high = first.high.cwiseMax(second.high);
      continue;
    }
    node.low = node.high = mesh_.position(triangles_[node.begin], 0);
    for (int j = node.begin; j < node.end; ++j)
      for (int k = 0; k < 3; ++k) {
        const Vector3& p = mesh_.position(triangles_[j], k);
        require(p.allFinite(), "the closest point of a mesh needs finite positions");
        node.low = node.low.cwiseMin(p);
        node.high = node.high.cwiseMax(p);
      }
  }
  farthest_ = std::max(nodes_[0].low.cwiseAbs().maxCoeff(), nodes_[0].high.cwiseAbs().maxCoeff());
}

ClosestPoint MovingClosestPointFinder::closest(const Vector3& point, int guess) const {
  if (!point.allFinite())
    throw InvalidInput(fmt::format("({}, {}, {}) has no closest point", point.x(), point.y(), point.z()));
  ClosestPoint best{{}, std::numeric_limits<double>::infinity()};
  double beyond = best.squared_distance;  // of boxes that do not matter, squared
  const double slack = rounding_of_place * (farthest_ + point.cwiseAbs().maxCoeff());
  const auto consider = [&](int triangle) {
    const ClosestPoint found = closest_point(mesh_, triangle, point);
    const bool closer = found.squared_distance < best.squared_distance;
    if (!closer && !(found.squared_distance == best.squared_distance && triangle < best.triangle)) return;
    best = found;
    if (!closer) return;
    const double radius = (1 + rounding_of_distance) * std::sqrt(best.squared_distance) + slack;
    beyond = radius * radius;
  };
  const auto squared_distance = [&](const Node& node) {
    return (node.low - point).cwiseMax(point - node.high).cwiseMax(0.0).squaredNorm();
  };
  if (guess >= 0 && guess < mesh_.triangle_count()) consider(guess);
  struct Pending {
    int node;
    double squared_distance;
  };
  std::array<Pending, most_pending> pending;
  std::size_t count = 0;
  pending[count++] = {0, squared_distance(nodes_[0])};
  while (count > 0) {
    const Pending next = pending[--count];
    if (next.squared_distance > beyond) continue;
    const Node& node = nodes_[next.node];
    if (node.second > 0) {
      Pending near{next.node + 1, squared_distance(nodes_[next.node + 1])};
      Pending far{node.second, squared_distance(nodes_[node.second])};
      if (far.squared_distance < near.squared_distance) std::swap(near, far);
      if (!(far.squared_distance > beyond)) pending[count++] = far;
      if (!(near.squared_distance > beyond)) pending[count++] = near;
    } else {
      for (int i = node.begin; i < node.end; ++i) consider(triangles_[i]);
    }
  }
  return best;
}

std::vector<ClosestPoint> MovingClosestPointFinder::operator()(std::span<const Vector3> points,
                                                               std::span<const ClosestPoint> guesses) const {
  const bool guessed = guesses.size() == points.size();
  std::vector<ClosestPoint> found(points.size());
  parallel_for(std::ssize(points),
               [&](std::int64_t i) { found[i] = closest(points[i], guessed ? guesses[i].triangle : -1); });
  return found;
}

}  // namespace mq
