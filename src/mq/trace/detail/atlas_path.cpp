#include "mq/trace/detail/atlas_path.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "mq/trace/detail/atlas_borders.h"

namespace mq::walk {
namespace {

/// So near to a border a point is on it, texels.
constexpr double on_border = 1e-9;

/// A half-edge seen from the cells it runs through: the triangle beside a stretch of it that begins at some s, and where
/// that stretch ends.
struct Stretch {
  int triangle = -1;  ///< none: the texture ends
  double end = 0;
};

/// What happens on one side of a border.
struct Beside {
  int triangle = -1;
  double inward = 0;   ///< speed away from the border into the chart, on the surface
  double forward = 0;  ///< rate of s, of the part of X along the border
  double speed = 0;
};

class OnBorder {
 public:
  explicit OnBorder(const AtlasFlow& flow)
      : flow_(flow), domain_(flow.domain()), borders_(domain_.borders()) {}

  /// From s along half-edge h, forwards or backwards (±1).
  Stretch stretch(HalfEdge h, double s, int direction) const {
    const Vector2 from = borders_.source(h), edge = borders_.edge(h);
    Stretch found{-1, direction > 0 ? 1.0 : 0.0};
    const auto nearer = [&](double end) {
      if (direction > 0 ? end < found.end : end > found.end) found.end = end;
    };
    for (int axis = 0; axis < 2; ++axis) {
      const double at = from[axis] + s * edge[axis], way = edge[axis] * direction;
      if (way > 0) nearer((std::floor(at + on_border) + 1 - from[axis]) / edge[axis]);
      if (way < 0) nearer((std::ceil(at - on_border) - 1 - from[axis]) / edge[axis]);
    }
    // A hair inside, as a border may be a line between cells.
    const Vector2 inside = on_border / edge.norm() * borders_.turn(h) * Vector2(-edge.y(), edge.x());
    const Vector2 middle = from + 0.5 * (s + found.end) * edge + inside;
    const int column = int(std::floor(middle.x())), row = int(std::floor(middle.y()));
    const int cell = domain_.cell(borders_.texture(h), column, row);
    if (cell < 0) return found;
    // The diagonal is where `beside` is 0, positive on the side of triangle s = 0 or 1.
    const bool other = domain_.diagonal(cell) == 1;
    const auto beside = [&](double part) {
      const Vector2 p = from + part * edge + inside - Vector2(column, row);
      return other ? 1 - p.x() - p.y() : p.x() - p.y();
    };
    const double begins = beside(s), ends = beside(found.end);
    if (std::abs(begins) > on_border && std::abs(ends) > on_border && (begins > 0) != (ends > 0))
      found.end = s + (found.end - s) * begins / (begins - ends);
    found.triangle = 2 * cell + (beside(0.5 * (s + found.end)) > 0 ? 0 : 1);
    return found;
  }

  Beside beside(HalfEdge h, int triangle) const {
    Beside found;
    if (triangle < 0 || !domain_.covered(triangle >> 1)) return found;
    found.triangle = triangle;
    const TexelSpace::CellMetric& G = domain_.metric(triangle >> 1);
    const Vector2 X = flow_.velocity(triangle), edge = borders_.edge(h);
    const Vector2 normal = borders_.turn(h) * Vector2(-edge.y(), edge.x());
    const double length = borders_.length(h);
    found.inward = normal.dot(X) / std::sqrt(G.xx * normal.x() * normal.x() + 2 * G.xy * normal.x() * normal.y() +
                                             G.yy * normal.y() * normal.y());
    found.forward = G.product(X, edge) / (length * length);
    found.speed = std::sqrt(std::max(0.0, G.product(X, X)));
    return found;
  }

  /// What a path at s of h can do on the stretch that follows in a direction.
  struct Choice {
    Beside here, there;
    HalfEdge across = -1;
    double end = 0;   ///< of the stretch
    double rate = 0;  ///< of s, where it slides; 0: it does not
  };
  Choice choice(HalfEdge h, double s, int direction) const {
    Choice found;
    const Stretch near = stretch(h, s, direction);
    found.here = beside(h, near.triangle);
    found.end = near.end;
    found.across = borders_.across(h);
    double share = 1;
    if (found.across >= 0) {
      const Stretch far = stretch(found.across, 1 - s, -direction);
      found.there = beside(found.across, far.triangle);
      found.end = direction > 0 ? std::min(found.end, 1 - far.end) : std::max(found.end, 1 - far.end);
      const double here = std::max(0.0, -found.here.inward), there = std::max(0.0, -found.there.inward);
      share = here + there > 0 ? there / (here + there) : 0.5;
      if (found.there.triangle < 0) share = 1;
      if (found.here.triangle < 0) share = 0;
    }
    if (found.here.inward <= 0 && found.there.inward <= 0) {
      const double rate = share * found.here.forward - (1 - share) * found.there.forward;
      if (rate * direction > 0) found.rate = rate;
    }
    return found;
  }

  /// The place of s on h in a triangle that it runs through.
  void enter(AtlasPath& path, HalfEdge h, double s, int triangle) const;
  bool slide(AtlasPath& path, const Choice& choice, int direction) const;
  bool advance(AtlasPath& path, PathCounts& counts) const;
  bool leave_vertex(AtlasPath& path, PathCounts& counts) const;

 private:
  struct Departure {
    double speed = 0;
    HalfEdge half_edge = -1;  ///< into the triangle at its source, or along it
    int triangle = -1;        ///< of the lattice; −1: along the half-edge
    int direction = 0;
  };
  template <class Visit>
  void for_each_corner(HalfEdge out, const Visit& visit) const;
  Departure into_corner(HalfEdge out) const;
  Departure along(HalfEdge h, int direction) const;

  const AtlasFlow& flow_;
  const TraceAtlas& domain_;
  const AtlasBorders& borders_;
};

void set_weights(const AtlasFlow& flow, AtlasPath& path, int triangle, const Vector2& p) {
  const Vector2 origin = flow.corner(triangle, 0), to = p - origin;
  const double first = std::clamp(to.dot(flow.corner(triangle, 1) - origin), 0.0, 1.0),
               second = std::clamp(to.dot(flow.corner(triangle, 2) - origin), 0.0, 1.0);
  const double sum = std::max(1.0, first + second);
  path.triangle = triangle;
  path.b = {std::max(0.0, 1 - first / sum - second / sum), first / sum, second / sum};
}

void OnBorder::enter(AtlasPath& path, HalfEdge h, double s, int triangle) const {
  const Vector2 texel = borders_.at(h, s);
  const int column = int(std::floor(texel.x())), row = int(std::floor(texel.y()));
  Vector2 p = texel - Vector2(column, row);
  // On a line between cells it may be the one beside.
  for (const auto& [dx, dy] : {std::pair{0, 0}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}})
    if (domain_.cell(borders_.texture(h), column + dx, row + dy) == triangle >> 1) {
      p = (p - Vector2(dx, dy)).cwiseMax(0.0).cwiseMin(1.0);
      break;
    }
  set_weights(flow_, path, triangle, p);
  path.on = Path::On::face;
  path.corner = 0;
  path.chart = borders_.chart(h);
  path.border = -1;
  // From a node it may go into any triangle around.
  for (int k = 0; k < 3; ++k)
    if (path.b[std::size_t(k)] > 1 - on_border) {
      put_at_vertex(path, triangle, k);
      path.entered = true;
    }
}

/// Along the stretch. False when the path is at its end.
bool OnBorder::slide(AtlasPath& path, const Choice& choice, int direction) const {
  const double time = (choice.end - path.s) / choice.rate;
  if (path.left <= time) {
    path.s = std::clamp(path.s + choice.rate * path.left, 0.0, 1.0);
    return false;
  }
  path.left -= std::max(0.0, time);
  path.s = choice.end;
  path.direction = direction;
  return true;
}

bool OnBorder::advance(AtlasPath& path, PathCounts& counts) const {
  if (path.s <= 0 || path.s >= 1) return leave_vertex(path, counts);
  ++counts.edges;
  const int first = path.direction != 0 ? path.direction : 1;
  const std::array<int, 2> directions{first, -first};
  const std::array<Choice, 2> choices{choice(path.border, path.s, first), choice(path.border, path.s, -first)};
  // Into the side that leads away; where a new stretch begins, if it leads into that.
  double fastest = 0;
  HalfEdge into = -1;
  int triangle = -1;
  for (const std::size_t n : {std::size_t(0), std::size_t(1)}) {
    const Choice &c = choices[n], &other = choices[1 - n];
    if (c.here.inward > 0 && faster(c.here.speed, fastest) &&
        (c.here.triangle == other.here.triangle || c.here.forward * directions[n] >= 0)) {
      fastest = c.here.speed, into = path.border, triangle = c.here.triangle;
    }
    if (c.there.inward > 0 && faster(c.there.speed, fastest) &&
        (c.there.triangle == other.there.triangle || -c.there.forward * directions[n] >= 0)) {
      fastest = c.there.speed, into = c.across, triangle = c.there.triangle;
    }
  }
  if (into >= 0) {
    enter(path, into, into == path.border ? path.s : 1 - path.s, triangle);
    return true;
  }
  for (const std::size_t n : {std::size_t(0), std::size_t(1)})
    if (choices[n].rate != 0) return slide(path, choices[n], directions[n]);
  ++counts.resting;
  return false;
}

/// visit(out) for the half-edges that leave the vertex at the source of one, each in another triangle.
template <class Visit>
void OnBorder::for_each_corner(HalfEdge out, const Visit& visit) const {
  constexpr int most = 4096;
  const std::vector<HalfEdge>& twins = borders_.surface().twins;
  HalfEdge h = out;
  for (int n = 0; n < most; ++n) {
    visit(h);
    h = twins[std::size_t(previous(h))];
    if (h < 0 || h == out) break;
  }
  if (h >= 0) return;
  h = out;
  for (int n = 0; n < most; ++n) {
    const HalfEdge twin = twins[std::size_t(h)];
    if (twin < 0) return;
    h = next(twin);
    visit(h);
  }
}

/// Into the triangle of `out` from its source.
OnBorder::Departure OnBorder::into_corner(HalfEdge out) const {
  const Vector2 at = borders_.source(out), e = borders_.edge(out), f = borders_.source(previous(out)) - at;
  const double turn = borders_.turn(out);
  Vector2 towards = e.normalized() + f.normalized();
  Departure found;
  for (int n = 0; n < 2; ++n) {  // once more where X leads into another cell or over the diagonal
    constexpr double nudge = 1e-6;
    const ChartPlace near = domain_.place(borders_.chart(out), borders_.texture(out), at + nudge * towards.normalized());
    if (!domain_.covered(near.cell)) return found;
    const bool first = domain_.diagonal(near.cell) == 1 ? near.x + near.y < 1 : near.x > near.y;
    const int triangle = 2 * near.cell + (first ? 0 : 1);
    const Vector2 X = flow_.velocity(triangle);
    if (!(turn * cross(e, X) >= 0 && turn * cross(X, f) >= 0) || X.isZero(0)) return {};
    found = {flow_.speed(triangle), out, triangle, 0};
    towards = X;
  }
  return found;
}

/// Along a border from its source (1) or its end (−1).
OnBorder::Departure OnBorder::along(HalfEdge h, int direction) const {
  if (!borders_.is_border(h)) return {};
  const Choice c = choice(h, direction > 0 ? 0 : 1, direction);
  return {std::abs(c.rate) * borders_.length(h), h, -1, direction};
}

bool OnBorder::leave_vertex(AtlasPath& path, PathCounts& counts) const {
  const HalfEdge out = path.s <= 0 ? path.border : next(path.border);
  Departure best;
  const auto offer = [&](const Departure& way) {
    if (!(way.speed > 0) || faster(best.speed, way.speed)) return;
    if (faster(way.speed, best.speed) || way.half_edge < best.half_edge) best = way;
  };
  for_each_corner(out, [&](HalfEdge h) {
    const int t = h / 3;
    if (borders_.atlas().chart[std::size_t(t)] < 0 || borders_.surface().degenerate[std::size_t(t)]) return;
    offer(into_corner(h));
    offer(along(h, 1));
    offer(along(previous(h), -1));
  });
  if (best.half_edge < 0) {
    ++counts.resting;
    return false;
  }
  if (best.triangle >= 0) {
    enter(path, best.half_edge, 0, best.triangle);
    return true;
  }
  ++counts.edges;
  path.border = best.half_edge;
  path.s = best.direction > 0 ? 0 : 1;
  return slide(path, choice(path.border, path.s, best.direction), best.direction);
}

// ------------------------------------------------------------------------------------- in the cells

Vector2 in_cell(const AtlasFlow& flow, const Path& path) {
  Vector2 p = Vector2::Zero();
  for (int k = 0; k < 3; ++k) p += path.b[std::size_t(k)] * flow.corner(path.triangle, k);
  return p;
}

/// The way that a step of the automaton will go in the path's cell, and the time that takes.
struct Step {
  Vector2 way = Vector2::Zero();
  double time = 0;
};
std::optional<Step> next_step(const AtlasFlow& flow, const Path& path) {
  if (path.on == Path::On::vertex) return {};
  if (path.on == Path::On::edge) {
    const int k = path.corner, i = after(k), j = before(k);
    const double rate = flow.slide_rate(path.triangle, k);
    if (rate == 0) return {};
    const double time = std::min(path.left, rate > 0 ? path.b[std::size_t(i)] / rate : path.b[std::size_t(j)] / -rate);
    return Step{time * rate * (flow.corner(path.triangle, j) - flow.corner(path.triangle, i)), time};
  }
  const std::array<double, 3> rate = flow.rates(path.triangle);
  double time = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i)
    if (rate[i] < 0) time = std::min(time, path.b[i] / -rate[i]);
  if (!std::isfinite(time)) return {};
  time = std::min(time, path.left);
  return Step{time * flow.velocity(path.triangle), time};
}

/// Where a step from p meets a border of its chart from inside.
struct Hit {
  HalfEdge half_edge = -1;
  double s = 0;
  double part = 1;  ///< of the way
};
Hit first_border(const AtlasBorders& borders, int cell, int chart, const Vector2& p, const Vector2& way, bool on_edge) {
  Hit hit;
  for (const BorderSegment& border : borders.of(cell)) {
    if (border.chart != chart) continue;
    const double length = border.edge.norm();
    const double begins = border.turn * cross(border.edge, p - border.from) / length,
                 ends = border.turn * cross(border.edge, p + way - border.from) / length;
    // Along a border that is the edge of a cell it does not slide as inside.
    const bool along = on_edge && std::abs(begins) <= on_border && std::abs(ends) <= on_border;
    if (!along && (begins < -on_border || ends > on_border || !(begins - ends > 1e-3 * on_border))) continue;
    const double part = along ? 0 : std::clamp(begins / (begins - ends), 0.0, 1.0);
    if (hit.half_edge >= 0 && part >= hit.part) continue;
    const double s = (p + part * way - border.from).dot(border.edge) / (length * length);
    if (s < -on_border / length || s > 1 + on_border / length) continue;
    hit = {border.half_edge, std::clamp(s, 0.0, 1.0), part};
  }
  return hit;
}

/// The border of its chart that a point of a cell lies on, if any.
Hit border_at(const AtlasBorders& borders, int cell, int chart, const Vector2& p) {
  for (const BorderSegment& border : borders.of(cell)) {
    if (border.chart != chart) continue;
    const double length = border.edge.norm(), s = (p - border.from).dot(border.edge) / (length * length);
    const double at = std::clamp(s, 0.0, 1.0);
    if ((p - border.from - at * border.edge).norm() > on_border) continue;
    return {border.half_edge, at * length <= on_border ? 0 : (1 - at) * length <= on_border ? 1 : at, 0};
  }
  return {};
}

}  // namespace

void put_at(const AtlasFlow& flow, AtlasPath& path, const ChartPlace& place) {
  path.chart = place.chart;
  path.meetings = 0;
  path.entered = false;
  path.border = -1;
  path.direction = 0;
  const bool first = flow.domain().diagonal(place.cell) == 1 ? place.x + place.y <= 1 : place.x >= place.y;
  set_weights(flow, path, 2 * place.cell + (first ? 0 : 1), {place.x, place.y});
  walk::put_at(flow, static_cast<Path&>(path), path.triangle, Vector3(path.b[0], path.b[1], path.b[2]));
}

ChartPlace place_of(const AtlasFlow& flow, const AtlasPath& path) {
  const AtlasBorders& borders = flow.domain().borders();
  if (path.border >= 0)
    return flow.domain().place(borders.chart(path.border), borders.texture(path.border), borders.at(path.border, path.s));
  const Vector2 p = in_cell(flow, path);
  return {path.chart, path.triangle >> 1, std::clamp(p.x(), 0.0, 1.0), std::clamp(p.y(), 0.0, 1.0)};
}

bool advance(const AtlasFlow& flow, AtlasPath& path, PathCounts& counts) {
  if (path.left == 0) return false;
  if (path.border >= 0) return OnBorder(flow).advance(path, counts);
  const int cell = path.triangle >> 1;
  const auto meet = [&](const Hit& hit) {
    path.border = hit.half_edge;
    path.s = hit.s;
    path.direction = 0;
    if (++path.meetings < most_meetings) return path.left > 0;
    ++counts.resting;
    return false;
  };
  if (flow.domain().bordered(cell) && path.on == Path::On::vertex && !std::exchange(path.entered, false))
    if (const Hit hit = border_at(flow.domain().borders(), cell, path.chart, in_cell(flow, path)); hit.half_edge >= 0)
      return meet(hit);
  if (flow.domain().bordered(cell))
    if (const auto step = next_step(flow, path)) {
      const Hit hit = first_border(flow.domain().borders(), cell, path.chart, in_cell(flow, path), step->way,
                                   path.on == Path::On::edge);
      if (hit.half_edge >= 0) {
        ++counts.triangles;
        path.left -= hit.part * step->time;
        return meet(hit);
      }
    }
  return advance(flow, static_cast<Path&>(path), counts);
}

bool leave_turns_out(AtlasPath& path, AtlasPath& mark) {
  constexpr std::int64_t first = 64;
  if (path.crossings < first) return true;
  if (std::has_single_bit(std::uint64_t(path.crossings))) {
    mark = path;
    return true;
  }
  if (path.border != mark.border) return true;
  if (path.border >= 0) {
    // Changes on a border may lie next to each other: no turn is as short.
    constexpr std::int64_t shortest = 8;
    if (path.crossings - mark.crossings < shortest || std::abs(path.s - mark.s) > same_place) return true;
  }
  if (path.border < 0) return leave_turns_out(static_cast<Path&>(path), static_cast<Path&>(mark));
  if (!std::isfinite(path.left)) return false;
  if (const double turn = mark.left - path.left; turn > 0) path.left = std::fmod(path.left, turn);
  return true;
}

}  // namespace mq::walk
