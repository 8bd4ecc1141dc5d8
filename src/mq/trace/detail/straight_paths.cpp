/// A segment is followed by the rates ⟨∇φ_k, d⟩ of its barycentric coordinates, as in walk.h. With
/// u the unit vector along the edge and n that across it, d = a·u + c·n here is −a·u′ + c·n′ there,
/// as the edge runs the other way in the next triangle.

#include "mq/trace/detail/straight_paths.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/trace/detail/walk.h"

namespace mq {
namespace {

using walk::after;
using walk::before;

/// Of a rate of weights, what is 0.
constexpr double rounding = 1e-12;

class Tracer {
 public:
  Tracer(const TraceMesh& mesh, const Vector& field, double step)
      : mesh_(mesh), field_(field), step_(step) {}

  SurfacePoint follow(const SurfacePoint& start, double time, PathCounts& counts) const {
    State at{mesh_.trace_triangle(start.triangle), start.barycentric};
    std::int64_t left = walk::most_crossings;
    while (time > 0 && left > 0) {
      const std::optional<Vector2> d = read(at);
      if (!d || d->norm() == 0) {
        ++counts.resting;
        break;
      }
      double segment = std::min(time, step_ / d->norm());
      time -= segment;
      time += go(at, *d, segment, counts, left);
    }
    if (left <= 0) ++counts.cut_short;
    return {mesh_.source_triangle(at.triangle), at.b};
  }

 private:
  struct State {
    int triangle;
    Vector3 b;
  };

  Vector2 value(int t) const { return field_.segment<2>(2 * mesh_.source_triangle(t)); }

  Vector3 rates(int t, const Vector2& d) const {
    const FlatTriangle& shape = mesh_.shape(t);
    const double first = shape.gradient(1).dot(d), second = shape.gradient(2).dot(d);
    return {-(first + second), first, second};
  }

  static int vertex_corner(const Vector3& b) {
    for (int k = 0; k < 3; ++k)
      if (b[after(k)] == 0 && b[before(k)] == 0) return k;
    return -1;
  }

  /// The vector to go on with; at a vertex also the triangle. Nothing: the path rests.
  std::optional<Vector2> read(State& at) const {
    const int corner = vertex_corner(at.b);
    if (corner < 0)
      return mesh_.shape(at.triangle).empty() ? std::nullopt : std::optional(value(at.triangle));
    const int v = mesh_.corners(at.triangle)[corner];
    double longest = 0;
    std::optional<Vector2> best;
    for (const int* c = mesh_.corners_begin(v); c != mesh_.corners_end(v); ++c) {
      const int t = *c / 3, k = *c % 3, i = after(k), j = before(k);
      const Vector2 X = value(t);
      const Vector3 rate = rates(t, X);
      const auto offer = [&](const Vector2& d) {
        if (!(d.norm() > longest)) return;
        longest = d.norm();
        best = d;
        at.triangle = t;
        at.b = Vector3::Unit(k);
      };
      if (rate[i] >= 0 && rate[j] >= 0) offer(X);
      const FlatTriangle& shape = mesh_.shape(t);
      if (mesh_.across(t, j) < 0 && rate[j] < 0) {
        const Vector2 u = shape.edge(k).normalized();
        if (X.dot(u) > 0) offer(X.dot(u) * u);
      }
      if (mesh_.across(t, i) < 0 && rate[i] < 0) {
        const Vector2 u = -shape.edge(j).normalized();
        if (X.dot(u) > 0) offer(X.dot(u) * u);
      }
    }
    return best;
  }

  /// Goes along d for `time`; what is left of it where the segment had to end.
  double go(State& at, Vector2 d, double time, PathCounts& counts, std::int64_t& left) const {
    for (; left > 0; --left) {
      ++counts.triangles;
      const FlatTriangle& shape = mesh_.shape(at.triangle);
      Vector3 rate = rates(at.triangle, d);
      // Off a vertex along an edge the rate across is 0 but for rounding, and the other vertex is met.
      const int corner = vertex_corner(at.b);
      if (corner >= 0) {
        for (const int k : {after(corner), before(corner)})
          if (rate[k] < rounding * rate.cwiseAbs().maxCoeff()) rate[k] = 0;
        rate[corner] = -(rate[after(corner)] + rate[before(corner)]);
      }
      int k = -1;
      double reached = std::numeric_limits<double>::infinity();
      for (int i = 0; i < 3; ++i)
        if (rate[i] < 0 && (k < 0 || at.b[i] / -rate[i] < reached)) {
          k = i;
          reached = at.b[i] / -rate[i];
        }
      if (k < 0) return 0;
      if (time <= reached) {
        at.b = (at.b + time * rate).cwiseMax(0);
        at.b /= at.b.sum();
        return 0;
      }
      time -= reached;
      const int i = after(k), j = before(k);
      at.b = (at.b + reached * rate).cwiseMax(0);
      at.b[k] = 0;
      at.b /= at.b[i] + at.b[j];
      if (at.b[i] == 0 || at.b[j] == 0) return time;
      const Vector2 u = shape.edge(i).normalized();
      const double along = d.dot(u), across = -d.dot(shape.gradient(k).normalized());
      const int code = mesh_.across(at.triangle, k);
      if (code < 0) return slide(at, k, along, time, counts);
      at.triangle = code >> 2;
      const int l = code & 3;
      const Vector3 b = at.b;
      at.b[l] = 0;
      at.b[after(l)] = b[j];
      at.b[before(l)] = b[i];
      const FlatTriangle& next = mesh_.shape(at.triangle);
      d = -along * next.edge(after(l)).normalized() + across * next.gradient(l).normalized();
    }
    return 0;
  }

  /// Along the edge opposite k with this speed towards corner k + 2.
  double slide(State& at, int k, double speed, double time, PathCounts& counts) const {
    ++counts.edges;
    const int i = after(k), j = before(k);
    const double rate = speed / mesh_.shape(at.triangle).edge(i).norm();
    if (rate == 0) return 0;
    const double reached = rate > 0 ? at.b[i] / rate : at.b[j] / -rate;
    if (time < reached) {
      at.b[j] = std::clamp(at.b[j] + rate * time, 0.0, 1.0);
      at.b[i] = 1 - at.b[j];
      return 0;
    }
    at.b = Vector3::Unit(rate > 0 ? j : i);
    return time - reached;
  }

  const TraceMesh& mesh_;
  const Vector& field_;
  double step_;
};

}  // namespace

Traced straight_paths(const TraceMesh& mesh, const Vector& field,
                      std::span<const SurfacePoint> starts, double time,
                      const StraightOptions& options, const Progress& progress) {
  require(time >= 0, fmt::format("a path cannot be followed for a time of {}", time));
  require(options.step > 0, fmt::format("a step of {} leads nowhere", options.step));
  require(field.size() == 2 * std::int64_t(mesh.triangle_count()) && field.allFinite(),
          fmt::format("a field needs two finite values for each of {} triangles; {} were given",
                      mesh.triangle_count(), field.size()));
  require_points(mesh, starts);
  const Tracer tracer(mesh, field, options.step);
  Traced traced;
  traced.ends.resize(starts.size());
  std::atomic<std::int64_t> done = 0;
  traced.counts = parallel_sum(
      std::ssize(starts), PathCounts{},
      [&](auto begin, auto end) {
        PathCounts counts;
        counts.paths = end - begin;
        for (auto i = begin; i < end; ++i) {
          progress.check();
          traced.ends[i] = tracer.follow(starts[i], time, counts);
        }
        progress.at(double(done += end - begin) / double(starts.size()));
        return counts;
      },
      512);
  return traced;
}

}  // namespace mq
