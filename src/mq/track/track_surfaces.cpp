// What a frame and a template are made into before they are tracked, and what is measured after.

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/linear/dense.h"
#include "mq/mesh/unfold.h"
#include "mq/mesh/weld.h"
#include "mq/track/tracking.h"

namespace mq {
namespace {

/// Cosine between normals from which on two surfaces face alike.
constexpr double alike = 0.5;

/// Per triangle whether it is kept: it has three vertices, and its part enough area.
std::vector<char> sound_triangles(const Surface& surface, double least_part) {
  DisjointSets parts(surface.mesh.positions.size());
  std::vector<char> kept(surface.mesh.triangles.size(), 0);
  for (int t = 0; t < surface.triangle_count(); ++t) {
    const Triangle& v = surface.mesh.triangles[t];
    kept[t] = v[0] != v[1] && v[1] != v[2] && v[2] != v[0];
    if (!kept[t]) continue;
    parts.join(v[0], v[1]);
    parts.join(v[1], v[2]);
  }
  const std::vector<double> areas = triangle_areas(surface.mesh);
  std::vector<double> part_areas(surface.mesh.positions.size(), 0);
  double total = 0;
  for (int t = 0; t < surface.triangle_count(); ++t)
    if (kept[t]) {
      part_areas[parts.root(surface.mesh.triangles[t][0])] += areas[t];
      total += areas[t];
    }
  for (int t = 0; t < surface.triangle_count(); ++t)
    if (kept[t] && part_areas[parts.root(surface.mesh.triangles[t][0])] < least_part * total)
      kept[t] = 0;
  return kept;
}

/// The value that a share `part` of the weight lies below.
double percentile(std::vector<std::pair<double, double>> weighted, double part) {
  if (weighted.empty()) return 0;
  std::ranges::sort(weighted);
  double total = 0, sum = 0;
  for (const auto& [value, weight] : weighted) total += weight;
  for (const auto& [value, weight] : weighted)
    if ((sum += weight) >= part * total) return value;
  return weighted.back().first;
}

SurfaceDistance distances_of(const std::vector<ClosestPoint>& closest, double diagonal) {
  SurfaceDistance result;
  std::vector<std::pair<double, double>> all;
  all.reserve(closest.size());
  for (const ClosestPoint& p : closest) {
    const double d = std::sqrt(p.squared_distance) / diagonal;
    result.mean += d / double(closest.size());
    result.max = std::max(result.max, d);
    all.emplace_back(d, 1);
  }
  result.p95 = percentile(std::move(all), 0.95);
  return result;
}

SurfaceDistance larger(const SurfaceDistance& a, const SurfaceDistance& b) {
  return {std::max(a.mean, b.mean), std::max(a.p95, b.p95), std::max(a.max, b.max)};
}

SurfaceDistance smaller(const SurfaceDistance& a, const SurfaceDistance& b) {
  return {std::min(a.mean, b.mean), std::min(a.p95, b.p95), std::min(a.max, b.max)};
}

std::vector<ClosestPoint> measured_of(const std::vector<ClosestPoint>& back, const TrackTarget& target) {
  std::vector<ClosestPoint> measured;
  for (const int v : target.measured()) measured.push_back(back[v]);
  return measured;
}

/// The corners 1 and 2 of a triangle, seen from corner 0, in its plane; columns.
Eigen::Matrix2d flat(const Vector3& a, const Vector3& b, const Vector3& c) {
  const Vector3 e = b - a, f = c - a;
  const double length = e.norm();
  Eigen::Matrix2d F;
  F << length, e.dot(f) / length, 0, e.cross(f).norm() / length;
  return F;
}

/// The triangles of a surface that are kept, with what `mesh`, which has the same, says of them.
CleanMesh part_of(const Surface& surface, const std::vector<char>& kept, const Mesh& mesh) {
  CleanMesh start;
  std::vector<int> vertex(surface.mesh.positions.size(), -1);
  for (int t = 0; t < surface.triangle_count(); ++t) {
    if (!kept[t]) continue;
    Triangle corners;
    for (int k = 0; k < 3; ++k) {
      int& v = vertex[surface.mesh.triangles[t][k]];
      if (v < 0) {
        v = start.mesh.vertex_count();
        start.mesh.positions.push_back(surface.mesh.position(t, k));
        start.source_from_vertex.push_back(
            surface.source_from_vertex[surface.mesh.triangles[t][k]]);
      }
      corners[k] = v;
    }
    start.mesh.triangles.push_back(corners);
    start.source_from_triangle.push_back(t);
    if (mesh.has_uvs()) start.mesh.corner_uvs.push_back(mesh.corner_uvs[t]);
    if (!mesh.textures.empty()) start.mesh.textures.push_back(mesh.textures[t]);
  }
  start.mesh.uvs = mesh.uvs;
  return start;
}

}  // namespace

CleanMesh cleaned(const Mesh& mesh, double least_part) {
  Surface surface = make_surface(mesh);
  require(surface.area > 0,
          "the mesh has no triangle with an area: check that it is a mesh, and not cut short");
  CleanMesh clean = part_of(surface, sound_triangles(surface, least_part), mesh);
  Defects defects = std::move(surface.defects);
  for (;;) {
    require(!clean.mesh.triangles.empty(),
            "the mesh has no triangle with an area: check that it is a mesh, and not cut short");
    // What was left out may have held together what are two vertices, or two parts, now.
    surface = make_surface(clean.mesh, {.kind = WeldOptions::Kind::none});
    CleanMesh next = part_of(surface, sound_triangles(surface, least_part), clean.mesh);
    for (int& source : next.source_from_vertex) source = clean.source_from_vertex[source];
    for (int& source : next.source_from_triangle) source = clean.source_from_triangle[source];
    const bool same = next.mesh.triangle_count() == clean.mesh.triangle_count();
    clean = std::move(next);
    if (!same) continue;
    clean.defects = std::move(defects);
    return clean;
  }
}

TrackTarget::TrackTarget(const Mesh& mesh, const Signal& colours,
                         const std::vector<char>& measured) {
  require(measured.empty() || std::ssize(measured) == mesh.vertex_count(),
          "what is measured of a frame needs an entry per vertex");
  require(colours.size() == 0 || colours.rows() == mesh.vertex_count(),
          fmt::format("{} rows of colours were given for {} vertices", colours.rows(),
                      mesh.vertex_count()));
  CleanMesh clean = cleaned(mesh);
  surface_ = make_surface(clean.mesh, {.kind = WeldOptions::Kind::none});
  if (colours.size() > 0) {
    colours_.resize(surface_.mesh.vertex_count(), colours.cols());
    for (int v = 0; v < surface_.mesh.vertex_count(); ++v)
      colours_.row(v) = colours.row(clean.source_from_vertex[v]);
  }
  normals_ = vertex_normals(surface_.mesh);
  closest_ = std::make_unique<ClosestPointFinder>(surface_.mesh);
  diagonal_ = bounding_box(surface_.mesh).diagonal();
  for (int v = 0; v < surface_.mesh.vertex_count(); ++v)
    if (measured.empty() || measured[clean.source_from_vertex[v]])
      measured_.push_back(v);
  require(!measured_.empty(), "no vertex of the frame is measured");
  source_from_triangle_ = std::move(clean.source_from_triangle);
  defects_ = std::move(clean.defects);
}

std::vector<Vector3> unfolded_onto(const TrackTarget& target, Mesh mesh) {
  const std::vector<Vector3> folded = std::exchange(mesh.positions, unfolded(mesh));
  std::vector<int> moved;
  std::vector<Vector3> points;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (mesh.positions[v] != folded[v]) moved.push_back(v), points.push_back(mesh.positions[v]);
  if (moved.empty()) return folded;
  const std::vector<Vector3> normals = vertex_normals(mesh);
  const std::vector<ClosestPoint> there = target.closest()(points);
  const Mesh& other = target.surface().mesh;
  for (std::size_t i = 0; i < moved.size(); ++i)
    if (normals[moved[i]].dot(triangle_normal(other, there[i].triangle)) > alike)
      mesh.positions[moved[i]] = point_at(other, there[i]);
  return unfolded(mesh);
}

SurfaceDistance surface_distance(const Mesh& tracked, const TrackTarget& target) {
  const ClosestPointFinder on_tracked(tracked);
  std::vector<Vector3> measured;
  for (const int v : target.measured()) measured.push_back(target.surface().mesh.positions[v]);
  return larger(distances_of(target.closest()(tracked.positions), target.diagonal()),
                distances_of(on_tracked(measured), target.diagonal()));
}

SurfaceDistance surface_distance(const std::vector<ClosestPoint>& there, const std::vector<ClosestPoint>& back,
                                 const TrackTarget& target) {
  return larger(distances_of(there, target.diagonal()), distances_of(measured_of(back, target), target.diagonal()));
}

SurfaceDistance mutual_distance(const std::vector<ClosestPoint>& there, const std::vector<ClosestPoint>& back,
                                const TrackTarget& target) {
  return smaller(distances_of(there, target.diagonal()), distances_of(measured_of(back, target), target.diagonal()));
}

Distortion distortion(const std::vector<Triangle>& triangles, std::span<const Vector3> rest,
                      std::span<const Vector3> now) {
  std::vector<std::pair<double, double>> all(triangles.size());
  parallel_for(std::ssize(triangles), [&](std::int64_t t) {
    const Triangle& v = triangles[t];
    const Eigen::Matrix2d F0 = flat(rest[v[0]], rest[v[1]], rest[v[2]]);
    const double area = 0.5 * F0.determinant();
    // Needles and triangles without area have no stretch to speak of.
    if (!(area > 1e-6 * F0.squaredNorm())) return;
    const Eigen::Matrix2d J = flat(now[v[0]], now[v[1]], now[v[2]]) * F0.inverse();
    const Eigen::Vector2d sigma = singular_values(J).values;
    const double worst = std::max(sigma[0], 1 / std::max(sigma[1], 1e-9));
    if (std::isfinite(worst)) all[t] = {worst, area};
  });
  std::erase_if(all, [](const auto& entry) { return entry.second == 0; });
  Distortion result;
  double sum = 0, area = 0;
  for (const auto& [value, weight] : all) sum += value * weight, area += weight;
  if (area > 0) result = {sum / area, percentile(all, 0.95)};
  return result;
}

}  // namespace mq
