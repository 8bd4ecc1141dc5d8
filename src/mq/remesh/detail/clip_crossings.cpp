// Two triangles that are not in one plane cross where an edge of one passes through the other: the
// ends of the edge lie on both sides of the plane, and the volumes of the tetrahedra of the edge
// with the three sides have one sign. Candidates come from a grid over the triangles asked about.

#include "mq/remesh/detail/clip_crossings.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <map>
#include <memory>

#include "mq/base/parallel.h"

namespace mq {
namespace {

double volume(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) {
  return (b - a).cross(c - a).dot(d - a);
}

/// Whether the segment p q passes through the inside of the triangle a b c.
bool passes(const Vector3& p, const Vector3& q, const Vector3& a, const Vector3& b,
            const Vector3& c) {
  const double above = volume(a, b, c, p), below = volume(a, b, c, q);
  if (!((above > 0 && below < 0) || (above < 0 && below > 0))) return false;
  const double u = volume(p, q, a, b), v = volume(p, q, b, c), w = volume(p, q, c, a);
  return (u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0);
}

struct Bounds {
  Vector3 low, high;
  Bounds(const std::vector<Vector3>& positions, const Triangle& t)
      : low(positions[t[0]].cwiseMin(positions[t[1]]).cwiseMin(positions[t[2]])),
        high(positions[t[0]].cwiseMax(positions[t[1]]).cwiseMax(positions[t[2]])) {}
  bool meets(const Bounds& other) const {
    return (low - other.high).maxCoeff() <= 0 && (other.low - high).maxCoeff() <= 0;
  }
};

/// Triangles by the cells of a grid that their boxes cover.
class TriangleGrid {
 public:
  TriangleGrid(const std::vector<Vector3>& positions, std::span<const Triangle> triangles) {
    Vector3 extent = Vector3::Zero();
    for (const Triangle& t : triangles) {
      bounds_.emplace_back(positions, t);
      extent += bounds_.back().high - bounds_.back().low;
    }
    origin_ = bounds_.front().low;
    for (const Bounds& b : bounds_) origin_ = origin_.cwiseMin(b.low);
    cell_ = std::max(2 * extent.maxCoeff() / double(triangles.size()), 1e-300);
    for (std::size_t i = 0; i < bounds_.size(); ++i)
      if (!for_cells(bounds_[i], [&](const Key& key) { cells_[key].push_back(int(i)); }))
        large_.push_back(int(i));
  }

  /// Calls see(i) for triangles whose boxes meet the given one, some more than once.
  template <class See>
  void near(const Bounds& box, const See& see) const {
    const auto consider = [&](int i) {
      if (bounds_[std::size_t(i)].meets(box)) see(i);
    };
    const bool small = for_cells(box, [&](const Key& key) {
      const auto found = cells_.find(key);
      if (found != cells_.end()) std::ranges::for_each(found->second, consider);
    });
    if (small)
      std::ranges::for_each(large_, consider);
    else
      for (int i = 0; i < std::ssize(bounds_); ++i) consider(i);
  }

 private:
  using Key = std::array<long, 3>;

  /// False, and nothing called, where a box covers too many cells.
  template <class Call>
  bool for_cells(const Bounds& box, const Call& call) const {
    constexpr double most = 64;
    const Vector3 low = ((box.low - origin_) / cell_).array().floor();
    const Vector3 high = ((box.high - origin_) / cell_).array().floor();
    double cells = 1;
    for (int k = 0; k < 3; ++k) {
      if (!(std::abs(low[k]) < 1e15 && std::abs(high[k]) < 1e15)) return false;
      cells *= high[k] - low[k] + 1;
    }
    if (cells > most) return false;
    for (long x = long(low.x()); x <= long(high.x()); ++x)
      for (long y = long(low.y()); y <= long(high.y()); ++y)
        for (long z = long(low.z()); z <= long(high.z()); ++z) call(Key{x, y, z});
    return true;
  }

  std::vector<Bounds> bounds_;
  Vector3 origin_;
  double cell_ = 1;
  std::map<Key, std::vector<int>> cells_;
  std::vector<int> large_;
};

}  // namespace

bool cross(const std::vector<Vector3>& positions, const Triangle& first, const Triangle& second) {
  const auto shared = [](const Triangle& t, int v) { return t[0] == v || t[1] == v || t[2] == v; };
  const auto count = std::ranges::count_if(first, [&](int v) { return shared(second, v); });
  if (count > 1) return false;
  const auto one_way = [&](const Triangle& s, const Triangle& t) {
    for (int k = 0; k < 3; ++k) {
      const int a = s[std::size_t(k)], b = s[std::size_t((k + 1) % 3)];
      if (shared(t, a) || shared(t, b)) continue;
      if (passes(positions[a], positions[b], positions[t[0]], positions[t[1]], positions[t[2]]))
        return true;
    }
    return false;
  };
  return one_way(first, second) || one_way(second, first);
}

namespace {

/// Marks the triangles of the grid that one of these crosses.
void mark_crossed(const std::vector<Vector3>& positions, const TriangleGrid& grid,
                  std::span<const Triangle> asked, std::span<const Triangle> others,
                  std::vector<char>& marks) {
  // Several threads may find the same triangle; each only ever writes 1.
  parallel_for(
      std::ssize(others),
      [&](std::int64_t j) {
        const Triangle& t = others[std::size_t(j)];
        grid.near(Bounds(positions, t), [&](int i) {
          std::atomic_ref<char> mark(marks[std::size_t(i)]);
          if (mark.load(std::memory_order_relaxed) == 0 &&
              cross(positions, asked[std::size_t(i)], t))
            mark.store(1, std::memory_order_relaxed);
        });
      },
      256);
}

}  // namespace

std::vector<char> crossed(const std::vector<Vector3>& positions, std::span<const Triangle> asked,
                          std::span<const Triangle> others) {
  std::vector<char> marks(asked.size(), 0);
  if (asked.empty()) return marks;
  const TriangleGrid grid(positions, asked);
  mark_crossed(positions, grid, asked, asked, marks);
  mark_crossed(positions, grid, asked, others, marks);
  return marks;
}

std::vector<char> crossed_by(const std::vector<Vector3>& positions, std::span<const Triangle> asked,
                             std::span<const Triangle> others) {
  std::vector<char> marks(asked.size(), 0);
  if (!asked.empty()) mark_crossed(positions, TriangleGrid(positions, asked), asked, others, marks);
  return marks;
}

}  // namespace mq
