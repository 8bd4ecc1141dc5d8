#pragma once
/// The camera of a photograph: a pinhole with a lens that distorts.

#include <Eigen/Core>

#include <optional>

#include "mq/draw/camera.h"

namespace mq {

/// A point X of the model goes to (x, y, z) = rotation·X + translation, x to the right, y down, z
/// forward, then with (a, b) = (x, y) / z and r² = a² + b² to
///
///     a' = a (1 + k1 r² + k2 r⁴ + k3 r⁶) + 2 p1 a b + p2 (r² + 2a²),
///     b' = b (1 + k1 r² + k2 r⁴ + k3 r⁶) + p1 (r² + 2b²) + 2 p2 a b,
///
/// and to the place (fx a' + cx, fy b' + cy) of the picture, pixel (i, j) covering [i, i + 1] ×
/// [j, j + 1] from the upper left: the conventions of OpenCV's lenses and of COLMAP's pictures.
struct PinholeCamera {
  int width = 0, height = 0;  ///< pixels
  double fx = 0, fy = 0;      ///< focal lengths, pixels
  double cx = 0, cy = 0;      ///< principal point, pixels
  double k1 = 0, k2 = 0, k3 = 0, p1 = 0, p2 = 0;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Vector3 translation = Vector3::Zero();

  /// Where it stands, in the model.
  Vector3 center() const { return -rotation.transpose() * translation; }

  /// The place in the picture; nothing behind the camera, outside the picture, and where distortion
  /// has turned back on itself, so that the lens shows another point there.
  std::optional<Vector2> project(const Vector3& point) const;
};

/// That of a picture drawn by `Renderer`. Throws `InvalidInput` for orthographic projection.
PinholeCamera pinhole_of(const Camera& camera);

/// The same camera for the picture at another size. Throws `InvalidInput` where the proportions
/// differ by more than a pixel.
PinholeCamera scaled(const PinholeCamera& camera, int width, int height);

}  // namespace mq
