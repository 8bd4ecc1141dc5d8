// Ear clipping in the plane of the mean (Newell) normal n = ½ Σ pᵢ × pᵢ₊₁, whose coordinate with
// the largest |nₖ| is dropped. A corner is an ear when its triangle turns left and holds no other
// corner, its rim included: a corner on the cut would leave triangles without area.
#include "mq/io/detail/polygon.h"

#include <Eigen/Geometry>

#include <utility>

namespace mq {
namespace {

std::vector<Vector2> projected(std::span<const Vector3> corners) {
  Vector3 normal = Vector3::Zero();
  for (std::size_t i = 0; i < corners.size(); ++i)
    normal += (corners[i] - corners[0]).cross(corners[(i + 1) % corners.size()] - corners[0]);
  int dropped = 0;
  normal.cwiseAbs().maxCoeff(&dropped);
  int x = (dropped + 1) % 3, y = (dropped + 2) % 3;
  if (normal[dropped] < 0) std::swap(x, y);
  std::vector<Vector2> points;
  points.reserve(corners.size());
  for (const Vector3& p : corners) points.emplace_back(p[x], p[y]);
  return points;
}

/// Twice the signed area.
double area(const Vector2& a, const Vector2& b, const Vector2& c) {
  return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

class EarClipper {
 public:
  explicit EarClipper(std::vector<Vector2> points)
      : points_(std::move(points)),
        next_(points_.size()),
        previous_(points_.size()),
        ear_(points_.size()) {
    const int n = int(points_.size());
    for (int i = 0; i < n; ++i) {
      next_[i] = (i + 1) % n;
      previous_[i] = (i + n - 1) % n;
    }
  }

  std::vector<Triangle> clip() {
    int left = int(points_.size());
    int at = 0;
    for (int i = 0; i < left; ++i) ear_[i] = is_ear(i);
    std::vector<Triangle> triangles;
    while (left > 3) {
      at = next_ear(at, left);
      triangles.push_back({previous_[at], at, next_[at]});
      const int before = previous_[at], after = next_[at];
      next_[before] = after;
      previous_[after] = before;
      --left;
      ear_[before] = is_ear(before);
      ear_[after] = is_ear(after);
      at = after;
    }
    triangles.push_back({previous_[at], at, next_[at]});
    return triangles;
  }

 private:
  double turn(int i) const { return area(points_[previous_[i]], points_[i], points_[next_[i]]); }

  bool is_ear(int i) const {
    if (!(turn(i) > 0)) return false;
    const Vector2 &a = points_[previous_[i]], &b = points_[i], &c = points_[next_[i]];
    for (int j = next_[next_[i]]; j != previous_[i]; j = next_[j]) {
      const Vector2& p = points_[j];
      if (p == a || p == b || p == c) continue;
      if (area(a, b, p) >= 0 && area(b, c, p) >= 0 && area(c, a, p) >= 0) return false;
    }
    return true;
  }

  /// The first ear from `at` on; where there is none (the polygon crosses itself or has no area),
  /// the first corner that does not turn right, or any.
  int next_ear(int at, int left) const {
    int flat = -1;
    for (int k = 0, i = at; k < left; ++k, i = next_[i]) {
      if (ear_[i]) return i;
      if (flat < 0 && turn(i) >= 0) flat = i;
    }
    return flat < 0 ? at : flat;
  }

  std::vector<Vector2> points_;
  std::vector<int> next_, previous_;
  std::vector<char> ear_;
};

}  // namespace

std::vector<Triangle> triangulate(std::span<const Vector3> corners) {
  const int n = int(corners.size());
  std::vector<Triangle> fan;
  for (int i = 2; i < n; ++i) fan.push_back({0, i - 1, i});
  if (n <= 3) return fan;

  std::vector<Vector2> points = projected(corners);
  bool fits = true;
  for (const Triangle& t : fan) fits = fits && area(points[t[0]], points[t[1]], points[t[2]]) > 0;
  if (fits || n > max_polygon) return fan;
  return EarClipper(std::move(points)).clip();
}

}  // namespace mq
