// The radius r of the projection grows with θ; what a lens shows is unique as long as r R(r²) grows
// too. With q = r² and R = N/D that is
//
//   d(r R)/dr · D² = (N + 2 q N') D − 2 q N D' > 0 on [0, q],
//
// which without D is 1 + 3 k1 q + 5 k2 q² + 7 k3 q³ + 9 k4 q⁴ > 0: certain where 1 is more than what
// the negative terms take at q, as each of them grows with q. Else it is looked at in steps.

#include "mq/draw/pinhole.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "mq/base/error.h"

namespace mq {
namespace {

constexpr std::array<LensNumber, 14> numbers = {{{"shape", &Lens::shape},
                                                 {"k1", &Lens::k1},
                                                 {"k2", &Lens::k2},
                                                 {"k3", &Lens::k3},
                                                 {"k4", &Lens::k4},
                                                 {"d1", &Lens::d1},
                                                 {"d2", &Lens::d2},
                                                 {"d3", &Lens::d3},
                                                 {"p1", &Lens::p1},
                                                 {"p2", &Lens::p2},
                                                 {"p3", &Lens::p3},
                                                 {"p4", &Lens::p4},
                                                 {"s1", &Lens::s1},
                                                 {"s2", &Lens::s2}}};

double numerator(const Lens& l, double q) { return 1 + q * (l.k1 + q * (l.k2 + q * (l.k3 + q * l.k4))); }

/// N + 2 q N'.
double numerator_slope(const Lens& l, double q) {
  return 1 + q * (3 * l.k1 + q * (5 * l.k2 + q * (7 * l.k3 + q * 9 * l.k4)));
}

double denominator(const Lens& l, double q) { return 1 + q * (l.d1 + q * (l.d2 + q * l.d3)); }

bool grows_at(const Lens& l, double q) {
  const double below = denominator(l, q);
  const double slope = q * (l.d1 + q * (2 * l.d2 + q * 3 * l.d3));  // q D'
  return below > 0 && numerator_slope(l, q) * below - 2 * numerator(l, q) * slope > 0;
}

/// Whether r R grows from the axis to r = √q.
bool grows_until(const Lens& l, double q) {
  constexpr int steps = 32;
  if (l.d1 == 0 && l.d2 == 0 && l.d3 == 0) {
    const double taken = q * (std::min(0.0, 3 * l.k1) +
                              q * (std::min(0.0, 5 * l.k2) +
                                   q * (std::min(0.0, 7 * l.k3) + q * std::min(0.0, 9 * l.k4))));
    if (1 + taken > 0) return true;
  }
  for (int s = steps; s > 0; --s)  // from the outside, where it is likeliest to have turned
    if (!grows_at(l, q * s / steps)) return false;
  return true;
}

/// The radius that is `across` from the axis, of a direction that goes `ahead` along it.
std::optional<double> radius_of(const Lens& lens, double across, double ahead) {
  using Projection = Lens::Projection;
  const double w = lens.shape;
  switch (lens.projection) {
    case Projection::fisheye: return std::atan2(across, ahead);
    case Projection::equisolid: return 2 * std::sin(std::atan2(across, ahead) / 2);
    case Projection::division: {
      const double square = ahead * ahead - 4 * w * across * across;
      const double below = ahead + std::sqrt(square);
      if (!(square >= 0 && below > 0)) return std::nullopt;
      return 2 * across / below;
    }
    default: break;
  }
  if (!(ahead > 0)) return std::nullopt;
  const double tangent = across / ahead;
  return std::abs(w) < 1e-9 ? tangent : std::atan(2 * std::tan(w / 2) * tangent) / w;
}

/// (a, b), before distortion.
std::optional<Vector2> projected_by(const Lens& lens, const Vector3& direction) {
  if (lens.projection == Lens::Projection::perspective) {  // the usual case, without roots
    if (!(direction.z() > 0)) return std::nullopt;
    return Vector2(direction.x() / direction.z(), direction.y() / direction.z());
  }
  const double across = std::hypot(direction.x(), direction.y());
  const std::optional<double> r = radius_of(lens, across, direction.z());
  if (!r || !(across > 0))
    return r && direction.z() > 0 ? std::optional(Vector2(0, 0)) : std::nullopt;
  return Vector2(direction.x() / across * *r, direction.y() / across * *r);
}

}  // namespace

std::span<const LensNumber> lens_numbers() { return numbers; }

std::string projection_name(Lens::Projection projection) {
  switch (projection) {
    case Lens::Projection::fisheye: return "fisheye";
    case Lens::Projection::equisolid: return "equisolid";
    case Lens::Projection::field_of_view: return "field of view";
    case Lens::Projection::division: return "division";
    default: return "perspective";
  }
}

std::string lens_text(const Lens& lens) {
  std::string text;
  for (const LensNumber& number : numbers)
    if (lens.*number.value != 0) text += (text.empty() ? ", " : " ") + std::string(number.name);
  return projection_name(lens.projection) + text;
}

std::optional<Vector2> Lens::image(const Vector3& direction) const {
  const std::optional<Vector2> bent = projected_by(*this, direction);
  if (!bent) return std::nullopt;
  const double a = bent->x(), b = bent->y(), q = a * a + b * b;
  if (!grows_until(*this, q)) return std::nullopt;
  const double radial = numerator(*this, q) / denominator(*this, q);
  const double outwards = 1 + q * (p3 + q * p4);
  return Vector2(a * radial + (2 * p1 * a * b + p2 * (q + 2 * a * a)) * outwards + s1 * q,
                 b * radial + (p1 * (q + 2 * b * b) + 2 * p2 * a * b) * outwards + s2 * q);
}

Correction::Corners Correction::around(double across, double down) const {
  const double x = std::clamp(across, 0.0, 1.0) * (columns - 1), y = std::clamp(down, 0.0, 1.0) * (rows - 1);
  const int column = std::min(int(x), columns - 2), row = std::min(int(y), rows - 2);
  const double u = x - column, v = y - row;
  const int first = row * columns + column;
  return {{first, first + 1, first + columns, first + columns + 1},
          {(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v}};
}

Vector2 Correction::at(double across, double down) const {
  const Corners corners = around(across, down);
  Vector2 offset(0, 0);
  for (std::size_t k = 0; k < 4; ++k) offset += corners.weights[k] * offsets[std::size_t(corners.points[k])];
  return offset;
}

std::optional<Vector2> PinholeCamera::uncorrected(const Vector3& point) const {
  const std::optional<Vector2> image = lens.image(rotation * point + translation);
  if (!image) return std::nullopt;
  return Vector2(fx * image->x() + skew * image->y() + cx, fy * image->y() + cy);
}

std::optional<Vector2> PinholeCamera::project(const Vector3& point) const {
  std::optional<Vector2> place = uncorrected(point);
  if (place && !correction.empty()) *place += width * correction.at(place->x() / width, place->y() / height);
  if (!place || !(place->x() >= 0 && place->y() >= 0 && place->x() <= width && place->y() <= height))
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

StandingCamera standing(const PinholeCamera& camera) {
  return {.rotation = camera.rotation,
          .center = camera.center(),
          .focal = (camera.fx + camera.fy) / 2,
          .middle = {camera.cx, camera.cy},
          .width = camera.width,
          .height = camera.height};
}

PinholeCamera scaled(const PinholeCamera& camera, int width, int height) {
  const double x = double(width) / camera.width, y = double(height) / camera.height;
  require(std::abs(x * camera.height - height) <= 1 || std::abs(y * camera.width - width) <= 1,
          fmt::format("the camera is of pictures of {} × {}, and the picture {} × {}", camera.width,
                      camera.height, width, height));
  PinholeCamera result = camera;
  result.width = width, result.height = height;
  result.fx *= x, result.cx *= x, result.skew *= x;
  result.fy *= y, result.cy *= y;
  return result;
}

}  // namespace mq
