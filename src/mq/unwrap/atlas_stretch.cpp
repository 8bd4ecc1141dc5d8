#include "mq/unwrap/atlas_stretch.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace mq {

AtlasStretch atlas_stretch(const Surface& surface, const std::vector<Vector2>& uvs,
                           const std::vector<Triangle>& corner_uvs, int width, int height) {
  AtlasStretch figures;
  const Mesh& mesh = surface.mesh;
  double uv_area = 0, area = 0;
  struct Singular {
    double area, first, second;
  };
  std::vector<Singular> all;
  const Vector2 size(width, height);
  for (int t = 0; t < surface.triangle_count(); ++t) {
    const Vector3 a = mesh.position(t, 1) - mesh.position(t, 0);
    const Vector3 b = mesh.position(t, 2) - mesh.position(t, 0);
    const double twice = a.cross(b).norm();
    if (surface.degenerate[t] || !(twice > 0)) continue;
    const auto uv = [&](int k) { return Vector2(uvs[corner_uvs[t][k]].cwiseProduct(size)); };
    Eigen::Matrix2d to, from;
    to << uv(1) - uv(0), uv(2) - uv(0);
    const double length = a.norm();
    from << length, a.dot(b) / length, 0, twice / length;
    const Eigen::Matrix2d J = to * from.inverse();
    const double e = (J(0, 0) + J(1, 1)) / 2, f = (J(0, 0) - J(1, 1)) / 2;
    const double g = (J(1, 0) + J(0, 1)) / 2, h = (J(1, 0) - J(0, 1)) / 2;
    const double q = std::hypot(e, h), r = std::hypot(f, g);
    figures.flipped += to.determinant() <= 0;
    uv_area += std::abs(to.determinant()) / 2;
    area += twice / 2;
    all.push_back({twice / 2, q + r, std::abs(q - r)});
  }
  const double scale = std::sqrt(area / uv_area);
  double stretch = 0;
  for (const Singular& s : all) {
    const double first = s.first * scale, second = std::max(s.second * scale, 1e-12);
    stretch += s.area * 0.5 * (1 / (first * first) + 1 / (second * second));
    figures.triangles.push_back({s.area, first / second,
                                 0.5 * std::pow(std::log(first * second), 2),
                                 0.5 * std::pow(std::log(first / second), 2)});
  }
  figures.l2_stretch = std::sqrt(stretch / area);
  figures.occupancy = uv_area / size.prod();
  return figures;
}

}  // namespace mq
