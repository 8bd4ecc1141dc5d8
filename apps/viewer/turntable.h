#pragma once
/// The camera of the surface pane: it turns around a point, comes nearer, and moves sideways.

#include <Eigen/Core>

#include "mq/draw/camera.h"

namespace mq::view {

class Turntable {
 public:
  /// The view that `marquetry render` draws of the mesh in a picture of this size.
  void look(const Mesh& mesh, const View& view, int width, int height);

  /// At a place, from where it is, `extent` model units across the pane's shorter side.
  void look_at(const Vector3& place, double extent);

  /// From where this view has it, which has a target and an extent.
  void look_from(const View& view);

  /// By degrees: to the right around the model, and up.
  void turn(double right, double up);
  /// The middle comes nearer by this factor.
  void approach(double factor);
  /// The model follows the mouse by so many pixels.
  void move(double right, double down);
  void resize(int width, int height) { width_ = width, height_ = height; }

  const View& view() const { return view_; }
  Vector3 eye() const { return target_ + distance_ * backward(); }
  Vector3 right() const;
  Vector3 up() const { return backward().cross(right()); }
  Vector3 backward() const { return direction_of(view_); }  ///< from the model to the viewer
  double distance() const { return distance_; }  ///< from the eye to what it turns around
  /// The side of a pixel at the target, model units.
  double pixel() const;

  /// The ray through a point of the pane, pixels from the upper left.
  Ray ray(double x, double y) const;
  /// Where a point is shown, pixels; false where it is behind the viewer.
  bool shows(const Vector3& point, double& x, double& y) const;

  /// Clip coordinates of points given relative to `origin`, all within `radius` of it.
  Eigen::Matrix4f clip(const Vector3& origin, double radius) const;

 private:
  View view_;
  Vector3 target_ = Vector3::Zero();
  double distance_ = 1;
  int width_ = 1, height_ = 1;
};

}  // namespace mq::view
