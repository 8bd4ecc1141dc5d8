#include "mq/sample/cheap_capture.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "mq/base/random.h"
#include "mq/mesh/geometry.h"
#include "mq/sample/noise.h"

namespace mq {
namespace {

constexpr double alike_edges = 4;       // wide are the features of what is off along normals
constexpr double by_itself = 0.25;      // of that, what a vertex is off by itself
constexpr double ring_over_tube = 2.5;  // radii of a handle

/// A random place in the box of the material, one every `flicker_frames`; they change in different frames.
Vector3 flickering_place(const Random& random, int index, int frame, const Vector3& low,
                         const Vector3& high) {
  const std::uint64_t block = std::uint64_t(frame + index % flicker_frames) / flicker_frames;
  Vector3 place;
  for (int k = 0; k < 3; ++k)
    place[k] = random.uniform(3 * (1024 * block + std::uint64_t(index)) + std::uint64_t(k), low[k],
                              high[k]);
  return place;
}

/// Corners of triangles that are left, at which these form several fans.
std::vector<int> vertices_of_several_fans(const Mesh& mesh, const std::vector<char>& left) {
  Mesh rest;
  rest.positions = mesh.positions;
  for (int t = 0; t < mesh.triangle_count(); ++t)
    if (left[t]) rest.triangles.push_back(mesh.triangles[t]);
  const Surface surface = make_surface(rest, {.kind = WeldOptions::Kind::none});
  std::vector<int> copies(mesh.positions.size(), 0), found;
  for (const int v : surface.source_from_vertex)
    if (++copies[v] == 2) found.push_back(v);
  return found;
}

}  // namespace

void displace(double off, int frame, std::uint64_t seed, Mesh& mesh) {
  if (off == 0) return;
  const double edge = mean_edge_length(make_surface(mesh, {.kind = WeldOptions::Kind::none}));
  const std::vector<Vector3> normals = vertex_normals(mesh);
  const Random random(seed, 3000 + std::uint64_t(frame));
  const Noise noise(random.bits(0));
  std::vector<double> along;
  double squares = 0;
  for (const Vector3& p : mesh.positions) {
    along.push_back(noise(p / (alike_edges * edge)));
    squares += along.back() * along.back();
  }
  const double scale = off * edge / std::sqrt(squares / double(along.size()));
  const double width = by_itself * off * edge * std::sqrt(3.0);
  for (std::size_t v = 0; v < along.size(); ++v) {
    mesh.positions[v] += scale * along[v] * normals[v];
    for (int k = 0; k < 3; ++k)
      mesh.positions[v][k] += random.uniform(1 + 3 * v + std::uint64_t(k), -width, width);
  }
}

std::vector<int> flickering_vertices(const std::vector<Vector3>& material, int count, int frame,
                                     std::uint64_t seed) {
  const Random random(seed, 2000);
  Vector3 low = material[0], high = material[0];
  for (const Vector3& p : material) low = low.cwiseMin(p), high = high.cwiseMax(p);
  std::set<int> found;
  for (int i = 0; i < count; ++i) {
    const Vector3 place = flickering_place(random, i, frame, low, high);
    const auto nearest = std::ranges::min_element(
        material, {}, [&](const Vector3& p) { return (p - place).squaredNorm(); });
    found.insert(int(nearest - material.begin()));
  }
  return {found.begin(), found.end()};
}

std::vector<char> left_by_holes(const Mesh& mesh, const std::vector<Vector3>& places,
                                double radius) {
  std::vector<char> in(mesh.positions.size(), 0), left(mesh.triangles.size(), 1);
  for (std::size_t v = 0; v < in.size(); ++v)
    for (const Vector3& place : places)
      if ((mesh.positions[v] - place).norm() < radius) in[v] = 1;
  for (;;) {
    for (std::size_t t = 0; t < left.size(); ++t)
      for (const int v : mesh.triangles[t])
        if (in[v]) left[t] = 0;
    const std::vector<int> split = vertices_of_several_fans(mesh, left);
    if (split.empty()) return left;
    for (const int v : split) in[v] = 1;
  }
}

Solid with_handles(Solid solid, const std::vector<Vector3>& places,
                   const std::vector<Vector3>& normals, double radius) {
  std::vector<Vector3> axes;
  for (const Vector3& n : normals) axes.push_back(n.unitOrthogonal());
  return [=, solid = std::move(solid)](const Vector3& p) {
    double value = solid(p);
    for (std::size_t i = 0; i < places.size(); ++i) {
      const Vector3 d = p - places[i];
      const double across = d.dot(axes[i]), along = (d - across * axes[i]).norm();
      value = std::min(value, std::hypot(along - radius, across) - radius / ring_over_tube);
    }
    return value;
  };
}

}  // namespace mq
