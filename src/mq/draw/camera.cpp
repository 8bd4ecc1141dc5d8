// With x right, y up and d forward from the viewer, a pyramid of half-tangents (tx, ty) holds the
// vertex when |x − cx| ≤ tx (d − cd): the eye farthest forward is found from four maxima,
//   A = max(x − tx d), B = max(−x − tx d):   cd = −(A + B) / 2 tx,   cx = (A − B) / 2,
// and the same for y; the smaller cd holds in both directions.

#include "mq/draw/camera.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>

#include "mq/base/error.h"

namespace mq {
namespace {

struct NamedView {
  const char* name;
  double azimuth, elevation;
};

constexpr NamedView named_views[] = {{"front", 0, 0},   {"right", 90, 0}, {"back", 180, 0},
                                     {"left", -90, 0},  {"top", 0, 90},   {"bottom", 0, -90},
                                     {"corner", 30, 20}};

double number(const std::string& text, const std::string& all) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size())
    throw InvalidInput(
        fmt::format("unknown view \"{}\": give front, back, left, right, top, bottom, "
                    "corner, or AZIMUTH,ELEVATION in degrees",
                    all));
  return value;
}

/// Its columns: where right, upright and to the front are, in the model's axes.
Eigen::Matrix3d upright_axes(View::Up up) {
  const Vector3 x = Vector3::UnitX(), y = Vector3::UnitY(), z = Vector3::UnitZ();
  const auto columns = [](const Vector3& right, const Vector3& upright, const Vector3& front) {
    Eigen::Matrix3d axes;
    axes << right, upright, front;
    return axes;
  };
  switch (up) {
    case View::Up::y: return columns(x, y, z);
    case View::Up::z: return columns(x, z, -y);
    case View::Up::x: return columns(-y, x, z);
    case View::Up::minus_x: return columns(y, -x, z);
    case View::Up::minus_y: return columns(x, -y, -z);
    case View::Up::minus_z: return columns(x, -z, y);
  }
  return Eigen::Matrix3d::Identity();
}

}  // namespace

Vector3 from_upright(View::Up up, const Vector3& vector) { return upright_axes(up) * vector; }
Vector3 to_upright(View::Up up, const Vector3& vector) { return upright_axes(up).transpose() * vector; }

const std::vector<std::string>& up_names() {
  static const std::vector<std::string> names = {"y", "z", "x", "-x", "-y", "-z"};
  return names;
}

Vector3 direction_of(const View& view) {
  const double az = view.azimuth * std::numbers::pi / 180,
               el = view.elevation * std::numbers::pi / 180;
  return from_upright(view.up, {std::sin(az) * std::cos(el), std::sin(el), std::cos(az) * std::cos(el)});
}

const std::vector<std::string>& view_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const NamedView& v : named_views) all.push_back(v.name);
    return all;
  }();
  return names;
}

View parse_view(const std::string& text) {
  View view;
  for (const NamedView& v : named_views)
    if (text == v.name) {
      view.azimuth = v.azimuth, view.elevation = v.elevation;
      return view;
    }
  const auto comma = text.find(',');
  view.azimuth = number(text.substr(0, comma), text);
  view.elevation = number(comma == text.npos ? "" : text.substr(comma + 1), text);
  if (!(std::abs(view.azimuth) <= 3600) || !(std::abs(view.elevation) <= 90))
    throw InvalidInput(
        fmt::format("view \"{}\": the elevation is from -90 to 90 degrees, the "
                    "azimuth from -3600 to 3600",
                    text));
  return view;
}

Camera::Camera(const Mesh& mesh, const View& view, int width, int height, int right_inset)
    : width_(width),
      height_(height),
      perspective_(view.projection == View::Projection::perspective) {
  require(width >= 1 && height >= 1 && right_inset >= 0 && right_inset < width,
          "a picture has at least one pixel beside its legend");
  require(mesh.triangle_count() > 0, "the mesh has no triangles: there is nothing to draw");
  require(!perspective_ || (view.field_of_view > 0 && view.field_of_view < 170),
          "the field of view is between 0 and 170 degrees");
  require(std::isfinite(view.azimuth) && std::abs(view.elevation) <= 90 && view.extent >= 0,
          "a view's elevation is from -90 to 90 degrees, its extent not negative");
  if (view.through) {
    stand(*view.through, width - right_inset);
    return;
  }
  const double az = view.azimuth * std::numbers::pi / 180;
  right_ = from_upright(view.up, {std::cos(az), 0, -std::sin(az)});
  backward_ = direction_of(view);
  up_ = backward_.cross(right_);

  // The film of the free part; a shorter side spans the field of view, less the margins.
  const int free = width - right_inset, shorter = std::min(free, height);
  const double tangent = perspective_ ? std::tan(view.field_of_view * std::numbers::pi / 360) : 1;
  const double inner = tangent * (1 - 2 * margin);
  pixel_ = 2 * tangent / shorter;
  const double middle_depth = fit(mesh, inner * free / shorter, inner * height / shorter);
  left_ = -pixel_ * free / 2;
  top_ = pixel_ * height / 2;
  if (view.target || view.extent > 0) zoom(view, middle_depth, free);
}

void Camera::stand(const StandingCamera& camera, int free_width) {
  require(camera.width >= 1 && camera.height >= 1 && camera.focal > 0 && camera.rotation.allFinite() &&
              camera.center.allFinite(),
          "a camera to look through has a place, a direction, a focal length and a size");
  perspective_ = true;
  right_ = camera.rotation.row(0);
  up_ = -camera.rotation.row(1);
  backward_ = -camera.rotation.row(2);
  eye_ = camera.center;
  const double shown = std::min(double(free_width) / camera.width, double(height_) / camera.height);
  pixel_ = 1 / (camera.focal * shown);
  left_ = -pixel_ * (free_width / 2.0 + (camera.middle.x() - camera.width / 2.0) * shown);
  top_ = pixel_ * (height_ / 2.0 + (camera.middle.y() - camera.height / 2.0) * shown);
}

double Camera::fit(const Mesh& mesh, double tangent_x, double tangent_y) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  double right = -infinite, left = right, up = right, down = right;  // the maxima of the equation
  Vector3 low = Vector3::Constant(infinite), high = -low;            // the box in (x, y, d)
  const double slope_x = perspective_ ? tangent_x : 0, slope_y = perspective_ ? tangent_y : 0;
  for (const Triangle& triangle : mesh.triangles)
    for (const int v : triangle) {
      const Vector3& p = mesh.positions[v];
      if (!p.allFinite())
        throw InvalidInput(fmt::format("vertex {} is at a position that is not finite", v));
      const Vector3 q(right_.dot(p), up_.dot(p), -backward_.dot(p));
      right = std::max(right, q.x() - slope_x * q.z()),
      left = std::max(left, -q.x() - slope_x * q.z());
      up = std::max(up, q.y() - slope_y * q.z()), down = std::max(down, -q.y() - slope_y * q.z());
      low = low.cwiseMin(q), high = high.cwiseMax(q);
    }
  // A model without extent still has a picture.
  const double size = std::max({(high - low).maxCoeff(), 1e-9 * low.cwiseAbs().maxCoeff(), 1e-300});
  double d = low.z() - size;
  if (perspective_) {
    // Outside the model even where it is seen from its end.
    d = std::min(
        {-(right + left) / 2 / tangent_x, -(up + down) / 2 / tangent_y, low.z() - 0.05 * size});
  } else {
    pixel_ *= std::max({(right + left) / 2 / tangent_x, (up + down) / 2 / tangent_y, 1e-3 * size});
  }
  eye_ = (right - left) / 2 * right_ + (up - down) / 2 * up_ - d * backward_;
  return (low.z() + high.z()) / 2 - d;
}

/// Moves and narrows the film; the eye stays, so a part looks as it does in the whole.
void Camera::zoom(const View& view, double middle_depth, int free_width) {
  const Vector3 offset = view.target.value_or(eye_ - middle_depth * backward_) - eye_;
  const double depth = -backward_.dot(offset);
  require(offset.allFinite() && (depth > 0 || !perspective_),
          "the place to look at lies behind the viewer, or too far from the model to be seen");
  const double scale = perspective_ ? depth : 1;
  if (view.extent > 0) pixel_ = view.extent / scale / std::min(free_width, height_);
  left_ = right_.dot(offset) / scale - pixel_ * free_width / 2;
  top_ = up_.dot(offset) / scale + pixel_ * height_ / 2;
}

Ray Camera::ray(double x, double y) const {
  const Vector3 film = (left_ + x * pixel_) * right_ + (top_ - y * pixel_) * up_;
  if (!perspective_) return {eye_ + film, -backward_};
  return {eye_, (film - backward_).normalized()};
}

Vector3 Camera::towards_viewer(const Vector3& point) const {
  return perspective_ ? Vector3((eye_ - point).normalized()) : backward_;
}

Camera::Projected Camera::project(const Vector3& point) const {
  const Vector3 offset = point - eye_;
  const double depth = -backward_.dot(offset), scale = perspective_ ? depth : 1;
  return {(right_.dot(offset) / scale - left_) / pixel_, (top_ - up_.dot(offset) / scale) / pixel_,
          depth};
}

double Camera::depth_between(double depth_a, double depth_b, double s) const {
  if (!perspective_) return depth_a + s * (depth_b - depth_a);
  return 1 / ((1 - s) / depth_a + s / depth_b);
}

double Camera::pixel_size(double depth) const { return perspective_ ? pixel_ * depth : pixel_; }

}  // namespace mq
