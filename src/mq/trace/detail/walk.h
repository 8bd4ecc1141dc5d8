#pragma once
/// The automaton that follows integral curves of a field constant on each triangle. It is written
/// once for every domain of triangles: a `Field` says how fast barycentric coordinates change and
/// what lies across edges (`SurfaceFlow` for meshes, `GridFlow` for images).
///
/// A path is on a face, on an edge it slides along, or at a vertex. On a face its coordinates
/// change at constant rates; the first that reaches 0 is set to 0 exactly, and crossing that edge
/// only permutes them, so that a path is on the edge as seen from both sides, and nothing drifts.

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "mq/base/progress.h"
#include "mq/mesh/surface_point.h"
#include "mq/trace/path_counts.h"

namespace mq::walk {

/// No path comes near it but one that winds for ever without coming back to where it was, which
/// gradients have none of.
inline constexpr std::int64_t most_crossings = std::int64_t(1) << 24;

inline int after(int k) { return k == 2 ? 0 : k + 1; }
inline int before(int k) { return k == 0 ? 2 : k - 1; }

/// Where a path at a vertex goes on: into a triangle from its corner, or along the edge from that
/// corner to the next one or to the one before.
enum class Way { face = 0, edge_to_next = 1, edge_to_previous = 2 };
inline constexpr std::int64_t rest = -1;
inline std::int64_t exit_code(int triangle, int corner, Way way) {
  return 16 * std::int64_t(triangle) + 4 * corner + int(way);
}

/// A weight below this is 0, so that a path that winds into a vertex arrives there.
inline constexpr double no_way = 1e-100;

/// By more than rounding: of two that are equal, as on symmetric shapes, it must not decide.
inline bool faster(double speed, double than) { return speed > than * (1 + 1e-9); }

struct Path {
  enum class On : char { face, edge, vertex } on = On::vertex;
  int id = 0;
  int triangle = 0;
  int corner = 0;  ///< the vertex it is at, or the one opposite its edge
  std::array<double, 3> b{};
  double left = 0;  ///< time
  std::int64_t crossings = 0;
};

inline void put_at_vertex(Path& path, int triangle, int corner) {
  path.on = Path::On::vertex;
  path.triangle = triangle;
  path.corner = corner;
  path.b = {};
  path.b[corner] = 1;
}

/// The path on the edge opposite corner k, where nothing says yet which way: where both sides press
/// it against the edge it slides, where both pull it off it takes the faster side, the lower number
/// if they are equal.
template <class Field>
void put_on_edge(const Field& field, Path& path, int k) {
  path.corner = k;
  const double here = field.rates(path.triangle)[k];
  const std::int64_t across = field.across(path.triangle, k);
  path.on = Path::On::edge;
  const bool in_here = here > 0;
  bool in_there = false;
  if (across >= 0) {
    const int there = int(across >> 2);
    in_there = field.rates(there)[std::size_t(across & 3)] > 0;
    if (in_here && in_there) {
      const double speed = field.speed(path.triangle), other = field.speed(there);
      in_there = faster(other, speed) || (!faster(speed, other) && there < path.triangle);
    }
  }
  if (!in_here && !in_there) return;
  path.on = Path::On::face;
  if (!in_there) return;
  const double first = path.b[after(k)], second = path.b[before(k)];
  path.triangle = int(across >> 2);
  path.corner = int(across & 3);
  path.b[path.corner] = 0;
  path.b[after(path.corner)] = second;
  path.b[before(path.corner)] = first;
}

/// A path that begins at a point; weights that are 0 say that it is on an edge or at a vertex.
template <class Field>
void put_at(const Field& field, Path& path, int triangle, const Vector3& b) {
  path.triangle = triangle;
  path.b = {b[0], b[1], b[2]};
  for (int k = 0; k < 3; ++k)
    if (b[after(k)] == 0 && b[before(k)] == 0) return put_at_vertex(path, triangle, k);
  path.on = Path::On::face;
  for (int k = 0; k < 3; ++k)
    if (b[k] == 0) return put_on_edge(field, path, k);
}

/// Through the triangle to its border. False when the path is at its end.
template <class Field>
bool advance_on_face(const Field& field, Path& path, PathCounts& counts) {
  ++counts.triangles;
  const std::array<double, 3> rate = field.rates(path.triangle);
  double time = std::numeric_limits<double>::infinity();
  int k = -1;
  for (int i = 0; i < 3; ++i) {
    const double reached = rate[i] < 0 ? path.b[i] / -rate[i] : time;
    if (rate[i] < 0 && (k < 0 || reached < time)) {
      time = reached;
      k = i;
    }
  }
  if (k < 0) {  // nothing changes here
    ++counts.resting;
    return false;
  }
  const int i = after(k), j = before(k);
  if (path.left <= time) {
    double sum = 0;
    for (int n = 0; n < 3; ++n) {
      path.b[n] += rate[n] * path.left;
      if (path.b[n] < 0) path.b[n] = 0;
      sum += path.b[n];
    }
    for (double& b : path.b) b /= sum;
    return false;
  }
  path.left -= time;
  double first = path.b[i] + rate[i] * time, second = path.b[j] + rate[j] * time;
  if (!(first > no_way)) first = 0;
  if (!(second > no_way)) second = 0;
  if (first == 0 || second == 0) {
    put_at_vertex(path, path.triangle, first == 0 ? j : i);
    return true;
  }
  const double sum = first + second;
  first /= sum;
  second = 1 - first;
  path.b[k] = 0;
  path.b[i] = first;
  path.b[j] = second;
  path.corner = k;
  const std::int64_t across = field.leave(path.triangle, k);
  if (across < 0) {
    path.on = Path::On::edge;
    return true;
  }
  path.triangle = int(across >> 2);
  const int l = int(across & 3);
  path.b[l] = 0;
  path.b[after(l)] = second;
  path.b[before(l)] = first;
  field.prefetch(path.triangle);
  return true;
}

/// Along the edge to its end. False when the path is at its end.
template <class Field>
bool advance_on_edge(const Field& field, Path& path, PathCounts& counts) {
  ++counts.edges;
  const int k = path.corner, i = after(k), j = before(k);
  const double rate = field.slide_rate(path.triangle, k);
  if (rate == 0) {
    ++counts.resting;
    return false;
  }
  const double time = rate > 0 ? path.b[i] / rate : path.b[j] / -rate;
  if (path.left <= time) {
    double second = path.b[j] + rate * path.left;
    second = second < 0 ? 0 : second > 1 ? 1 : second;
    path.b[j] = second;
    path.b[i] = 1 - second;
    return false;
  }
  path.left -= time;
  put_at_vertex(path, path.triangle, rate > 0 ? j : i);
  return true;
}

/// Into a triangle or an edge around the vertex. False when the path is at its end.
template <class Field>
bool advance_from_vertex(const Field& field, Path& path, PathCounts& counts) {
  const std::int64_t way = field.exit(path.triangle, path.corner);
  if (way == rest) {
    ++counts.resting;
    return false;
  }
  put_at_vertex(path, int(way >> 4), int(way >> 2) & 3);
  const Way kind = Way(int(way) & 3);
  if (kind == Way::face) {
    path.on = Path::On::face;
  } else {
    path.on = Path::On::edge;
    path.corner = kind == Way::edge_to_next ? before(path.corner) : after(path.corner);
  }
  field.prefetch(path.triangle);
  return true;
}

/// Goes on to the next edge or vertex. False when the path is at its end.
template <class Field>
bool advance(const Field& field, Path& path, PathCounts& counts) {
  if (path.left == 0) return false;
  if (path.on == Path::On::face) return advance_on_face(field, path, counts);
  if (path.on == Path::On::edge) return advance_on_edge(field, path, counts);
  return advance_from_vertex(field, path, counts);
}

/// Weights of a place that a path has come back to differ by less than this: rounding.
inline constexpr double same_place = 1e-9;

/// Paths of a field that is no gradient may go round for ever. One that comes back to a place marked
/// before, moving in the same way (places are marked at crossings 64, 128, 256, ...: Brent, An
/// improved Monte Carlo factorization algorithm, 1980), goes on for what whole turns leave of its
/// time. False where that is without end.
inline bool leave_turns_out(Path& path, Path& mark) {
  constexpr std::int64_t first = 64;
  if (path.crossings < first) return true;
  if (std::has_single_bit(std::uint64_t(path.crossings))) {
    mark = path;
    return true;
  }
  if (path.triangle != mark.triangle || path.on != mark.on || path.corner != mark.corner) return true;
  for (int k = 0; k < 3; ++k)
    if (std::abs(path.b[k] - mark.b[k]) > same_place) return true;
  if (!std::isfinite(path.left)) return false;
  if (const double turn = mark.left - path.left; turn > 0) path.left = std::fmod(path.left, turn);
  return true;
}

/// Follows paths begin to end − 1, several at a time so that one waits for memory while others go
/// on; a path that ends makes room for the next. start(path) places the path of `path.id`,
/// finish(path) takes its end. Each path is by itself: what it does depends on no other. `Path` may be
/// derived, with an `advance` and `leave_turns_out` of its own.
template <class Path = walk::Path, class Field, class Start, class Finish>
PathCounts follow(const Field& field, std::int64_t begin, std::int64_t end, double time,
                  const Start& start, const Finish& finish, const Progress& progress) {
  constexpr int most_lanes = 16;
  std::array<Path, most_lanes> lanes, marks;
  PathCounts counts;
  counts.paths = end - begin;
  std::int64_t next = begin;
  const auto fill = [&](Path& path) {
    path.id = int(next++);
    path.left = time;
    path.crossings = 0;
    start(path);
  };
  int active = 0;
  while (active < most_lanes && next < end) fill(lanes[active++]);
  for (std::int64_t round = 1; active > 0; ++round) {
    if (round % 65536 == 0) progress.check();
    for (int n = 0; n < active;) {
      Path& path = lanes[n];
      bool goes_on = advance(field, path, counts);
      if (goes_on && (++path.crossings > most_crossings || !leave_turns_out(path, marks[n]))) {
        ++counts.cut_short;
        goes_on = false;
      }
      if (goes_on) {
        ++n;
        continue;
      }
      finish(path);
      if (next < end) {
        fill(path);
      } else {
        path = lanes[--active];
        marks[n] = marks[active];
      }
    }
  }
  return counts;
}

}  // namespace mq::walk
