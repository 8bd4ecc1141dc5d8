#pragma once
/// Cameras as a file says them, before their pictures are looked for; and what readers of all formats
/// check alike.

#include <functional>

#include "mq/io/cameras.h"

namespace mq {

inline constexpr int most_camera_pixels = 1'000'000;  ///< of a side of a picture

struct CameraEntry {
  std::string name;  ///< of its picture, as the file says it
  PinholeCamera camera;
  std::string where;  ///< for messages
  std::vector<std::string> other_names = {};  ///< tried in their order where there is no such picture
  /// Given where the file does not say the picture's size: completes the camera with it.
  std::function<void(PinholeCamera&)> complete = {};
};

struct CameraEntries {
  std::string format;
  std::filesystem::path folder;  ///< from which pictures are named
  std::vector<CameraEntry> cameras;
  int without_pose = 0;
  std::vector<std::string> notes;
  std::vector<std::filesystem::path> files;  ///< that were read
};

/// Readers of formats, each in its own source. They throw as `read_camera_set` says.
CameraEntries read_colmap_text(const std::filesystem::path& folder);
CameraEntries read_colmap_binary(const std::filesystem::path& folder);
CameraEntries read_json_cameras(const std::filesystem::path& path);  ///< ours, and of NeRF tools
CameraEntries read_bundler(const std::filesystem::path& path);
CameraEntries read_metashape(const std::filesystem::path& path);
CameraEntries read_xmp_cameras(const std::vector<std::filesystem::path>& sidecars);
CameraEntries read_gltf_cameras(const std::filesystem::path& path);
CameraEntries read_openmvs(const std::filesystem::path& path);

/// The sidecars of a folder that RealityCapture wrote, in the order of their names.
std::vector<std::filesystem::path> xmp_cameras_in(const std::filesystem::path& folder);

/// Writers of formats.
void write_colmap_text(const std::filesystem::path& folder, const std::vector<Photograph>& photographs);
void write_colmap_binary(const std::filesystem::path& folder,
                         const std::vector<Photograph>& photographs);
void write_transforms(const std::filesystem::path& path, const std::vector<Photograph>& photographs);

/// The rotation of a quaternion of any length but 0. Throws `IoError`.
Eigen::Matrix3d quaternion_rotation(double w, double x, double y, double z, const std::string& where);

/// The rotation that a matrix is but for a factor above 0, which makes no difference to a picture, and
/// rounding. Throws `IoError`.
Eigen::Matrix3d rotation_of_matrix(const Eigen::Matrix3d& matrix, const std::string& where);

/// Puts a camera where a matrix from its axes to the model's says; `flipped`: its axes are OpenGL's, y
/// up and looking along −z. Throws `IoError`.
enum class CameraAxes { forward_z, backward_z };
void place_camera(PinholeCamera& camera, const Eigen::Matrix4d& world_from_camera, CameraAxes axes,
                  const std::string& where);

/// Refuses what no camera is.
void check_camera(const PinholeCamera& camera, const std::string& where);

/// A side of a picture, or 0, which `check_camera` refuses, where the number is none.
int camera_side(double pixels);

}  // namespace mq
