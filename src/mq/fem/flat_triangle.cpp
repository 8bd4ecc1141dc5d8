#include "mq/fem/flat_triangle.h"

#include <Eigen/Geometry>

#include <cmath>

#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/mesh/norm.h"

namespace mq {

Eigen::Matrix<double, 3, 2> frame_in_space(const Surface& surface, int t) {
  Eigen::Matrix<double, 3, 2> frame = Eigen::Matrix<double, 3, 2>::Zero();
  if (surface.degenerate[t]) return frame;
  const Vector3 first = surface.mesh.position(t, 1) - surface.mesh.position(t, 0);
  const Vector3 second = surface.mesh.position(t, 2) - surface.mesh.position(t, 0);
  frame.col(0) = safe_unit(first);
  const Vector3 normal = safe_unit(frame.col(0).cross(safe_unit(second)));
  frame.col(1) = normal.cross(Vector3(frame.col(0)));
  return frame;
}

Vector2 FlatTriangle::gradient(int k) const {
  return turned(edge((k + 1) % 3)) / (base * height);
}

double FlatTriangle::half_cotangent(int k) const {
  switch (k) {
    case 0: return 0.5 * foot / height;
    case 1: return 0.5 * (base - foot) / height;
    default: return 0.5 * (height / base - foot / base * ((base - foot) / height));
  }
}

FlatTriangle flat_triangle(const Vector3& first, const Vector3& second) {
  const double base = safe_norm(first);
  if (!(base > 0)) return {};
  const Vector3 along = first / base;
  const FlatTriangle shape{base, along.dot(second), safe_norm(along.cross(second))};
  const bool fits = std::isfinite(shape.half_cotangent(0)) && std::isfinite(shape.half_cotangent(2)) &&
                    std::isfinite(1 / shape.area());
  return fits && !shape.empty() ? shape : FlatTriangle{};
}

FlatTriangle flat_triangle(double uu, double uv, double vv) {
  const double determinant = uu * vv - uv * uv;
  require(uu > 0 && determinant > 0, fmt::format("the metric ({}, {}; {}, {}) of a triangle is not "
                                                 "positive definite", uu, uv, uv, vv));
  const double base = std::sqrt(uu);
  return {base, uv / base, std::sqrt(determinant) / base};
}

std::vector<FlatTriangle> flat_triangles(const Surface& surface) {
  std::vector<FlatTriangle> shapes(surface.triangle_count());
  const Mesh& mesh = surface.mesh;
  parallel_for(surface.triangle_count(), [&](std::int64_t i) {
    const int t = int(i);
    if (!surface.degenerate[t])
      shapes[t] = flat_triangle(mesh.position(t, 1) - mesh.position(t, 0),
                                mesh.position(t, 2) - mesh.position(t, 0));
  });
  return shapes;
}

std::vector<Vector3> field_in_space(const Surface& surface, const Eigen::VectorXd& field) {
  require(field.size() == 2 * surface.triangle_count(),
          fmt::format("a field of {} components was given for {} triangles, which have two each",
                      field.size(), surface.triangle_count()));
  std::vector<Vector3> vectors(surface.triangle_count());
  parallel_for(surface.triangle_count(), [&](std::int64_t t) {
    vectors[t] = frame_in_space(surface, int(t)) * field.segment<2>(2 * t);
  });
  return vectors;
}

Eigen::VectorXd field_in_frames(const Surface& surface, const std::vector<Vector3>& field) {
  require(int(field.size()) == surface.triangle_count(),
          fmt::format("a field of {} vectors was given for {} triangles", field.size(),
                      surface.triangle_count()));
  Eigen::VectorXd components(2 * surface.triangle_count());
  parallel_for(surface.triangle_count(), [&](std::int64_t t) {
    components.segment<2>(2 * t) = frame_in_space(surface, int(t)).transpose() * field[t];
  });
  return components;
}

}  // namespace mq
