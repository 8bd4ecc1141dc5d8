#include "mq/mesh/geometry.h"

#include <Eigen/Geometry>
#include <cmath>

#include "mq/base/parallel.h"
#include "mq/mesh/norm.h"

namespace mq {
namespace {

Vector3 area_vector(const Mesh& mesh, int t) {
  const Vector3& p = mesh.position(t, 0);
  return 0.5 * (mesh.position(t, 1) - p).cross(mesh.position(t, 2) - p);
}

}  // namespace

double triangle_area(const Mesh& mesh, int triangle) {
  return safe_norm(area_vector(mesh, triangle));
}

std::vector<double> triangle_areas(const Mesh& mesh) {
  std::vector<double> areas(mesh.triangles.size());
  parallel_for(std::ssize(areas), [&](std::int64_t t) { areas[t] = triangle_area(mesh, int(t)); });
  return areas;
}

double total_area(const Mesh& mesh) {
  double sum = 0;
  for (const double area : triangle_areas(mesh)) sum += area;
  return sum;
}

Vector3 triangle_normal(const Mesh& mesh, int triangle) {
  return safe_unit(area_vector(mesh, triangle));
}

std::vector<Vector3> triangle_normals(const Mesh& mesh) {
  std::vector<Vector3> normals(mesh.triangles.size());
  parallel_for(std::ssize(normals),
               [&](std::int64_t t) { normals[t] = triangle_normal(mesh, int(t)); });
  return normals;
}

Vector3 corner_angles(const Mesh& mesh, int triangle) {
  Vector3 angles;
  for (int k = 0; k < 3; ++k) {
    const Vector3& p = mesh.position(triangle, k);
    const Vector3 a = safe_unit(mesh.position(triangle, (k + 1) % 3) - p);
    const Vector3 b = safe_unit(mesh.position(triangle, (k + 2) % 3) - p);
    angles[k] = std::atan2(a.cross(b).norm(), a.dot(b));
  }
  return angles;
}

std::vector<Vector3> vertex_normals(const Mesh& mesh) {
  std::vector<Vector3> sums(mesh.positions.size(), Vector3::Zero());
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const Vector3 normal = triangle_normal(mesh, t), angles = corner_angles(mesh, t);
    for (int k = 0; k < 3; ++k) sums[mesh.triangles[t][k]] += angles[k] * normal;
  }
  for (Vector3& sum : sums) sum = safe_unit(sum);
  return sums;
}

double mean_edge_length(const Surface& surface) {
  double sum = 0;
  std::int64_t edges = 0;
  for (HalfEdge h = 0; h < 3 * surface.triangle_count(); ++h) {
    if (h < surface.twins[h]) continue;  // counted from the other side
    sum += safe_norm(surface.mesh.position(h / 3, (h % 3 + 1) % 3) -
                     surface.mesh.position(h / 3, h % 3));
    ++edges;
  }
  return edges > 0 ? sum / double(edges) : 0;
}

Box bounding_box(const Mesh& mesh) {
  if (mesh.triangles.empty()) return {};
  Box box{mesh.position(0, 0), mesh.position(0, 0)};
  for (int t = 0; t < mesh.triangle_count(); ++t)
    for (int k = 0; k < 3; ++k) {
      box.low = box.low.cwiseMin(mesh.position(t, k));
      box.high = box.high.cwiseMax(mesh.position(t, k));
    }
  return box;
}

}  // namespace mq
