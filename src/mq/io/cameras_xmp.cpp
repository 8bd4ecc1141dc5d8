// RealityCapture's (RealityScan's) sidecars, as "RealityCapture XMP Camera Math" describes them: rows of
// the rotation from the model's axes to the camera's (x to the right, y down, z forward), and where it
// stands. With the longer side s of the picture, f = FocalLength35mm s / 36, x and y of `Lens`,
//
//   u = w/2 + f x' + Skew s y' + PrincipalPointU s,     v = h/2 + AspectRatio f y' + PrincipalPointV s,
//
// and k1 k2 k3 k4 t1 t2 as DistortionCoeficients (so spelled), t1 and t2 being p2 and p1 here. The
// division model is applied after the calibration, in a way that could not be confirmed, and refused
// but with k1 = 0.
#include <fmt/format.h>

#include <algorithm>

#include "mq/base/error.h"
#include "mq/io/bytes.h"
#include "mq/io/detail/camera_entries.h"
#include "mq/io/detail/xml_read.h"
#include "mq/io/file_names.h"

namespace mq {
namespace {

namespace fs = std::filesystem;

const char* const wanted_sidecar = "a sidecar of RealityCapture";

std::string_view without_prefix(std::string_view name) {
  const std::size_t colon = name.rfind(':');
  return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

/// The first element of that name, whatever its prefix, within.
pugi::xml_node element_within(const pugi::xml_node& root, std::string_view name) {
  return root.find_node([&](const pugi::xml_node& node) { return without_prefix(node.name()) == name; });
}

/// Values of a sidecar, which are attributes or elements.
class Sidecar {
 public:
  Sidecar(const XmlFile& file, pugi::xml_node description)
      : file_(file), description_(std::move(description)) {}

  std::string text(std::string_view name) const {
    for (const pugi::xml_attribute& one : description_.attributes())
      if (without_prefix(one.name()) == name) return one.as_string();
    for (const pugi::xml_node& one : description_.children())
      if (without_prefix(one.name()) == name) return one.text().as_string();
    return "";
  }

  std::vector<double> numbers(const std::string& name, std::size_t count) const {
    return file_.numbers(description_, text(name), count, name);
  }

  double number(const std::string& name, double otherwise) const {
    return text(name).empty() ? otherwise : numbers(name, 1)[0];
  }

  [[noreturn]] void refuse(const std::string& what) const { file_.refuse(description_, what); }
  std::string place() const { return file_.place(description_); }

 private:
  const XmlFile& file_;
  pugi::xml_node description_;
};

Lens lens_of(const Sidecar& sidecar) {
  const std::string model = sidecar.text("DistortionModel");
  Lens lens;
  if (model == "perspective" || model.empty()) return lens;
  const std::vector<double> k = sidecar.numbers("DistortionCoeficients", 6);
  if (model == "division" && k[0] == 0) return lens;
  static constexpr const char* known[] = {"brown3", "brown4", "brown3t2", "brown4t2"};
  if (std::ranges::count(known, model) == 0)
    throw Unsupported(fmt::format("{}: DistortionModel: found {}, wanted perspective, brown3, brown4, "
                                  "brown3t2 or brown4t2: choose one of them as the distortion model and "
                                  "align again, or export undistorted pictures",
                                  sidecar.place(), shown(model)));
  lens.k1 = k[0], lens.k2 = k[1], lens.k3 = k[2];
  if (model.starts_with("brown4")) lens.k4 = k[3];
  if (model.ends_with("t2")) lens.p2 = k[4], lens.p1 = k[5];
  return lens;
}

/// False for a sidecar of another program.
bool add_sidecar(const fs::path& path, CameraEntries& entries) {
  const Bytes bytes = read_file(path);
  const XmlFile file(path.string(), bytes, wanted_sidecar);
  const Sidecar values(file, element_within(file.root(), "Description"));
  if (values.text("FocalLength35mm").empty()) return false;
  if (values.text("Rotation").empty() || values.text("Position").empty()) {
    ++entries.without_pose;
    return true;
  }
  CameraEntry entry{path.stem().string(), {}, values.place()};
  const auto r = values.numbers("Rotation", 9), p = values.numbers("Position", 3);
  Eigen::Matrix3d turn;
  for (int k = 0; k < 9; ++k) turn(k / 3, k % 3) = r[std::size_t(k)];
  entry.camera.rotation = rotation_of_matrix(turn, entry.where);
  entry.camera.translation = -entry.camera.rotation * Vector3(p[0], p[1], p[2]);
  entry.camera.lens = lens_of(values);
  const double f = values.number("FocalLength35mm", 0) / 36, aspect = values.number("AspectRatio", 1),
               skew = values.number("Skew", 0), u = values.number("PrincipalPointU", 0),
               v = values.number("PrincipalPointV", 0);
  entry.complete = [=](PinholeCamera& camera) {
    const double side = std::max(camera.width, camera.height);
    camera.fx = f * side, camera.fy = aspect * f * side, camera.skew = skew * side;
    camera.cx = camera.width / 2.0 + u * side, camera.cy = camera.height / 2.0 + v * side;
  };
  entries.cameras.push_back(std::move(entry));
  return true;
}

}  // namespace

std::vector<fs::path> xmp_cameras_in(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
    if (lower_extension(at->path()) == ".xmp") found.push_back(at->path());
  std::ranges::sort(found);
  return found;
}

CameraEntries read_xmp_cameras(const std::vector<fs::path>& sidecars) {
  CameraEntries entries{"RealityCapture", sidecars.front().parent_path(), {}, 0, {}, sidecars};
  int others = 0;
  for (const fs::path& path : sidecars)
    if (!add_sidecar(path, entries)) ++others;
  if (entries.cameras.empty() && entries.without_pose == 0)
    throw IoError(fmt::format("{}: found no xcr:FocalLength35mm, wanted {}",
                              sidecars.front().string(), wanted_sidecar));
  if (others > 0)
    entries.notes.push_back(fmt::format("{}: {} of its .xmp files are of other programs: left aside",
                                        entries.folder.string(), others));
  return entries;
}

}  // namespace mq
