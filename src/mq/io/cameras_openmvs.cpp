// OpenMVS' interface files, versions 0 to 7 ("MVSI"): platforms with cameras and poses, then images that
// name one of each. Matrices are rows of doubles, strings and lists a 64-bit count and what they hold.
// A camera at R_c, C_c on a platform at R_p, C_p has the rotation R_c R_p and stands at R_pᵀ C_c + C_p.
// K is in pixels whose middles are whole numbers; where the camera has no size it is divided by the
// longer side of the picture. Pictures are undistorted.
#include <fmt/format.h>

#include <algorithm>

#include "mq/base/error.h"
#include "mq/io/bytes.h"
#include "mq/io/detail/binary_reader.h"
#include "mq/io/detail/camera_entries.h"

namespace mq {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t newest = 7, nothing = 0xFFFFFFFF;
constexpr std::size_t pose_bytes = 12 * sizeof(double);

struct MvsPose {
  Eigen::Matrix3d turn;
  Vector3 center;
};

struct MvsCamera {
  std::uint32_t width = 0, height = 0;
  Eigen::Matrix3d K;
  MvsPose pose;
};

struct Platform {
  std::vector<MvsCamera> cameras;
  std::vector<MvsPose> poses;
};

Eigen::Matrix3d matrix_from(BinaryReader& reader) {
  Eigen::Matrix3d matrix;
  for (int k = 0; k < 9; ++k) matrix(k / 3, k % 3) = reader.number<double>();
  return matrix;
}

MvsPose pose_from(BinaryReader& reader) {
  MvsPose pose;
  pose.turn = matrix_from(reader);
  for (int k = 0; k < 3; ++k) pose.center[k] = reader.number<double>();
  return pose;
}

std::string text_from(BinaryReader& reader) { return reader.text(reader.count(1, "characters")); }

MvsCamera camera_from(BinaryReader& reader, std::uint32_t version) {
  MvsCamera camera;
  text_from(reader);  // its name
  if (version > 3) text_from(reader);  // its band
  if (version > 0) {
    camera.width = reader.number<std::uint32_t>();
    camera.height = reader.number<std::uint32_t>();
  }
  camera.K = matrix_from(reader);
  camera.pose = pose_from(reader);
  return camera;
}

std::vector<Platform> platforms_from(BinaryReader& reader, std::uint32_t version) {
  std::vector<Platform> platforms;
  for (auto left = reader.count(24, "platforms"); left > 0; --left) {
    Platform platform;
    text_from(reader);  // its name
    for (auto more = reader.count(9 * sizeof(double) + pose_bytes, "cameras"); more > 0; --more)
      platform.cameras.push_back(camera_from(reader, version));
    for (auto more = reader.count(pose_bytes, "poses"); more > 0; --more)
      platform.poses.push_back(pose_from(reader));
    platforms.push_back(std::move(platform));
  }
  return platforms;
}

/// The pixels of K, whose size the camera has by now.
void set_matrix(PinholeCamera& camera, const Eigen::Matrix3d& K, double factor) {
  camera.fx = K(0, 0) * factor, camera.fy = K(1, 1) * factor, camera.skew = K(0, 1) * factor;
  camera.cx = K(0, 2) * factor + 0.5, camera.cy = K(1, 2) * factor + 0.5;
}

void set_camera(CameraEntry& entry, const MvsCamera& camera, const MvsPose& pose) {
  const Eigen::Matrix3d platform = rotation_of_matrix(pose.turn, entry.where);
  PinholeCamera& result = entry.camera;
  result.rotation = rotation_of_matrix(camera.pose.turn, entry.where) * platform;
  result.translation =
      -result.rotation * (platform.transpose() * camera.pose.center + pose.center);
  if (camera.width > 0 && camera.height > 0) {
    result.width = camera_side(camera.width), result.height = camera_side(camera.height);
    set_matrix(result, camera.K, 1);
    return;
  }
  entry.complete = [K = camera.K](PinholeCamera& c) {
    set_matrix(c, K, std::max(c.width, c.height));
  };
}

}  // namespace

CameraEntries read_openmvs(const fs::path& path) {
  const Bytes bytes = read_file(path);
  BinaryReader reader(path.string(), bytes);
  std::uint32_t version = 0;
  if (text_of(bytes).starts_with("MVSI")) {
    reader.skip(4);
    version = reader.number<std::uint32_t>();
    reader.skip(4);
  } else if (text_of(bytes).starts_with("MVS")) {
    throw Unsupported(path.string() +
                      ": is OpenMVS' archive, not its interface: save it as that (archive type -1), or "
                      "convert it by InterfaceCOLMAP");
  }
  if (version > newest)
    throw Unsupported(fmt::format("{}: is of version {} of OpenMVS' interface, the newest known here is "
                                  "{}: convert it by InterfaceCOLMAP",
                                  path.string(), version, newest));
  const std::vector<Platform> platforms = platforms_from(reader, version);
  CameraEntries entries{"OpenMVS", path.parent_path(), {}, 0, {}, {path}};
  for (auto left = reader.count(8 + 12, "images"); left > 0; --left) {
    CameraEntry entry{text_from(reader), {}, {}};
    entry.where = fmt::format("{}, {}", path.string(), shown(entry.name));
    if (version > 4) text_from(reader);  // its mask
    const auto platform = reader.number<std::uint32_t>(), camera = reader.number<std::uint32_t>(),
               pose = reader.number<std::uint32_t>();
    if (version > 2) reader.skip(4);  // its number elsewhere
    if (version > 6) {
      reader.skip(3 * sizeof(float));  // depths
      reader.skip(reader.count(24, "neighbours") * 24);
    }
    if (pose == nothing) {
      ++entries.without_pose;
      continue;
    }
    if (platform >= platforms.size() || camera >= platforms[platform].cameras.size() ||
        pose >= platforms[platform].poses.size())
      throw IoError(fmt::format("{}: names platform {}, camera {} and pose {}, which the file has not",
                                entry.where, platform, camera, pose));
    set_camera(entry, platforms[platform].cameras[camera], platforms[platform].poses[pose]);
    entries.cameras.push_back(std::move(entry));
  }
  return entries;
}

}  // namespace mq
