#include "mq/sample/owl.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mq/sample/noise.h"

namespace mq {
namespace {

using std::numbers::pi;

/// Lengths in model units; the owl is about two high. What is left and right comes once, mirrored.
const Vector3 body{0, -0.18, -0.02}, body_radii{0.50, 0.56, 0.44};
const Vector3 head{0, 0.42, 0.0}, head_radii{0.50, 0.40, 0.43};
const Vector3 eye{0.20, 0.44, 0.335};
const Vector3 eye_axis{0.30, 0.02, 0.954};  // the way it looks
constexpr double eye_radius = 0.125, disc_radius = 0.235;
const Vector3 wing{0.43, -0.14, -0.06}, wing_radii{0.15, 0.40, 0.29};
const Vector3 tuft_base{0.25, 0.68, 0.04}, tuft_tip{0.40, 0.92, -0.02};
const Vector3 beak_top{0, 0.38, 0.43}, beak_tip{0, 0.24, 0.50};
constexpr double plinth_top = -0.70, plinth_bottom = -0.92, plinth_radius = 0.46;

Vector3 mirrored(const Vector3& p) { return {std::abs(p.x()), p.y(), p.z()}; }

/// About the distance to an ellipsoid around the origin.
double ellipsoid(const Vector3& p, const Vector3& radii) {
  const double k = p.cwiseQuotient(radii).norm();
  const double l = p.cwiseQuotient(radii.cwiseProduct(radii)).norm();
  return l > 0 ? k * (k - 1) / l : -radii.minCoeff();
}

/// Distance to a cone from a (radius ra) to b (radius rb) with round ends.
double round_cone(const Vector3& p, const Vector3& a, const Vector3& b, double ra, double rb) {
  const double t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (p - a - t * (b - a)).norm() - std::lerp(ra, rb, t);
}

/// Distance to a round slab around the y-axis with edges rounded by r.
double slab(const Vector3& p, double low, double high, double radius, double r) {
  const double x = std::hypot(p.x(), p.z()) - radius + r;
  const double y = std::abs(p.y() - (low + high) / 2) - (high - low) / 2 + r;
  return std::min(std::max(x, y), 0.0) + std::hypot(std::max(x, 0.0), std::max(y, 0.0)) - r;
}

double difference(double a, double b, double k) { return -smooth_union(-a, b, k); }

// ---- Colours ----

struct Color {
  Vector3 value;
  /// Moves the colour towards another, by 0 (not at all) to 1 (all the way).
  void blend(const Vector3& to, double t) { value += t * (to - value); }
};

/// Where a point lies on feathers that hang in rows like tiles, those of every second row between
/// the others: the feather on top there, and the way to its rim.
struct Feather {
  double across;  ///< -½ to ½ over its width
  double along;   ///< 0 at its lowest point, rising
  double rim;     ///< distance to the rim it or the feather above it ends with, in rows
  double number;  ///< something of its own, 0 to 1
};

Feather feather_at(double column, double row, const Noise& noise) {
  const auto center = [&](double k) { return std::fmod(std::abs(k), 2.0) < 1 ? 0.5 : 0.0; };
  const auto across = [&](double k) {
    const double x = column + center(k);
    return x - std::floor(x) - 0.5;
  };
  const auto lowest = [](double x) { return -0.5 - 0.5 * std::sqrt(std::max(0.0, 1 - 4 * x * x)); };
  const double upper = std::floor(row) + 1;
  const double below = upper + lowest(across(upper)) - row;  // how far under the upper row's rim
  const double k = below < 0 ? upper : upper - 1;
  const double x = across(k);
  const double id = noise({std::floor(column + center(k)) * 0.37 + 0.5, k * 0.73 + 0.5, 0.5});
  return {x, row - (k - 1), std::abs(below), 0.5 + 0.5 * id};
}

/// Brown above and behind, cream with bars on the breast. The pattern closes behind, since a whole
/// number of feathers goes around; where they would become narrow, above, it gives way to streaks.
Vector3 plumage(const Vector3& p, const Noise& noise) {
  const double angle = std::atan2(p.x(), p.z()) / (2 * pi);
  const double wobble = 0.10 * noise.octaves(2.5 * p, 3);
  const Feather f = feather_at(26 * angle + wobble, 13 * p.y() + 2 * wobble, noise);
  const double streaks = noise.octaves(p.cwiseProduct(Vector3(42, 12, 42)), 5);
  const double cloud = noise.octaves(1.7 * p + Vector3(3, 3, 3), 4);
  const double feathered = smooth_step(0.72, 0.52, p.y());
  const double breast = smooth_step(-0.02, 0.16, p.z() - 0.9 * std::abs(p.x()) + 0.10 * cloud) *
                        smooth_step(0.36, 0.16, p.y());

  Color back{Vector3(0.46, 0.29, 0.16)};
  back.blend({0.66, 0.46, 0.27}, smooth_step(-0.4, 0.5, cloud + 0.6 * (f.number - 0.5)));
  back.blend({0.83, 0.70, 0.50}, feathered * 0.75 * smooth_step(0.45, 0.05, f.along));
  back.blend({0.27, 0.16, 0.10}, feathered * smooth_step(0.09, 0.02, std::abs(f.across)) *
                                     smooth_step(0.15, 0.45, f.along));
  back.blend({0.13, 0.08, 0.06}, feathered * 0.9 * smooth_step(0.20, 0.03, f.rim));
  back.blend({0.20, 0.12, 0.08}, (1 - feathered) * smooth_step(-0.05, 0.35, streaks));

  Color front{Vector3(0.93, 0.86, 0.71)};
  front.blend({0.84, 0.67, 0.43}, smooth_step(0.0, 0.6, cloud + f.number - 0.5));
  front.blend({0.38, 0.22, 0.13},
              smooth_step(0.16, 0.07, std::abs(f.along - 0.42 - f.across * f.across)) *
                  smooth_step(0.40, 0.30, std::abs(f.across)));
  front.blend({0.68, 0.48, 0.27}, 0.8 * smooth_step(0.16, 0.03, f.rim));
  back.blend(front.value, breast);
  return back.value * (1 + 0.42 * streaks);
}

/// Facial disc, iris and pupil around an eye: rings, and rays that go outward.
void paint_eye(const Vector3& q, const Noise& noise, Color& color) {
  const Vector3 axis = eye_axis.normalized(), d = q - eye;
  const double along = d.dot(axis);
  const Vector3 outward = d - along * axis;
  const double r = outward.norm();
  const double here =
      smooth_step(-0.10, -0.04, along) * smooth_step(disc_radius + 0.065, disc_radius + 0.045, r);
  if (here <= 0) return;
  const Vector3 way = outward / std::max(r, 1e-9);
  const double rays = noise.octaves(9 * way + Vector3(0, 0, 3 * r), 5);
  Color eye_color{Vector3(0.90, 0.81, 0.65)};
  eye_color.blend({0.62, 0.42, 0.25}, smooth_step(-0.15, 0.35, rays));
  eye_color.blend({0.47, 0.28, 0.16}, 0.7 * smooth_step(0.16, 0.13, r));
  const double ring = disc_radius + 0.020 + 0.012 * rays;
  eye_color.blend({0.15, 0.09, 0.06}, smooth_step(0.030, 0.012, std::abs(r - ring)));
  eye_color.blend({0.10, 0.06, 0.05}, smooth_step(0.126, 0.118, r));
  Color iris{Vector3(0.95, 0.60, 0.12)};
  iris.blend({0.74, 0.30, 0.05}, smooth_step(-0.2, 0.4, noise.octaves(14 * way, 4)));
  iris.blend({0.99, 0.83, 0.33}, smooth_step(0.075, 0.062, r));
  eye_color.blend(iris.value, smooth_step(0.112, 0.104, r));
  eye_color.blend({0.03, 0.03, 0.04}, smooth_step(0.060, 0.054, r));
  const double glint = (d - 0.135 * axis - Vector3(-0.028, 0.036, 0)).norm();
  eye_color.blend({0.98, 0.98, 0.96}, smooth_step(0.030, 0.020, glint));
  color.blend(eye_color.value, here);
}

Vector3 horn_color(const Vector3& p, const Noise& noise) {
  const double fibres = noise.octaves(p.cwiseProduct(Vector3(30, 8, 30)), 4);
  Color color{Vector3(0.22, 0.20, 0.20)};
  color.blend({0.72, 0.60, 0.36}, smooth_step(0.30, 0.41, p.y()) + 0.2 * fibres);
  return color.value;
}

/// Marble with veins, and a gilded edge.
Vector3 plinth_color(const Vector3& p, const Noise& noise) {
  const Vector3 warp(noise.octaves(2 * p, 5), noise.octaves(2 * p + Vector3(9, 2, 1), 5),
                     noise.octaves(2 * p + Vector3(4, 7, 2), 5));
  Color color{Vector3(0.10, 0.27, 0.27)};
  color.blend({0.17, 0.40, 0.37}, smooth_step(-0.4, 0.4, noise.octaves(3 * p + warp, 6)));
  const double vein = std::abs(noise.octaves(2.3 * p + 0.8 * warp + Vector3(6, 6, 6), 6));
  color.blend({0.88, 0.90, 0.83}, 0.85 * smooth_step(0.045, 0.0, vein));
  const double gilt = smooth_step(0.022, 0.016, std::abs(p.y() - (plinth_bottom + 0.115)));
  color.blend(Vector3(0.83, 0.64, 0.24) * (1 + 0.25 * warp.x()), gilt);
  return color.value;
}

}  // namespace

double owl_solid(const Vector3& p) {
  const Vector3 q = mirrored(p);
  double d = ellipsoid(p - body, body_radii);
  d = smooth_union(d, ellipsoid(p - head, head_radii), 0.16);
  d = smooth_union(d, round_cone(q, tuft_base, tuft_tip, 0.14, 0.045), 0.12);
  d = smooth_union(d, ellipsoid(q - wing, wing_radii), 0.10);
  // The facial disc is a shallow dish around the eye, the eye a ball in it.
  const Vector3 axis = eye_axis.normalized();
  const double along = (q - eye).dot(axis), around = (q - eye - along * axis).norm();
  d = smooth_union(d, std::hypot(std::max(0.0, around - disc_radius), along - 0.005) - 0.05, 0.06);
  d = difference(d, (q - eye - 0.30 * axis).norm() - 0.27, 0.05);
  d = smooth_union(d, (q - eye - 0.01 * axis).norm() - eye_radius, 0.02);
  d = smooth_union(d, round_cone(p, beak_top, beak_tip, 0.075, 0.02), 0.04);
  d = smooth_union(d, slab(p, plinth_bottom, plinth_top, plinth_radius, 0.05), 0.04);
  return smooth_union(d, slab(p, plinth_bottom, plinth_bottom + 0.10, plinth_radius + 0.10, 0.04),
                      0.03);
}

ColorField owl_colors(std::uint64_t seed) {
  return [noise = Noise(seed)](const Vector3& p, int) -> Vector3 {
    const double plinth = smooth_step(-0.665, -0.690, p.y());
    if (plinth == 1) return plinth_color(p, noise);
    const Vector3 q = mirrored(p);
    Color color{plumage(p, noise)};
    const double tuft = round_cone(q, tuft_base, tuft_tip, 0.14, 0.045);
    color.blend({0.16, 0.10, 0.07},
                0.8 * smooth_step(0.72, 0.88, p.y()) * smooth_step(0.10, 0.02, tuft));
    paint_eye(q, noise, color);
    const double beak = smooth_step(0.018, 0.004, round_cone(p, beak_top, beak_tip, 0.085, 0.03));
    if (beak > 0) color.blend(horn_color(p, noise), beak);
    if (plinth > 0) color.blend(plinth_color(p, noise), plinth);
    return color.value;
  };
}

}  // namespace mq
