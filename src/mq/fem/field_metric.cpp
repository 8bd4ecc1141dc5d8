// In texel coordinates, with J = dπ/√√|g| of unit density: g_Y = √|g| (JᵀJ + κ² q qᵀ), q = Jᵀ(N ×
// Y), and the determinant of what is in brackets is 1 + κ² qᵀ(JᵀJ)⁻¹q.

#include "mq/fem/field_metric.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "mq/base/error.h"
#include "mq/base/parallel.h"
#include "mq/mesh/geometry.h"

namespace mq {

namespace {

void require_field(const Surface& surface, std::span<const Vector3> field, double kappa) {
  require(std::ssize(field) == surface.triangle_count(),
          fmt::format("a field of {} vectors was given for {} triangles", field.size(),
                      surface.triangle_count()));
  require(kappa >= 0 && std::isfinite(kappa),
          fmt::format("kappa is {}; it must be finite and not negative", kappa));
  for (std::size_t t = 0; t < field.size(); ++t)
    require(field[t].allFinite(), fmt::format("the field is not finite in triangle {}", t));
}

/// dπ of a triangle: a vector in space per texel of x and of y.
Eigen::Matrix<double, 3, 2> derivative(const Surface& surface, const Atlas& atlas, int t) {
  const auto& p = atlas.corners[t];
  const double one = double(TexelPoint::one);
  Eigen::Matrix2d E;
  Eigen::Matrix<double, 3, 2> e;
  for (int k = 0; k < 2; ++k) {
    E.col(k) << double(p[k + 1].x - p[0].x) / one, double(p[k + 1].y - p[0].y) / one;
    e.col(k) = surface.mesh.position(t, k + 1) - surface.mesh.position(t, 0);
  }
  return e * E.inverse();
}

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// N × Y: the field turned by +90°, its normal part lost.
Vector3 turned_field(const Surface& surface, int t, const Vector3& y) {
  return triangle_normal(surface.mesh, t).cross(y);
}

}  // namespace

std::vector<TexelMetric> texel_metrics_across(const Surface& surface, const Atlas& atlas,
                                              std::span<const Vector3> field, double kappa) {
  require_field(surface, field, kappa);
  std::vector<TexelMetric> metrics(field.size());
  parallel_for(std::ssize(field), [&](std::int64_t i) {
    const int t = int(i);
    if (atlas.chart[t] < 0) return;
    TexelMetric& m = metrics[t] = texel_metric(surface, atlas, t);
    // A triangle stretched beyond the limit is integrated as less stretched: so is its field.
    const Vector2 q = derivative(surface, atlas, t).transpose() *
                      turned_field(surface, t, field[t]) / std::sqrt(m.density);
    const double qx = kappa * q.x(), qy = kappa * q.y();
    const double D = 1 + (m.a * qx * qx + 2 * m.b * qx * qy + m.c * qy * qy);
    const double root = std::sqrt(D);
    m.a = (m.a + qy * qy) / root;
    m.b = (m.b - qx * qy) / root;
    m.c = (m.c + qx * qx) / root;
    m.density *= root;
    // Of rounding: the determinant is 1.
    const double scale = std::sqrt((1 + m.b * m.b) / (m.a * m.c));
    m.a *= scale;
    m.c *= scale;
  });
  return metrics;
}

std::vector<TexelMetric> texel_metrics_of_plane(const Atlas& atlas) {
  std::vector<TexelMetric> metrics(atlas.chart.size());
  for (std::size_t t = 0; t < metrics.size(); ++t)
    if (atlas.chart[t] >= 0) metrics[t] = {.density = atlas.surface_area / atlas.texel_area, .a = 1, .b = 0, .c = 1};
  return metrics;
}

std::vector<FlatTriangle> shapes_across(const Surface& surface, std::span<const Vector3> field,
                                        double kappa) {
  require_field(surface, field, kappa);
  std::vector<FlatTriangle> shapes = flat_triangles(surface);
  parallel_for(std::ssize(shapes), [&](std::int64_t i) {
    const int t = int(i);
    if (shapes[t].empty()) return;
    const Vector3 across = kappa * turned_field(surface, t, field[t]);
    const Vector3 first = surface.mesh.position(t, 1) - surface.mesh.position(t, 0);
    const Vector3 second = surface.mesh.position(t, 2) - surface.mesh.position(t, 0);
    const double u = first.dot(across), v = second.dot(across);
    if (u == 0 && v == 0) return;
    shapes[t] = flat_triangle(first.squaredNorm() + u * u, first.dot(second) + u * v,
                              second.squaredNorm() + v * v);
  });
  return shapes;
}

std::vector<FlatTriangle> shapes_across_creases(const Surface& surface,
                                                std::span<const Vector3> normals, double length) {
  require(std::ssize(normals) == surface.mesh.vertex_count(),
          fmt::format("{} normals were given for {} vertices", normals.size(),
                      surface.mesh.vertex_count()));
  require(length >= 0 && std::isfinite(length),
          fmt::format("the length of a metric is {}; it must be finite and not negative", length));
  for (std::size_t v = 0; v < normals.size(); ++v)
    require(normals[v].allFinite(), fmt::format("the normal at vertex {} is not finite", v));
  std::vector<FlatTriangle> shapes = flat_triangles(surface);
  if (length == 0) return shapes;
  parallel_for(std::ssize(shapes), [&](std::int64_t i) {
    const int t = int(i);
    if (shapes[t].empty()) return;
    const Triangle& v = surface.mesh.triangles[t];
    if (normals[v[0]].isZero(0) || normals[v[1]].isZero(0) || normals[v[2]].isZero(0)) return;
    Vector6 first, second;  // Gram–Schmidt keeps the height of a thin triangle
    first << surface.mesh.position(t, 1) - surface.mesh.position(t, 0),
        length * (normals[v[1]] - normals[v[0]]);
    second << surface.mesh.position(t, 2) - surface.mesh.position(t, 0),
        length * (normals[v[2]] - normals[v[0]]);
    if (first.tail<3>().isZero(0) && second.tail<3>().isZero(0)) return;
    const double base = first.norm(), foot = first.dot(second) / base;
    const FlatTriangle shape{base, foot, (second - foot / base * first).norm()};
    if (shape.height >= shapes[t].area() / base) shapes[t] = shape;
  });
  return shapes;
}

}  // namespace mq
