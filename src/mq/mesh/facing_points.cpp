#include "mq/mesh/facing_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/mesh/geometry.h"

namespace mq {

FacingPoints::Side::Side(const Mesh& of) : mesh(of), normals(vertex_normals(of)), closest(of) {}

Vector3 FacingPoints::Side::point(int triangle, const Vector3& barycentric) const {
  Vector3 p = Vector3::Zero();
  for (int k = 0; k < 3; ++k) p += barycentric[k] * mesh.position(triangle, k);
  return p;
}

Vector3 FacingPoints::Side::normal(int triangle, const Vector3& barycentric) const {
  Vector3 n = Vector3::Zero();
  for (int k = 0; k < 3; ++k) n += barycentric[k] * normals[mesh.triangles[triangle][k]];
  return n.stableNormalized();
}

FacingPoints::FacingPoints(const Mesh& surface, const Mesh& other,
                               const FacingPointsOptions& options)
    : surface_(surface), other_(other) {
  require(options.most_distance > 0 && options.most_angle > 0 && options.most_angle <= 180,
          fmt::format("points of another surface no farther than {} diagonals and turned by no more than {} "
                      "degrees: wanted both above 0, and 180 at most",
                      options.most_distance, options.most_angle));
  const double diagonal = bounding_box(other).diagonal();
  radius_ = options.most_distance * diagonal;
  least_cosine_ = std::cos(options.most_angle * std::numbers::pi / 180);
  std::vector<double> distances(surface.positions.size());
  parallel_for(
      std::ssize(distances),
      [&](std::int64_t v) {
        const ClosestPoint found =
            facing(other_, surface.positions[v], surface_.normals[v].stableNormalized());
        distances[v] = found.triangle < 0 ? radius_ : std::sqrt(found.squared_distance);
      },
      256);
  const auto middle = distances.begin() + std::ssize(distances) / 2;
  std::ranges::nth_element(distances, middle);
  accuracy_ = std::max(*middle, 1e-7 * diagonal);
}

ClosestPoint FacingPoints::facing(const Side& side, const Vector3& point,
                                    const Vector3& normal) const {
  return side.closest.among(point, radius_, [&](const ClosestPoint& found) {
    return side.normal(found.triangle, found.barycentric).dot(normal) >= least_cosine_;
  });
}

ClosestPoint FacingPoints::operator()(int triangle, const Vector3& barycentric) const {
  const Vector3 p = surface_.point(triangle, barycentric);
  const ClosestPoint found = facing(other_, p, surface_.normal(triangle, barycentric));
  const double distance = std::sqrt(found.squared_distance);
  if (found.triangle < 0 || distance <= 2 * accuracy_) return found;
  const ClosestPoint back = facing(surface_, other_.point(found.triangle, found.barycentric),
                                   other_.normal(found.triangle, found.barycentric));
  if (back.triangle >= 0 && distance > 2 * (std::sqrt(back.squared_distance) + accuracy_))
    return {};
  return found;
}

}  // namespace mq
