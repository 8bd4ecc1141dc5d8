/// In a triangle with X, the weight of corner k changes by ⟨∇φ_k, X⟩. For X = −∇P that is
///
///     −Σ_j P_j ⟨∇φ_j, ∇φ_k⟩ = Σ_{j≠k} (P_j − P_k) · (½ cot of the third angle) / area,
///
/// as ⟨∇φ_j, ∇φ_k⟩ = −½ cot / area. On the edge from corner k + 1 to k + 2, of length l, the weight
/// of the latter changes by (P_{k+1} − P_{k+2}) / l².
///
/// For any X the two sides press against an edge with speeds a (from here) and a′ (from across),
/// and the combination without a part across is λX + (1 − λ)X′ with λa = (1 − λ)a′.

#include "mq/trace/surface_flow.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/trace/detail/walk.h"

namespace mq {
namespace {

using walk::after;
using walk::before;

/// Paths of one piece of work; threads that are done take pieces of others.
constexpr std::int64_t block = 2048;

void require_time(double time) {
  require(time >= 0, fmt::format("a path cannot be followed for a time of {}", time));
}

/// X in a triangle's frame, from how fast weights change.
Vector2 velocity(const FlatTriangle& shape, const std::array<double, 3>& rates) {
  return {rates[1] * shape.base + rates[2] * shape.foot, rates[2] * shape.height};
}

/// Row of `to` from the rows of three corners; within their range.
void interpolate(const Signal& from, const Triangle& corners, const std::array<double, 3>& b,
                 Signal& to, int row) {
  const double* values[3] = {from.row(corners[0]).data(), from.row(corners[1]).data(),
                             from.row(corners[2]).data()};
  double* result = to.row(row).data();
  for (int k = 0; k < 3; ++k)
    if (b[k] == 1) {
      std::copy_n(values[k], from.cols(), result);
      return;
    }
  for (Eigen::Index c = 0; c < from.cols(); ++c) {
    const double sum = b[0] * values[0][c] + b[1] * values[1][c] + b[2] * values[2][c];
    const auto [low, high] = std::minmax({values[0][c], values[1][c], values[2][c]});
    result[c] = std::clamp(sum, low, high);
  }
}

/// Runs paths 0 to count − 1 in blocks on all threads.
template <class Start, class Finish>
PathCounts run(const SurfaceFlow& flow, std::int64_t count, double time, const Start& start,
               const Finish& finish, const Progress& progress) {
  std::atomic<std::int64_t> done = 0;
  return parallel_sum(
      count, PathCounts{},
      [&](std::int64_t begin, std::int64_t end) {
        const PathCounts counts = walk::follow(flow, begin, end, time, start, finish, progress);
        progress.at(double(done += end - begin) / double(count));
        return counts;
      },
      block);
}

}  // namespace

void require_points(const TraceMesh& mesh, std::span<const SurfacePoint> points) {
  for (const SurfacePoint& p : points)
    require(
        p.triangle >= 0 && p.triangle < mesh.triangle_count() && p.barycentric.allFinite() &&
            p.barycentric.minCoeff() >= 0 && std::abs(p.barycentric.sum() - 1) < 1e-9,
        fmt::format("a path cannot begin in triangle {} of {} with weights {}, {}, {}, which must "
                    "not be negative and sum to 1",
                    p.triangle, mesh.triangle_count(), p.barycentric[0], p.barycentric[1],
                    p.barycentric[2]));
}

double SurfaceFlow::speed(int t) const { return velocity(mesh_->shape(t), rates(t)).norm(); }

/// The fastest way on from a vertex, of equally fast ones that of the first triangle in the file.
int SurfaceFlow::find_exit(int v) const {
  const auto ways = [&](const auto& offer) {
    for (const int* corner = mesh_->corners_begin(v); corner != mesh_->corners_end(v); ++corner) {
      const int t = *corner / 3, k = *corner % 3, i = after(k), j = before(k);
      const std::array<double, 3> rate = rates(t);
      if (rate[i] >= 0 && rate[j] >= 0) offer(speed(t), t, k, walk::Way::face);
      // On the edge to the next corner, opposite j, the rate is that of corner j + 2 = i; on the
      // other, opposite i, that of i + 2 = k.
      const auto presses = [&](int opposite) {
        return rate[opposite] <= 0 && records_[t].leave[opposite] < 0;
      };
      if (presses(j))
        offer(slide_rates_[t][j] * mesh_->shape(t).edge(k).norm(), t, k, walk::Way::edge_to_next);
      if (presses(i))
        offer(-slide_rates_[t][i] * mesh_->shape(t).edge(j).norm(), t, k,
              walk::Way::edge_to_previous);
    }
  };
  double fastest = 0;
  ways([&](double speed, int, int, walk::Way) { fastest = std::max(fastest, speed); });
  std::int64_t best = walk::rest;
  int first = std::numeric_limits<int>::max();
  if (fastest > 0)
    ways([&](double speed, int t, int k, walk::Way way) {
      if (walk::faster(fastest, speed) || mesh_->source_triangle(t) >= first) return;
      first = mesh_->source_triangle(t);
      best = walk::exit_code(t, k, way);
    });
  return int(best);
}

/// Which edges are slid along, how fast, and where paths leave vertices.
template <class SlideRate>
void SurfaceFlow::finish(const SlideRate& slide_rate) {
  slide_rates_.resize(records_.size());
  parallel_for(std::ssize(records_), [&](std::int64_t t) {
    if (mesh_->shape(int(t)).empty()) return;
    for (int k = 0; k < 3; ++k) {
      const int across = mesh_->across(int(t), k);
      const bool leads_on = across >= 0 && rates(across >> 2)[across & 3] > 0;
      records_[t].leave[k] = leads_on ? across : -1;
      // Nobody slides where the field leads on, nor where it leads away from the edge.
      slide_rates_[t][k] = leads_on || rates(int(t))[k] > 0 ? 0 : slide_rate(int(t), k);
    }
  });
  exits_.resize(mesh_->vertex_count());
  parallel_for(mesh_->vertex_count(), [&](std::int64_t v) { exits_[v] = find_exit(int(v)); });
}

SurfaceFlow SurfaceFlow::downhill(const TraceMesh& mesh, const Vector& potential) {
  require(potential.size() == mesh.vertex_count() && potential.allFinite(),
          fmt::format("a potential needs a finite value at each of {} vertices; {} were given",
                      mesh.vertex_count(), potential.size()));
  SurfaceFlow flow(mesh);
  Vector P(potential.size());
  parallel_for(P.size(), [&](std::int64_t v) { P[v] = potential[mesh.source_vertex(int(v))]; });
  flow.records_.resize(mesh.triangle_count());
  parallel_for(mesh.triangle_count(), [&](std::int64_t t) {
    const FlatTriangle& shape = mesh.shape(int(t));
    if (shape.empty()) return;
    const Triangle& v = mesh.corners(int(t));
    const auto rate = [&](int k) {
      return ((P[v[after(k)]] - P[v[k]]) * shape.half_cotangent(before(k)) +
              (P[v[before(k)]] - P[v[k]]) * shape.half_cotangent(after(k))) /
             shape.area();
    };
    flow.records_[t].rate1 = rate(1);
    flow.records_[t].rate2 = rate(2);
  });
  flow.finish([&](int t, int k) {
    const Triangle& v = mesh.corners(t);
    return (P[v[after(k)]] - P[v[before(k)]]) / mesh.shape(t).edge(after(k)).squaredNorm();
  });
  return flow;
}

SurfaceFlow SurfaceFlow::along(const TraceMesh& mesh, const Vector& field) {
  require(field.size() == 2 * std::int64_t(mesh.triangle_count()) && field.allFinite(),
          fmt::format("a field needs two finite values for each of {} triangles; {} were given",
                      mesh.triangle_count(), field.size()));
  SurfaceFlow flow(mesh);
  flow.records_.resize(mesh.triangle_count());
  parallel_for(mesh.triangle_count(), [&](std::int64_t t) {
    const FlatTriangle& shape = mesh.shape(int(t));
    if (shape.empty()) return;
    // ∇φ₂ = (0, 1/height), ∇φ₁ = (1, −foot/height)/base.
    const Vector2 X = field.segment<2>(2 * mesh.source_triangle(int(t)));
    flow.records_[t].rate2 = X.y() / shape.height;
    flow.records_[t].rate1 = (X.x() - shape.foot * flow.records_[t].rate2) / shape.base;
  });
  /// Speed towards the edge opposite k, and the rate of the weight of corner k + 2 along it.
  const auto parts = [&](int t, int k) {
    const FlatTriangle& shape = mesh.shape(t);
    const Vector2 edge = shape.edge(after(k));
    const std::array<double, 3> rates = flow.rates(t);
    return std::array{std::max(0.0, -rates[k]) / shape.gradient(k).norm(),
                      velocity(shape, rates).dot(edge) / edge.squaredNorm()};
  };
  flow.finish([&](int t, int k) {
    const auto [here, along] = parts(t, k);
    const int across = mesh.across(t, k);
    if (across < 0) return along;
    const auto [there, along_there] = parts(across >> 2, across & 3);
    const double share = here + there > 0 ? there / (here + there) : 0.5;
    return share * along - (1 - share) * along_there;
  });
  return flow;
}

Traced SurfaceFlow::trace(std::span<const SurfacePoint> starts, double time,
                          const Progress& progress) const {
  require_time(time);
  require(std::ssize(starts) < std::numeric_limits<int>::max(), "too many paths for one call");
  require_points(*mesh_, starts);
  std::vector<std::pair<int, int>> order(starts.size());
  parallel_for(std::ssize(order), [&](std::int64_t i) {
    order[i] = {mesh_->trace_triangle(starts[i].triangle), int(i)};
  });
  tbb::parallel_sort(order.begin(), order.end());
  Traced traced;
  traced.ends.resize(starts.size());
  traced.counts = run(
      *this, std::ssize(order), time,
      [&](walk::Path& path) {
        const auto [triangle, start] = order[path.id];
        walk::put_at(*this, path, triangle, starts[start].barycentric);
      },
      [&](const walk::Path& path) {
        traced.ends[order[path.id].second] = {mesh_->source_triangle(path.triangle),
                                              {path.b[0], path.b[1], path.b[2]}};
      },
      progress);
  return traced;
}

Traced SurfaceFlow::trace_vertices(double time, const Progress& progress) const {
  require_time(time);
  Traced traced;
  traced.ends.resize(mesh_->vertex_count());
  traced.counts = run(
      *this, mesh_->vertex_count(), time,
      [&](walk::Path& path) {
        const int corner = std::max(0, mesh_->any_corner(path.id));
        walk::put_at_vertex(path, corner / 3, corner % 3);
      },
      [&](const walk::Path& path) {
        if (mesh_->any_corner(path.id) < 0) return;
        traced.ends[mesh_->source_vertex(path.id)] = {mesh_->source_triangle(path.triangle),
                                                      {path.b[0], path.b[1], path.b[2]}};
      },
      progress);
  return traced;
}

Advected SurfaceFlow::advect(const Signal& signal, double time, const Progress& progress) const {
  require_time(time);
  require(signal.rows() == mesh_->vertex_count(),
          fmt::format("a signal of {} rows was given for {} vertices", signal.rows(),
                      mesh_->vertex_count()));
  Signal from(signal.rows(), signal.cols());
  parallel_for(from.rows(),
               [&](std::int64_t v) { from.row(v) = signal.row(mesh_->source_vertex(int(v))); });
  Advected advected;
  advected.signal.resize(signal.rows(), signal.cols());
  Signal& to = advected.signal;
  advected.counts = run(
      *this, mesh_->vertex_count(), time,
      [&](walk::Path& path) {
        const int corner = std::max(0, mesh_->any_corner(path.id));
        walk::put_at_vertex(path, corner / 3, corner % 3);
      },
      [&](const walk::Path& path) {
        const int row = mesh_->source_vertex(path.id);
        if (mesh_->any_corner(path.id) < 0)
          to.row(row) = signal.row(row);
        else
          interpolate(from, mesh_->corners(path.triangle), path.b, to, row);
      },
      progress);
  return advected;
}

}  // namespace mq
