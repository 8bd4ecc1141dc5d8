#include "mq/draw/pinhole.h"

#include <fmt/format.h>

#include <cmath>

#include "mq/base/error.h"

namespace mq {

std::optional<Vector2> PinholeCamera::project(const Vector3& point) const {
  const Vector3 p = rotation * point + translation;
  if (!(p.z() > 0)) return std::nullopt;
  const double a = p.x() / p.z(), b = p.y() / p.z(), r2 = a * a + b * b;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double slope = 1 + r2 * (3 * k1 + r2 * (5 * k2 + r2 * 7 * k3));  // of r·radial along r
  if (!(radial > 0) || !(slope > 0)) return std::nullopt;
  const Vector2 place(fx * (a * radial + 2 * p1 * a * b + p2 * (r2 + 2 * a * a)) + cx,
                      fy * (b * radial + p1 * (r2 + 2 * b * b) + 2 * p2 * a * b) + cy);
  if (!(place.x() >= 0 && place.y() >= 0 && place.x() <= width && place.y() <= height))
    return std::nullopt;
  return place;
}

PinholeCamera pinhole_of(const Camera& camera) {
  const Vector3 forward = -camera.backward();
  const Ray one = camera.ray(0, 0), other = camera.ray(camera.width(), camera.height());
  require(one.origin == other.origin,
          "a pinhole camera needs perspective: the picture's projection is orthographic");
  PinholeCamera pinhole;
  pinhole.width = camera.width(), pinhole.height = camera.height();
  pinhole.fx = pinhole.fy = 1 / camera.pixel_size(1);
  const Camera::Projected middle = camera.project(one.origin + forward);
  pinhole.cx = middle.x, pinhole.cy = middle.y;
  pinhole.rotation.row(0) = camera.right();
  pinhole.rotation.row(1) = -camera.up();
  pinhole.rotation.row(2) = forward;
  pinhole.translation = -pinhole.rotation * one.origin;
  return pinhole;
}

PinholeCamera scaled(const PinholeCamera& camera, int width, int height) {
  const double x = double(width) / camera.width, y = double(height) / camera.height;
  require(std::abs(x * camera.height - height) <= 1 || std::abs(y * camera.width - width) <= 1,
          fmt::format("the camera is of pictures of {} × {}, and the picture {} × {}", camera.width,
                      camera.height, width, height));
  PinholeCamera result = camera;
  result.width = width, result.height = height;
  result.fx *= x, result.cx *= x;
  result.fy *= y, result.cy *= y;
  return result;
}

}  // namespace mq
