/// Triangle a b c with its edge h = a → b and, across, b a d, laid flat with a at the origin and b
/// on the first axis: c above, d below. The flip leaves c a d and d b c, with edge c – d in place
/// of a – b:
///
///     h/3:  d → c, c → a, a → d        twin/3:  c → d, d → b, b → c.
///
/// The new edge leaves c by the angle of the corner c of d c a counter-clockwise from c → a, and d
/// by that of c d b from d → b; angles around a vertex never sum to anything else, so that what
/// they are scaled by stays.

#include "mq/fem/intrinsic_delaunay.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/fem/vertex_frames.h"

namespace mq {

namespace {

/// Edges this much beyond Delaunay stay: |cot α + cot β| of four points on a circle is rounding.
constexpr double slack = 1e-10;

double corner_angle(const FlatTriangle& shape, int k) {
  return std::atan2(0.5, shape.half_cotangent(k));
}

/// What angles around each vertex are scaled by to sum to 2π; 1 at boundaries.
std::vector<double> stretches(const Surface& surface, const std::vector<FlatTriangle>& shapes) {
  std::vector<double> total(surface.mesh.positions.size(), 0.0);
  std::vector<char> open(total.size(), 0);
  const auto ends = [&](HalfEdge h) {
    return surface.twins[h] < 0 || shapes[surface.twins[h] / 3].empty();
  };
  for (HalfEdge h = 0; h < HalfEdge(surface.twins.size()); ++h) {
    if (shapes[h / 3].empty()) continue;
    const int v = surface.mesh.triangles[h / 3][h % 3];
    total[v] += corner_angle(shapes[h / 3], h % 3);
    if (ends(h) || ends(previous(h))) open[v] = 1;
  }
  for (std::size_t v = 0; v < total.size(); ++v)
    total[v] = open[v] || total[v] == 0 ? 1.0 : 2 * std::numbers::pi / total[v];
  return total;
}

class Flipper {
 public:
  Flipper(IntrinsicTriangulation& result)
      : mesh_(result.surface.mesh),
        twins_(result.surface.twins),
        shapes_(result.shapes),
        flips_(result.flips),
        directions_(result.directions),
        stretch_(stretches(result.surface, result.shapes)),
        waiting_(twins_.size(), 0) {
    for (HalfEdge h = 0; h < HalfEdge(twins_.size()); ++h) ask(h);
  }

  void run() {
    const std::int64_t most = 100 * std::int64_t(twins_.size());
    while (!queue_.empty() && flips_ < most) {
      const HalfEdge h = queue_.front();
      queue_.pop_front();
      waiting_[h] = 0;
      if (flippable(h)) flip(h);
    }
  }

 private:
  /// Puts the edge of h into the queue, under its lower half-edge.
  void ask(HalfEdge h) {
    if (twins_[h] < 0) return;
    const HalfEdge lower = std::min(h, twins_[h]);
    if (waiting_[lower]) return;
    waiting_[lower] = 1;
    queue_.push_back(lower);
  }

  const FlatTriangle& shape(HalfEdge h) const { return shapes_[h / 3]; }
  double opposite(HalfEdge h) const { return shape(h).half_cotangent((h % 3 + 2) % 3); }

  bool flippable(HalfEdge h) const {
    const HalfEdge t = twins_[h];
    return t >= 0 && h / 3 != t / 3 && !shape(h).empty() && !shape(t).empty() &&
           opposite(h) + opposite(t) < -slack;
  }

  /// The corner opposite h, with h from the origin along the first axis.
  Vector2 apex(HalfEdge h) const {
    const int k = h % 3;
    const Vector2 edge = shape(h).edge(k), side = shape(h).corner((k + 2) % 3) - shape(h).corner(k);
    return Vector2(edge.dot(side), 2 * shape(h).area()) / edge.norm();
  }

  static FlatTriangle laid(const Vector2& p, const Vector2& q, const Vector2& r) {
    return flat_triangle({q.x() - p.x(), q.y() - p.y(), 0}, {r.x() - p.x(), r.y() - p.y(), 0});
  }

  int source(HalfEdge h) const { return mesh_.triangles[h / 3][h % 3]; }

  void link(HalfEdge h, HalfEdge twin) {
    twins_[h] = twin;
    if (twin >= 0) twins_[twin] = h;
  }

  void flip(HalfEdge h) {
    const HalfEdge t = twins_[h];
    const double length = shape(h).edge(h % 3).norm();
    const Vector2 a(0, 0), b(length, 0), c = apex(h);
    const Vector2 below = apex(t), d(length - below.x(), -below.y());
    const FlatTriangle left = laid(d, c, a), right = laid(c, d, b);
    if (left.empty() || right.empty()) return;
    const int va = source(h), vb = source(t), vc = source(previous(h)), vd = source(previous(t));
    const double from_b = directions_[next(h)], from_c = directions_[previous(h)];
    const double from_a = directions_[next(t)], from_d = directions_[previous(t)];
    // The four outer edges: b → c, c → a, a → d, d → b.
    HalfEdge bc = twins_[next(h)], ca = twins_[previous(h)];
    HalfEdge ad = twins_[next(t)], db = twins_[previous(t)];
    const int l = h / 3, r = t / 3;
    // An outer edge may be glued to another outer edge of the same two triangles.
    const auto moved = [&](HalfEdge old) {
      if (old == next(h)) return 3 * r + 2;
      if (old == previous(h)) return 3 * l + 1;
      if (old == next(t)) return 3 * l + 2;
      if (old == previous(t)) return 3 * r + 1;
      return old;
    };
    bc = moved(bc), ca = moved(ca), ad = moved(ad), db = moved(db);
    mesh_.triangles[l] = {vd, vc, va};
    mesh_.triangles[r] = {vc, vd, vb};
    shapes_[l] = left;
    shapes_[r] = right;
    directions_[3 * l] = from_d + stretch_[vd] * corner_angle(right, 1);
    directions_[3 * l + 1] = from_c;
    directions_[3 * l + 2] = from_a;
    directions_[3 * r] = from_c + stretch_[vc] * corner_angle(left, 1);
    directions_[3 * r + 1] = from_d;
    directions_[3 * r + 2] = from_b;
    link(3 * l, 3 * r);
    link(3 * l + 1, ca);
    link(3 * l + 2, ad);
    link(3 * r + 1, db);
    link(3 * r + 2, bc);
    ++flips_;
    for (const HalfEdge outer : {3 * l + 1, 3 * l + 2, 3 * r + 1, 3 * r + 2}) ask(outer);
  }

  Mesh& mesh_;
  std::vector<HalfEdge>& twins_;
  std::vector<FlatTriangle>& shapes_;
  std::int64_t& flips_;
  std::vector<double>& directions_;
  std::vector<double> stretch_;
  std::vector<char> waiting_;
  std::deque<HalfEdge> queue_;
};

}  // namespace

IntrinsicTriangulation intrinsic_delaunay(const Surface& surface,
                                          const std::vector<FlatTriangle>& shapes) {
  require(int(shapes.size()) == surface.triangle_count(),
          fmt::format("{} shapes were given for {} triangles", shapes.size(),
                      surface.triangle_count()));
  IntrinsicTriangulation result{surface, shapes};
  result.directions = vertex_frames(surface, shapes).at_source;
  Mesh& mesh = result.surface.mesh;
  mesh.uvs.clear(), mesh.corner_uvs.clear(), mesh.textures.clear();
  Flipper(result).run();
  return result;
}

IntrinsicTriangulation intrinsic_delaunay(const Surface& surface) {
  return intrinsic_delaunay(surface, flat_triangles(surface));
}

}  // namespace mq
