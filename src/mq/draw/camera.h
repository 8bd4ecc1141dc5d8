#pragma once
/// Where a picture is taken from. Pixels count from the upper left corner of the picture: pixel
/// (i, j) covers [i, i + 1] × [j, j + 1].

#include <optional>
#include <string>
#include <vector>

#include "mq/mesh/mesh.h"

namespace mq {

/// A camera that stands somewhere, with square pixels and a lens that bends nothing: a point p is seen from its centre at
/// (focal x/z + middle), (x, y, z) = rotation·(p − center), x to the right, y down.
struct StandingCamera {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Vector3 center = Vector3::Zero();
  double focal = 1;                   ///< pixels
  Vector2 middle = Vector2::Zero();   ///< pixels
  int width = 1, height = 1;          ///< pixels, of what it sees
  bool operator==(const StandingCamera&) const = default;
};

/// A way of looking at a model, before its size and the picture's are known.
struct View {
  double azimuth = 30;  ///< degrees around the upright axis, from the front towards the model's +x
  double elevation = 20;              ///< degrees above the horizon, -90 to 90
  /// The model's upright axis. The front is +z, but for the axes z (−y), −z (y) and −y (−z).
  enum class Up { y, z, x, minus_x, minus_y, minus_z } up = Up::y;
  enum class Projection { perspective, orthographic } projection = Projection::perspective;
  double field_of_view = 28;      ///< degrees, of the picture's shorter side
  std::optional<Vector3> target;  ///< the point in the middle; none: the model is centred
  double extent = 0;  ///< model units across the picture's shorter side, measured at the
                      ///< target; 0: the model fills the picture
  /// In place of all above, but for `up`: what it sees fills the picture, whose other side shows more.
  std::optional<StandingCamera> through = {};
  bool operator==(const View&) const = default;
};

/// Vectors given by axes of which y is upright and z to the front, in the model's, and back.
Vector3 from_upright(View::Up up, const Vector3& vector);
Vector3 to_upright(View::Up up, const Vector3& vector);

/// "y", "z", "x", "-x", "-y", "-z", in the order of `View::Up`.
const std::vector<std::string>& up_names();

/// "front", "back", "left", "right", "top", "bottom", "corner" (from above, turned), or
/// "AZIMUTH,ELEVATION" in degrees. Throws `InvalidInput`.
View parse_view(const std::string& text);

/// The names `parse_view` knows.
const std::vector<std::string>& view_names();

/// The unit direction from the model to the viewer of an orthographic view.
Vector3 direction_of(const View& view);

struct Ray {
  Vector3 origin;
  Vector3 direction;  ///< unit
};

class Camera {
 public:
  /// Fits the view to all triangles of the mesh: vertices are at least `margin` of the width from
  /// the left and right and of the height from the top and bottom, two on opposite sides exactly
  /// so. What a standing camera sees is centred. `right_inset` pixels on the right are kept free. Throws `InvalidInput` for a mesh without
  /// triangles, with positions that are not finite, or a view out of range.
  Camera(const Mesh& mesh, const View& view, int width, int height, int right_inset = 0);

  static constexpr double margin = 0.04;

  int width() const { return width_; }
  int height() const { return height_; }
  bool is_perspective() const { return perspective_; }
  const Vector3& right() const { return right_; }
  const Vector3& up() const { return up_; }
  const Vector3& backward() const { return backward_; }  ///< from the model to the viewer

  /// The ray through a point of the picture.
  Ray ray(double x, double y) const;

  /// Direction from `point` to the viewer, unit.
  Vector3 towards_viewer(const Vector3& point) const;

  struct Projected {
    double x, y;   ///< pixels
    double depth;  ///< along the viewing direction, model units; positive in front
  };
  Projected project(const Vector3& point) const;

  /// Depth at the fraction s of the way between two projected points, on the screen.
  double depth_between(double depth_a, double depth_b, double s) const;

  /// The side of a pixel at this depth, model units.
  double pixel_size(double depth) const;

 private:
  void stand(const StandingCamera& camera, int free_width);
  double fit(const Mesh& mesh, double tangent_x, double tangent_y);
  void zoom(const View& view, double middle_depth, int free_width);

  int width_, height_;
  bool perspective_;
  Vector3 right_, up_, backward_;
  Vector3 eye_;
  // The film: at depth 1 for perspective, anywhere for orthographic projection.
  double left_ = 0, top_ = 0, pixel_ = 0;
};

}  // namespace mq
