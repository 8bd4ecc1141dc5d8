// Boxes in the order of falling height go to the lowest, leftmost place on the skyline of those
// before; the scale is found by bisection.

#include "mq/sample/pack.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "mq/base/error.h"

namespace mq {
namespace {

struct Rectangle {
  Vector2 low, size;  // of the turned chart, in its own units
  double angle = 0;
};

Vector2 turned(const Vector2& p, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * p.x() - s * p.y(), s * p.x() + c * p.y()};
}

Rectangle box_of(const std::vector<Vector2>& points, double angle) {
  Vector2 low = Vector2::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Vector2& p : points) {
    low = low.cwiseMin(turned(p, angle));
    high = high.cwiseMax(turned(p, angle));
  }
  return {low, high - low, angle};
}

/// Of 90 angles the one with the smallest box, lying.
Rectangle smallest_box(const std::vector<Vector2>& points) {
  const double right = std::numbers::pi / 2;
  Rectangle best = box_of(points, 0);
  for (int k = 1; k < 90; ++k) {
    const Rectangle box = box_of(points, right * k / 90);
    if (box.size.prod() < best.size.prod() * (1 - 1e-9)) best = box;
  }
  return best.size.x() >= best.size.y() ? best : box_of(points, best.angle + right);
}

/// The upper border of what is placed: steps from left to right.
class Skyline {
 public:
  explicit Skyline(double side) : side_(side), steps_{{0, 0, side}} {}

  /// Lower left corner of the lowest place for the box; false if there is none.
  bool place(const Vector2& size, Vector2& corner) {
    double best = std::numeric_limits<double>::infinity();
    std::size_t at = steps_.size();
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      if (steps_[i].x + size.x() > side_) break;
      const double y = height(i, size.x());
      if (y + size.y() <= side_ && y < best) best = y, at = i;
    }
    if (at == steps_.size()) return false;
    corner = {steps_[at].x, best};
    raise(at, size.x(), best + size.y());
    return true;
  }

 private:
  struct Step {
    double x, y, width;
  };

  double height(std::size_t i, double width) const {
    double y = 0;
    for (double covered = 0; covered < width && i < steps_.size(); ++i) {
      y = std::max(y, steps_[i].y);
      covered += steps_[i].width;
    }
    return y;
  }

  void raise(std::size_t at, double width, double y) {
    const double begin = steps_[at].x, end = begin + width;
    std::size_t last = at;
    while (last < steps_.size() && steps_[last].x + steps_[last].width <= end) ++last;
    if (last < steps_.size()) {
      steps_[last].width -= end - steps_[last].x;
      steps_[last].x = end;
    }
    steps_.erase(steps_.begin() + std::ptrdiff_t(at), steps_.begin() + std::ptrdiff_t(last));
    steps_.insert(steps_.begin() + std::ptrdiff_t(at), {begin, y, width});
  }

  double side_;
  std::vector<Step> steps_;
};

/// Corners, in texels, of boxes of `scale` times their size; empty if they do not fit.
std::vector<Vector2> place_all(const std::vector<Rectangle>& boxes, const std::vector<int>& order,
                               double scale, double side, double gutter) {
  Skyline skyline(side);
  std::vector<Vector2> corners(boxes.size());
  for (const int c : order) {
    const Vector2 size = boxes[c].size * scale + Vector2::Constant(gutter);
    if (!skyline.place(size, corners[c])) return {};
  }
  return corners;
}

}  // namespace

void pack(Mesh& mesh, const std::vector<int>& charts, const PackOptions& options) {
  require(options.texture_size >= 1, "a texture needs at least one texel");
  const int count = charts.empty() ? 0 : *std::max_element(charts.begin(), charts.end()) + 1;
  if (count == 0) return;
  std::vector<std::vector<Vector2>> points(count);
  std::vector<int> owner(mesh.uvs.size(), -1);
  for (int t = 0; t < mesh.triangle_count(); ++t)
    for (const int uv : mesh.corner_uvs[t])
      if (owner[uv] < 0) {
        owner[uv] = charts[t];
        points[charts[t]].push_back(mesh.uvs[uv]);
      }
  std::vector<Rectangle> boxes;
  std::vector<int> order;
  double area = 0;
  for (const auto& chart : points) {
    order.push_back(int(boxes.size()));
    boxes.push_back(smallest_box(chart));
    area += boxes.back().size.prod();
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return boxes[a].size.y() > boxes[b].size.y(); });

  const double side = options.texture_size;
  double gutter = std::min(options.gutter, side / 4);
  while (double(count) * gutter * gutter > side * side / 4) gutter /= 2;
  double low = 0, high = 1.01 * side / std::sqrt(area);
  std::vector<Vector2> corners;
  for (int k = 0; k < 40 || corners.empty(); ++k) {
    const double middle = (low + high) / 2;
    if (auto found = place_all(boxes, order, middle, side, gutter); !found.empty()) {
      low = middle;
      corners = std::move(found);
    } else {
      high = middle;
    }
  }
  for (std::size_t i = 0; i < mesh.uvs.size(); ++i) {
    if (owner[i] < 0) continue;
    const Rectangle& box = boxes[owner[i]];
    mesh.uvs[i] = ((turned(mesh.uvs[i], box.angle) - box.low) * low + corners[owner[i]] +
                   Vector2::Constant(gutter / 2)) / side;
  }
}

}  // namespace mq
