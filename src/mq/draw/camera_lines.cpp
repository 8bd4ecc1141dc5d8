#include "mq/draw/camera_lines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "mq/base/parallel.h"

namespace mq {
namespace {

/// The angle from the axis that a projection shows at the radius r; π where it shows none there.
double angle_of(const Lens& lens, double r) {
  using Projection = Lens::Projection;
  constexpr double most = std::numbers::pi;
  const double w = lens.shape;
  switch (lens.projection) {
    case Projection::fisheye: return std::min(r, most);
    case Projection::equisolid: return 2 * std::asin(std::min(1.0, r / 2));
    case Projection::division: return std::atan2(r, 1 + w * r * r);
    case Projection::field_of_view:
      if (std::abs(w) < 1e-9) return std::atan(r);
      return std::atan2(std::sin(std::min(r * w, most / 2)),
                        std::cos(std::min(r * w, most / 2)) * 2 * std::tan(w / 2));
    default: return std::atan(r);
  }
}

}  // namespace

Vector3 undistorted_direction(const PinholeCamera& camera, double x, double y) {
  const double b = (y - camera.cy) / camera.fy;
  const double a = (x - camera.cx - camera.skew * b) / camera.fx;
  const double r = std::hypot(a, b), angle = angle_of(camera.lens, r);
  const double across = r > 0 ? std::sin(angle) / r : 0;
  return camera.rotation.transpose() * Vector3(a * across, b * across, std::cos(angle));
}

std::vector<SpaceLine> lines_of_cameras(std::span<const PinholeCamera> cameras, double length,
                                        const Colour& colour) {
  constexpr double beyond = 1.5, roof = 0.25;  // of the length, of the frame's height
  std::vector<SpaceLine> lines;
  for (const PinholeCamera& camera : cameras) {
    const Vector3 eye = camera.center();
    const double w = camera.width, h = camera.height;
    const auto at = [&](double x, double y) -> Vector3 {
      return eye + length * undistorted_direction(camera, x, y);
    };
    const std::array<Vector3, 4> corners = {at(0, 0), at(w, 0), at(w, h), at(0, h)};
    for (std::size_t k = 0; k < 4; ++k) {
      lines.push_back({eye, corners[k], colour});
      lines.push_back({corners[k], corners[(k + 1) % 4], colour});
    }
    lines.push_back({eye, eye + beyond * (at(w / 2, h / 2) - eye), colour});
    const Vector3 top = 0.5 * (corners[0] + corners[1]) + roof * (corners[0] - corners[3]);
    lines.push_back({corners[0], top, colour});
    lines.push_back({top, corners[1], colour});
  }
  return lines;
}

std::vector<int> views_of_triangles(const Mesh& mesh, std::span<const PinholeCamera> cameras,
                                    const Progress& progress) {
  std::vector<int> views(std::size_t(mesh.triangle_count()), 0);
  parallel_blocks(mesh.triangle_count(), 4096, [&](std::int64_t begin, std::int64_t end) {
    progress.check();
    for (std::int64_t t = begin; t < end; ++t) {
      const Vector3 middle =
          (mesh.position(int(t), 0) + mesh.position(int(t), 1) + mesh.position(int(t), 2)) / 3;
      for (const PinholeCamera& camera : cameras) views[std::size_t(t)] += camera.project(middle) ? 1 : 0;
    }
  });
  return views;
}

}  // namespace mq
