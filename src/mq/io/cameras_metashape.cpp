// Metashape's cameras (File > Export > Export Cameras, Agisoft XML), as its manual describes them
// (appendix "Camera models"): sensors with a calibration, cameras with a matrix from their axes (x to
// the right, y down, z forward) to the chunk's, and a transform of the chunk, or of its component, to
// the coordinates that models are exported in. With x, y, r as in `Lens`
//
//   x' = x R + (P1 (r² + 2x²) + 2 P2 x y)(1 + P3 r² + P4 r⁴),
//   y' = y R + (P2 (r² + 2y²) + 2 P1 x y)(1 + P3 r² + P4 r⁴),
//   u = w/2 + cx + x' f + x' B1 + y' B2,     v = h/2 + cy + y' f,
//
// so that P1 and P2 are p2 and p1 here, and B2 is the skew.
#include <fmt/format.h>

#include <map>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/io/bytes.h"
#include "mq/io/detail/camera_entries.h"
#include "mq/io/detail/xml_read.h"

namespace mq {
namespace {

namespace fs = std::filesystem;

const char* const metashape = "cameras that Metashape exported as XML";

/// Reads one chunk.
class ChunkReader {
 public:
  ChunkReader(const XmlFile& file, const pugi::xml_node& chunk, CameraEntries& entries)
      : file_(file), chunk_(chunk), entries_(entries) {}

  void read() {
    for (const pugi::xml_node& sensor : chunk_.child("sensors").children("sensor"))
      sensors_[sensor.attribute("id").as_string()] = sensor;
    world_from_chunk_[""] = transform_of(chunk_.child("transform"));
    for (const pugi::xml_node& component : chunk_.child("components").children("component"))
      world_from_chunk_[component.attribute("id").as_string()] =
          transform_of(component.child("transform"));
    read_cameras_of(chunk_.child("cameras"));
    for (const pugi::xml_node& group : chunk_.child("cameras").children("group")) read_cameras_of(group);
    note();
  }

 private:
  /// Rotation, translation and scale; the identity where the chunk has none.
  Eigen::Matrix4d transform_of(const pugi::xml_node& node) const {
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    const pugi::xml_node rotation = node.child("rotation"), translation = node.child("translation");
    const double scale = file_.number(node, "scale", 1);
    if (!(scale > 0)) file_.refuse(node, fmt::format("scale: found {}, wanted more than 0", scale));
    if (rotation) {
      const auto r = file_.numbers(rotation, rotation.text().get(), 9, "rotation");
      for (int k = 0; k < 9; ++k) matrix(k / 3, k % 3) = r[std::size_t(k)];
    }
    matrix.topLeftCorner<3, 3>() *= scale;
    if (translation) {
      const auto t = file_.numbers(translation, translation.text().get(), 3, "translation");
      matrix.topRightCorner<3, 1>() = Vector3(t[0], t[1], t[2]);
    }
    return matrix;
  }

  void read_cameras_of(const pugi::xml_node& list) {
    for (const pugi::xml_node& node : list.children("camera")) {
      const pugi::xml_node transform = node.child("transform");
      if (!transform) {
        ++entries_.without_pose;
        continue;
      }
      CameraEntry entry{node.attribute("label").as_string(), {}, file_.place(node)};
      entry.where += fmt::format(" {}", shown(entry.name));
      const auto m = file_.numbers(transform, transform.text().get(), 16, "transform");
      Eigen::Matrix4d matrix;
      for (int k = 0; k < 16; ++k) matrix(k / 4, k % 4) = m[std::size_t(k)];
      set_lens(node, entry.camera);
      place_camera(entry.camera, world_from(node) * matrix, CameraAxes::forward_z, entry.where);
      entries_.cameras.push_back(std::move(entry));
    }
  }

  /// The component's transform, or the chunk's where it says none.
  const Eigen::Matrix4d& world_from(const pugi::xml_node& camera) const {
    const auto found = world_from_chunk_.find(camera.attribute("component_id").as_string());
    return found == world_from_chunk_.end() ? world_from_chunk_.at("") : found->second;
  }

  /// The adjusted calibration, or the only one.
  pugi::xml_node calibration_of(const pugi::xml_node& sensor) {
    pugi::xml_node any;
    for (const pugi::xml_node& one : sensor.children("calibration")) {
      if (std::string_view(one.attribute("class").as_string()) == "adjusted") return one;
      any = one;
    }
    if (any) ++initial_;
    return any;
  }

  void set_lens(const pugi::xml_node& node, PinholeCamera& camera) {
    const std::string id = node.attribute("sensor_id").as_string();
    const auto sensor = sensors_.find(id);
    if (sensor == sensors_.end())
      file_.refuse(node, fmt::format("names sensor {}, which the chunk has not", shown(id)));
    const pugi::xml_node calibration = calibration_of(sensor->second);
    pugi::xml_node size = calibration.child("resolution");
    if (!size) size = sensor->second.child("resolution");
    if (!calibration.child("f") || !size)
      file_.refuse(sensor->second,
                   "wanted a calibration with f, and a resolution: align the photographs first, or "
                   "export by a version of Metashape (1.2 or newer) that writes them");
    const auto number = [&](const char* name) { return file_.number(calibration, name, 0); };
    camera.width = camera_side(size.attribute("width").as_double());
    camera.height = camera_side(size.attribute("height").as_double());
    camera.fy = number("f"), camera.fx = camera.fy + number("b1"), camera.skew = number("b2");
    camera.cx = camera.width / 2.0 + number("cx"), camera.cy = camera.height / 2.0 + number("cy");
    camera.lens = {.projection = projection_of(sensor->second, calibration),
                   .k1 = number("k1"),
                   .k2 = number("k2"),
                   .k3 = number("k3"),
                   .k4 = number("k4"),
                   .p1 = number("p2"),
                   .p2 = number("p1"),
                   .p3 = number("p3"),
                   .p4 = number("p4")};
  }

  Lens::Projection projection_of(const pugi::xml_node& sensor,
                                 const pugi::xml_node& calibration) const {
    std::string type = calibration.attribute("type").as_string();
    if (type.empty()) type = sensor.attribute("type").as_string("frame");
    if (type == "frame") return Lens::Projection::perspective;
    if (type == "fisheye" || type == "equidistant_fisheye") return Lens::Projection::fisheye;
    if (type == "equisolid_fisheye") return Lens::Projection::equisolid;
    throw Unsupported(fmt::format("{}: type: found {}, wanted frame, fisheye or equisolid_fisheye",
                                  file_.place(calibration), shown(type)));
  }

  void note() {
    const std::string label = chunk_.attribute("label").as_string();
    const std::string_view reference = chunk_.child("reference").text().get();
    if (!reference.empty() && !reference.starts_with("LOCAL_CS"))
      entries_.notes.push_back(fmt::format(
          "{}: its reference system is {}: cameras are in geocentric coordinates, and a mesh must be in "
          "them too; export both in local coordinates",
          file_.place(chunk_), shown(reference)));
    if (initial_ > 0)
      entries_.notes.push_back(fmt::format("{}: {} of sensors that were not calibrated: their initial "
                                           "calibration is taken",
                                           file_.place(chunk_), counted(initial_, "camera")));
  }

  const XmlFile& file_;
  pugi::xml_node chunk_;
  CameraEntries& entries_;
  std::map<std::string, pugi::xml_node, std::less<>> sensors_;
  std::map<std::string, Eigen::Matrix4d, std::less<>> world_from_chunk_;  ///< by component
  int initial_ = 0;
};

}  // namespace

CameraEntries read_metashape(const fs::path& path) {
  const Bytes bytes = read_file(path);
  const XmlFile file(path.string(), bytes, metashape);
  CameraEntries entries{"Metashape", path.parent_path(), {}, 0, {}, {path}};
  int chunks = 0;
  for (const pugi::xml_node& chunk : file.root().children("chunk")) {
    if (++chunks > 1)
      file.refuse(chunk, "found a second chunk, and one mesh is of one: export the cameras of one chunk");
    ChunkReader(file, chunk, entries).read();
  }
  if (chunks == 0 || std::string_view(file.root().name()) != "document")
    throw IoError(fmt::format("{}: found <{}> without <chunk>, wanted <document> with {}",
                              path.string(), shown(file.root().name()), metashape));
  return entries;
}

}  // namespace mq
