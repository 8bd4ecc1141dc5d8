#pragma once
/// The camera of a photograph: a centre, a direction, and a lens that distorts.

#include <Eigen/Core>

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mq/draw/camera.h"

namespace mq {

/// Where a lens shows a direction, in focal lengths from the principal point. A direction (x, y, z),
/// z forward, at the angle θ from the axis, has the radius
///
///     perspective    tan θ                            fisheye    θ
///     field_of_view  atan(2 tan(ω/2) tan θ) / ω       equisolid  2 sin(θ/2)
///     division       u with tan θ = u / (1 + k u²)
///
/// ω and k being `shape`, and with (a, b) of that radius towards (x, y), r² = a² + b²,
///
///     R  = (1 + k1 r² + k2 r⁴ + k3 r⁶ + k4 r⁸) / (1 + d1 r² + d2 r⁴ + d3 r⁶),
///     a' = a R + (2 p1 a b + p2 (r² + 2a²)) (1 + p3 r² + p4 r⁴) + s1 r²,
///     b' = b R + (p1 (r² + 2b²) + 2 p2 a b) (1 + p3 r² + p4 r⁴) + s2 r².
///
/// Perspective is OpenCV's lens (its k4, k5, k6 are d1, d2, d3), fisheye with k1 to k4 its fisheye;
/// with p and s the thin prism of [weng1992camera]; field_of_view is of [devernay2001straight], division of
/// [fitzgibbon2001simultaneous], p3, p4 and equisolid are Metashape's.
struct Lens {
  enum class Projection { perspective, fisheye, equisolid, field_of_view, division };
  Projection projection = Projection::perspective;
  double shape = 0;  ///< ω of field_of_view, radians, or k of division
  double k1 = 0, k2 = 0, k3 = 0, k4 = 0;
  double d1 = 0, d2 = 0, d3 = 0;
  double p1 = 0, p2 = 0, p3 = 0, p4 = 0;
  double s1 = 0, s2 = 0;

  bool operator==(const Lens&) const = default;

  /// (a', b'). Nothing where the lens sees nothing: behind it (but fisheyes and divisions see what
  /// they see there), and where distortion has turned back on itself, R r no longer growing with r,
  /// so that another direction is shown there.
  std::optional<Vector2> image(const Vector3& direction) const;
};

/// The numbers of a lens by their names, `shape` first.
struct LensNumber {
  const char* name;
  double Lens::*value;
};
std::span<const LensNumber> lens_numbers();

/// "perspective", "fisheye", "equisolid", "field of view", "division".
std::string projection_name(Lens::Projection projection);

/// The projection's name and the numbers that are not 0: "perspective, k1 k2 p1 p2".
std::string lens_text(const Lens& lens);

/// Displacements over a picture, bilinear between the points of a lattice whose outermost lie on the
/// picture's edges: what neither lens nor pose explains, such as a mesh that is off ([zhou2014color]'s control
/// lattice). None without points.
struct Correction {
  int columns = 0, rows = 0;     ///< of the lattice, two at least
  std::vector<Vector2> offsets;  ///< row by row, in widths of the picture

  bool empty() const { return offsets.empty(); }

  /// The four points around a place, given as parts of the picture's width and height, and their weights.
  struct Corners {
    std::array<int, 4> points;
    std::array<double, 4> weights;
  };
  Corners around(double across, double down) const;

  /// In widths of the picture.
  Vector2 at(double across, double down) const;
};

/// A point X of the model goes to (x, y, z) = rotation·X + translation, x to the right, y down, z
/// forward, by its lens to (a', b') and to the place (fx a' + skew b' + cx, fy b' + cy) of the
/// picture, pixel (i, j) covering [i, i + 1] × [j, j + 1] from the upper left: the conventions of
/// OpenCV's lenses and of COLMAP's pictures. From there `correction` moves it.
struct PinholeCamera {
  int width = 0, height = 0;  ///< pixels
  double fx = 0, fy = 0;      ///< focal lengths, pixels
  double cx = 0, cy = 0;      ///< principal point, pixels
  double skew = 0;            ///< pixels
  Lens lens = {};
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Vector3 translation = Vector3::Zero();
  Correction correction = {};

  /// Where it stands, in the model.
  Vector3 center() const { return -rotation.transpose() * translation; }

  /// The place in the picture; nothing where the lens shows nothing, and outside the picture.
  std::optional<Vector2> project(const Vector3& point) const;

  /// The same before it is corrected, which may lie outside.
  std::optional<Vector2> uncorrected(const Vector3& point) const;
};

/// That of a picture drawn by `Renderer`. Throws `InvalidInput` for orthographic projection.
PinholeCamera pinhole_of(const Camera& camera);

/// The same without its lens' distortion, skew and correction, and with square pixels.
StandingCamera standing(const PinholeCamera& camera);

/// The same camera for the picture at another size. Throws `InvalidInput` where the proportions
/// differ by more than a pixel.
PinholeCamera scaled(const PinholeCamera& camera, int width, int height);

}  // namespace mq
