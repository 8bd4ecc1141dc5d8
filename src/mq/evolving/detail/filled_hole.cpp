#include "mq/evolving/detail/filled_hole.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

#include "mq/linear/dense.h"

namespace mq {
namespace {

constexpr double most_stretch = 3;
constexpr int most_sweeps = 2000;
constexpr double arrived_part = 1e-9;  // of the box, that the last sweep moved something

/// tan(α/2) of the angle at a corner.
double half_tangent(const Vector3& at, const Vector3& one, const Vector3& other) {
  const Vector3 a = one - at, b = other - at;
  const double lengths = a.norm() * b.norm();
  return a.cross(b).norm() / std::max(lengths + a.dot(b), 1e-12 * lengths + 1e-300);
}

/// Singular values of the map of a triangle from space to the plane; none where it is turned over.
std::optional<Eigen::Vector2d> stretch(const HolePatch& patch, const Triangle& t,
                                       const std::vector<Vector2>& x) {
  const Vector3 e = patch.positions[t[1]] - patch.positions[t[0]],
                f = patch.positions[t[2]] - patch.positions[t[0]];
  const double length = e.norm(), height = e.cross(f).norm() / std::max(length, 1e-300);
  Eigen::Matrix2d before, after;
  before << length, e.dot(f) / std::max(length, 1e-300), 0, height;
  after.col(0) = x[t[1]] - x[t[0]];
  after.col(1) = x[t[2]] - x[t[0]];
  if (!(height > 0) || !(after.determinant() > 0)) return {};
  return Eigen::Vector2d(singular_values(Eigen::Matrix2d(after * before.inverse())).values);
}

}  // namespace

std::optional<std::vector<Vector2>> filled_hole(const HolePatch& patch) {
  std::vector<std::map<int, double>> weights(patch.positions.size());
  for (const Triangle& t : patch.triangles)
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
      const Vector3 &p = patch.positions[a], &q = patch.positions[b], &r = patch.positions[c];
      const double half = half_tangent(p, q, r);
      weights[a][b] += half / std::max((q - p).norm(), 1e-300);
      weights[a][c] += half / std::max((r - p).norm(), 1e-300);
    }
  std::vector<Vector2> x = patch.places;
  Vector2 low = Vector2::Zero(), high = low, middle = low;
  int count = 0;
  for (std::size_t v = 0; v < x.size(); ++v) {
    if (!patch.fixed[v]) continue;
    if (count++ == 0) low = high = x[v];
    low = low.cwiseMin(x[v]), high = high.cwiseMax(x[v]), middle += x[v];
  }
  if (count < 3) return {};
  for (std::size_t v = 0; v < x.size(); ++v)
    if (!patch.fixed[v]) x[v] = middle / count;
  const double size = (high - low).norm();
  double moved = size;
  for (int sweep = 0; sweep < most_sweeps && moved > arrived_part * size; ++sweep) {
    moved = 0;
    for (std::size_t v = 0; v < x.size(); ++v) {
      if (patch.fixed[v]) continue;
      Vector2 sum = Vector2::Zero();
      double all = 0;
      for (const auto& [other, weight] : weights[v]) sum += weight * x[other], all += weight;
      if (!(all > 0)) return {};
      moved = std::max(moved, (sum / all - x[v]).norm());
      x[v] = sum / all;
    }
  }
  for (const Triangle& t : patch.triangles) {
    const auto sigma = stretch(patch, t, x);
    if (!sigma || !((*sigma)[0] < most_stretch) || !((*sigma)[1] > 1 / most_stretch)) return {};
  }
  return x;
}

bool overlap(const std::vector<Vector2>& one, const std::vector<Vector2>& other) {
  double size = 0;
  for (const Vector2& p : one) size = std::max(size, p.cwiseAbs().maxCoeff());
  for (const std::vector<Vector2>* of : {&one, &other})
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector2 edge = (*of)[(k + 1) % 3] - (*of)[k], normal(-edge.y(), edge.x());
      const double slack = 1e-9 * size * edge.norm();
      const auto range = [&](const std::vector<Vector2>& points) {
        const auto [least, most] =
            std::minmax({normal.dot(points[0]), normal.dot(points[1]), normal.dot(points[2])});
        return Vector2(least, most);
      };
      const Vector2 a = range(one), b = range(other);
      if (a[1] <= b[0] + slack || b[1] <= a[0] + slack) return false;
    }
  return true;
}

}  // namespace mq
