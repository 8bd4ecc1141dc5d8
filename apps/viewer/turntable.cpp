// The film is at depth 1 before the eye, `tangent` of half the field of view up from its middle on
// the pane's shorter side.
#include "turntable.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "mq/mesh/geometry.h"

namespace mq::view {
namespace {

constexpr double radians = std::numbers::pi / 180;

double pixel_at_depth_1(const View& view, int width, int height) {
  return 2 * std::tan(view.field_of_view / 2 * radians) / std::min(width, height);
}

}  // namespace

void Turntable::look(const Mesh& mesh, const View& view, int width, int height) {
  resize(width, height);
  view_ = view;
  const Camera camera(mesh, view, width, height);
  const Box box = bounding_box(mesh);
  const Vector3 eye = camera.ray(width / 2.0, height / 2.0).origin;
  const double extent = box.diagonal() > 0 ? box.diagonal() : 1;
  distance_ = std::max(backward().dot(eye - (box.low + box.high) / 2), 0.05 * extent);
  target_ = eye - distance_ * backward();
}

void Turntable::look_at(const Vector3& place, double extent) {
  target_ = place;
  distance_ = extent / (pixel_at_depth_1(view_, width_, height_) * std::min(width_, height_));
}

void Turntable::look_from(const View& view) {
  view_.azimuth = view.azimuth, view_.elevation = view.elevation, view_.up = view.up;
  look_at(*view.target, view.extent);
}

void Turntable::turn(double right, double up) {
  view_.azimuth = std::remainder(view_.azimuth + right, 360.0);
  view_.elevation = std::clamp(view_.elevation + up, -90.0, 90.0);
}

void Turntable::approach(double factor) { distance_ /= factor; }

void Turntable::move(double right_by, double down_by) {
  target_ += pixel() * (down_by * up() - right_by * right());
}

Vector3 Turntable::right() const {
  View level = view_;
  level.elevation = 0;
  level.azimuth += 90;
  return direction_of(level);
}

double Turntable::pixel() const { return distance_ * pixel_at_depth_1(view_, width_, height_); }

Ray Turntable::ray(double x, double y) const {
  const double side = pixel_at_depth_1(view_, width_, height_);
  const Vector3 film = (x - width_ / 2.0) * side * right() + (height_ / 2.0 - y) * side * up();
  return {eye(), (film - backward()).normalized()};
}

bool Turntable::shows(const Vector3& point, double& x, double& y) const {
  const Vector3 offset = point - eye();
  const double depth = -backward().dot(offset);
  if (!(depth > 0)) return false;
  const double side = pixel_at_depth_1(view_, width_, height_) * depth;
  x = width_ / 2.0 + right().dot(offset) / side;
  y = height_ / 2.0 - up().dot(offset) / side;
  return true;
}

Eigen::Matrix4f Turntable::clip(const Vector3& origin, double radius) const {
  const Vector3 offset = origin - eye();
  const double depth = -backward().dot(offset);
  const double far = std::max(depth + radius, 1e-6 * distance_) * 1.001;
  const double near = std::max({(depth - radius) * 0.999, 1e-3 * distance_, 1e-5 * far});
  const double side = pixel_at_depth_1(view_, width_, height_);
  Eigen::Matrix4d clip = Eigen::Matrix4d::Zero();
  const auto row = [&](int r, const Vector3& axis, double scale, double shift) {
    clip.row(r) << scale * axis.transpose(), scale * axis.dot(offset) + shift;
  };
  row(0, right(), 2 / (side * width_), 0);
  row(1, up(), 2 / (side * height_), 0);
  row(2, -backward(), (far + near) / (far - near), -2 * far * near / (far - near));
  row(3, -backward(), 1, 0);
  return clip.cast<float>();
}

}  // namespace mq::view
