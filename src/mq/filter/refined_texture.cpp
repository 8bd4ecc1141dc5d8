#include "mq/filter/refined_texture.h"

#include <algorithm>
#include <cmath>

#include "mq/atlas/texel_grid.h"
#include "mq/base/parallel.h"
#include "mq/mesh/closest_point.h"

namespace mq {
namespace {

/// The point of a triangle with these weights of corners 1 and 2, in texels.
Vector2 in_texture(const Atlas& atlas, int t, const Vector2& weights) {
  const auto& c = atlas.corners[t];
  const Vector2 p(c[0].column(), c[0].row());
  return p + weights[0] * (Vector2(c[1].column(), c[1].row()) - p) +
         weights[1] * (Vector2(c[2].column(), c[2].row()) - p);
}

/// How far outside a triangle, in its weights, a centre counts as inside: rounding.
constexpr double rim = 1e-9;

/// Places of centres outside charts are single precision, which for textures of 8192² is about a part
/// of a texel like this: what is nearer to an edge is on it, so that rounding does not say on which
/// side paths begin.
constexpr double on_edge = 1e-3;

/// Weights of which those below `least` are 0.
Vector3 snapped(const Vector3& weights, double least) {
  const Vector3 kept = (weights.array() > least).select(weights, 0);
  return kept / kept.sum();
}

}  // namespace

double expected_vertices(int texels, double longest_edge) {
  return 2.55 * texels / (longest_edge * longest_edge);
}

RefinedTexture::RefinedTexture(const Surface& surface, const Atlas& atlas, const TexelSpace& space,
                               double longest_edge, const Progress& progress)
    : source_(surface), atlas_(atlas), space_(space) {
  std::vector<char> keep(atlas.chart.size());
  std::ranges::transform(atlas.chart, keep.begin(), [](int chart) { return chart >= 0; });
  fine_ = refine(
      surface, keep,
      [&](int t, const Vector2& from, const Vector2& to) {
        return (in_texture(atlas_, t, from) - in_texture(atlas_, t, to)).norm();
      },
      longest_edge, progress);
}

Vector3 RefinedTexture::place(const SurfacePoint& point) const {
  const Mesh& mesh = fine_.surface.mesh;
  Vector3 sum = Vector3::Zero();
  for (int k = 0; k < 3; ++k)
    sum += point.barycentric[k] * mesh.positions[mesh.triangles[point.triangle][k]];
  return sum;
}

void RefinedTexture::value(const Signal& signal, const SurfacePoint& point,
                           Eigen::Ref<Signal> row) const {
  const auto basis = space_.basis_at(fine_.source[point.triangle],
                                     fine_.in_source(point.triangle, point.barycentric));
  for (Eigen::Index c = 0; c < row.cols(); ++c) {
    double sum = 0, low = INFINITY, high = -INFINITY;
    for (const auto& [texel, weight] : basis) {
      if (weight == 0) continue;
      const double v = signal(texel, c);
      sum += weight * v;
      low = std::min(low, v);
      high = std::max(high, v);
    }
    row(0, c) = std::clamp(sum, low, high);
  }
}

Signal RefinedTexture::at_vertices(const Signal& signal) const {
  const Mesh& mesh = fine_.surface.mesh;
  std::vector<int> corner(mesh.positions.size(), -1);
  for (int t = mesh.triangle_count() - 1; t >= 0; --t)
    for (int k = 0; k < 3; ++k) corner[mesh.triangles[t][k]] = 3 * t + k;
  Signal values = Signal::Zero(mesh.vertex_count(), signal.cols());
  parallel_for(mesh.vertex_count(), [&](std::int64_t v) {
    if (corner[v] >= 0)
      value(signal, {corner[v] / 3, Vector3::Unit(corner[v] % 3)}, values.middleRows(v, 1));
  });
  return values;
}

std::vector<SurfacePoint> RefinedTexture::starts(const Progress& progress) const {
  std::vector<SurfacePoint> starts(static_cast<std::size_t>(space_.size()));
  find_inside(starts);
  progress.at(0.3);
  std::vector<int> outside;
  std::vector<Vector3> places;
  for (int i = 0; i < space_.size(); ++i)
    if (starts[i].triangle < 0) {
      outside.push_back(i);
      places.push_back(space_.texels().position(i));
    }
  if (outside.empty()) return starts;
  Mesh kept;
  kept.positions = source_.mesh.positions;
  std::vector<int> triangles;
  for (int t = 0; t < source_.triangle_count(); ++t)
    if (atlas_.chart[t] >= 0) {
      kept.triangles.push_back(source_.mesh.triangles[t]);
      triangles.push_back(t);
    }
  const ClosestPointFinder finder(kept);
  const std::vector<ClosestPoint> found = finder(places, progress);
  std::vector<int> first(source_.mesh.triangles.size(), -1);
  for (int t = int(fine_.source.size()) - 1; t >= 0; --t) first[fine_.source[t]] = t;
  parallel_for(std::ssize(outside), [&](std::int64_t n) {
    starts[outside[n]] = part_at(first[triangles[found[n].triangle]], found[n].barycentric);
  });
  return starts;
}

/// Weights of part t's corners for a point with these weights in its source.
Vector3 RefinedTexture::in_part(int t, const Vector3& point) const {
  const auto& c = fine_.corners[t];
  const Vector2 p(c[0], c[1]), u = Vector2(c[2], c[3]) - p, v = Vector2(c[4], c[5]) - p;
  const Vector2 d = Vector2(point[1], point[2]) - p;
  const double area = u.x() * v.y() - u.y() * v.x();
  const double first = (d.x() * v.y() - d.y() * v.x()) / area;
  const double second = (u.x() * d.y() - u.y() * d.x()) / area;
  return {1 - first - second, first, second};
}

/// The point of a source triangle with these weights, on the part it lies in: by walking there
/// from its first part, over the edge beyond which the point lies furthest; by looking at all
/// parts where that leads round in circles.
SurfacePoint RefinedTexture::part_at(int first, const Vector3& point) const {
  const int source = fine_.source[first];
  const auto inside = [&](int t, const Vector3& b) {
    return SurfacePoint{t, snapped(b, on_edge)};
  };
  int t = first;
  for (int step = 0; step < 10'000; ++step) {
    const Vector3 b = in_part(t, point);
    int next = -1;
    double least = -rim;
    for (int k = 0; k < 3; ++k) {
      const HalfEdge twin = fine_.surface.twins[3 * t + (k + 1) % 3];
      if (b[k] >= least || twin < 0 || fine_.source[twin / 3] != source) continue;
      least = b[k];
      next = twin / 3;
    }
    if (next < 0) return inside(t, b);
    t = next;
  }
  int best = first;
  double most = -INFINITY;
  for (t = first; t < int(fine_.source.size()) && fine_.source[t] == source; ++t)
    if (const double least = in_part(t, point).minCoeff(); least > most) {
      most = least;
      best = t;
    }
  return inside(best, in_part(best, point));
}

/// Texels whose centres lie in fine triangles, by going over these.
void RefinedTexture::find_inside(std::vector<SurfacePoint>& starts) const {
  const TexelGrid grid(atlas_.textures);
  std::vector<int> unknown(grid.texel_count(), -1);
  const auto& places = space_.texels().places;
  for (int i = 0; i < space_.size(); ++i)
    unknown[grid.texel(places[i].texture, places[i].x, places[i].y)] = i;
  for (int t = 0; t < fine_.surface.triangle_count(); ++t) {
    const int source = fine_.source[t], texture = atlas_.charts[atlas_.chart[source]].texture;
    const auto& c = fine_.corners[t];
    const Vector2 p = in_texture(atlas_, source, {c[0], c[1]}),
                  q = in_texture(atlas_, source, {c[2], c[3]}),
                  r = in_texture(atlas_, source, {c[4], c[5]});
    const Vector2 u = q - p, v = r - p;
    const double area = u.x() * v.y() - u.y() * v.x();
    if (area == 0) continue;
    const Vector2 low = p.cwiseMin(q).cwiseMin(r), high = p.cwiseMax(q).cwiseMax(r);
    for (int y = int(std::ceil(low.y())); y <= int(std::floor(high.y())); ++y)
      for (int x = int(std::ceil(low.x())); x <= int(std::floor(high.x())); ++x) {
        const Vector2 d = Vector2(x, y) - p;
        Vector3 b(0, (d.x() * v.y() - d.y() * v.x()) / area,
                  (u.x() * d.y() - u.y() * d.x()) / area);
        b[0] = 1 - b[1] - b[2];
        if (b.minCoeff() < -rim) continue;
        const int i = unknown[grid.texel(texture, x, y)];
        if (i < 0 || starts[i].triangle >= 0) continue;
        starts[i] = {t, snapped(b, rim)};
      }
  }
}

}  // namespace mq
