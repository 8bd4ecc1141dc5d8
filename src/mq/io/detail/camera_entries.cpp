#include "mq/io/detail/camera_entries.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>

#include "mq/base/error.h"

namespace mq {

Eigen::Matrix3d quaternion_rotation(double w, double x, double y, double z,
                                    const std::string& where) {
  const Eigen::Quaterniond q(w, x, y, z);
  if (!(q.norm() > 1e-6) || !std::isfinite(q.norm()))
    throw IoError(where + ": the quaternion of a rotation has no length");
  return q.normalized().toRotationMatrix();
}

Eigen::Matrix3d rotation_of_matrix(const Eigen::Matrix3d& matrix, const std::string& where) {
  const double volume = matrix.determinant();
  if (matrix.allFinite() && volume > 0 && std::isfinite(volume)) {
    const Eigen::Matrix3d scaled = matrix / std::cbrt(volume);
    if ((scaled * scaled.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-3) {
      const Eigen::JacobiSVD<Eigen::Matrix3d> svd(scaled, Eigen::ComputeFullU | Eigen::ComputeFullV);
      return svd.matrixU() * svd.matrixV().transpose();
    }
  }
  throw IoError(where +
                ": its rotation is no rotation: rows must be orthogonal and of the same length, with a "
                "determinant above 0");
}

void place_camera(PinholeCamera& camera, const Eigen::Matrix4d& world_from_camera, CameraAxes axes,
                  const std::string& where) {
  Eigen::Matrix3d turn = rotation_of_matrix(world_from_camera.topLeftCorner<3, 3>(), where);
  if (axes == CameraAxes::backward_z) turn.rightCols<2>() *= -1;
  camera.rotation = turn.transpose();
  camera.translation = -camera.rotation * world_from_camera.topRightCorner<3, 1>();
}

void check_camera(const PinholeCamera& camera, const std::string& where) {
  const bool sizes = camera.width > 0 && camera.height > 0 && camera.fx > 0 && camera.fy > 0;
  double sum =
      camera.fx + camera.fy + camera.cx + camera.cy + camera.skew + camera.translation.sum();
  for (const LensNumber& number : lens_numbers()) sum += camera.lens.*number.value;
  if (!sizes || !std::isfinite(sum) || !camera.rotation.allFinite())
    throw IoError(
        fmt::format("{}: found a width of {}, a height of {} and focal lengths of {} and {}; a "
                    "camera needs all of them above 0, and finite numbers",
                    where, camera.width, camera.height, camera.fx, camera.fy));
  const Eigen::Matrix3d& R = camera.rotation;
  if ((R * R.transpose() - Eigen::Matrix3d::Identity()).norm() > 1e-4 || R.determinant() < 0)
    throw IoError(where +
                  ": its rotation is no rotation: rows must be orthogonal, of unit length, "
                  "with determinant 1");
}

int camera_side(double pixels) {
  return pixels >= 1 && pixels <= most_camera_pixels ? int(pixels) : 0;
}

}  // namespace mq
