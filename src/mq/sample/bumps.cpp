#include "mq/sample/bumps.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "mq/mesh/geometry.h"

namespace mq {

Vector3 bumpy(const Vector3& n, const Vector3& place, const Bumps& bumps) {
  const Vector3 p = 2 * std::numbers::pi / bumps.length * place;
  Vector3 slope(std::sin(p.x() + 1) * std::cos(p.y()), std::sin(p.y() + 2) * std::cos(p.z()),
                std::sin(p.z()) * std::cos(p.x()));
  slope -= slope.dot(n) * n;
  return (n + bumps.height * slope).normalized();
}

Image<float> paint_normals(const Surface& surface, const Atlas& atlas, const Bumps& bumps, double margin, int texture,
                           const Progress& progress) {
  const std::vector<Vector3> normals = vertex_normals(surface.mesh);
  const auto color = [](const Vector3& normal) -> Vector3 { return (normal + Vector3::Ones()) / 2; };
  const SurfaceField field = [&](int t, const Vector3& weights) -> Vector3 {
    Vector3 place = Vector3::Zero(), normal = Vector3::Zero();
    for (int k = 0; k < 3; ++k) {
      place += weights[k] * surface.mesh.position(t, k);
      normal += weights[k] * normals[std::size_t(surface.mesh.triangles[std::size_t(t)][std::size_t(k)])];
    }
    return color(bumpy(normal.normalized(), place, bumps));
  };
  return paint(surface, atlas, field, {.margin = margin, .background = color({0, 0, 1})}, texture, progress);
}

Image<float> paint_normals(const Sample& sample, const Progress& progress) {
  const Surface surface = make_surface(sample.mesh);
  return paint_normals(surface, make_atlas(surface, {sample.texture}), {}, PaintOptions{}.margin, 0, progress);
}

}  // namespace mq
