// Cameras in JSON: our own, and transforms.json of NeRF tools (instant-ngp, nerfstudio). The latter has
// matrices from the camera's axes, y up and looking along −z as in OpenGL, to the model's; intrinsics
// for all frames at the top, or of a frame by itself, as OpenCV means them; k3 and k4 of OPENCV
// continue the polynomial of k1 and k2, as nerfstudio has it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "mq/base/error.h"
#include "mq/io/atomic_file.h"
#include "mq/io/bytes.h"
#include "mq/io/detail/camera_entries.h"
#include "mq/io/json_read.h"

namespace mq {
namespace {

namespace fs = std::filesystem;
using Projection = Lens::Projection;

// ---- Our own ----

Projection named_projection(const JsonObject& json) {
  if (!json.has("lens")) return Projection::perspective;
  const std::string name = json.text("lens");
  std::string known;
  for (const Projection projection :
       {Projection::perspective, Projection::fisheye, Projection::equisolid,
        Projection::field_of_view, Projection::division}) {
    if (name == projection_name(projection)) return projection;
    known += (known.empty() ? "" : ", ") + projection_name(projection);
  }
  throw IoError(
      fmt::format("{}: lens: found {}, wanted one of {}", json.place(), shown(name), known));
}

CameraEntry entry_of_object(const JsonObject& json) {
  CameraEntry entry{"", {}, json.place()};
  PinholeCamera& camera = entry.camera;
  camera.width = json.whole("width", 1, most_camera_pixels);
  camera.height = json.whole("height", 1, most_camera_pixels);
  camera.fx = json.number("fx"), camera.fy = json.number("fy", camera.fx);
  camera.cx = json.number("cx", camera.width / 2.0);
  camera.cy = json.number("cy", camera.height / 2.0);
  camera.skew = json.number("skew", 0);
  camera.lens.projection = named_projection(json);
  for (const LensNumber& number : lens_numbers())
    camera.lens.*number.value = json.number(number.name, 0);
  if (json.has("quaternion")) {
    const std::vector<double> q = json.numbers("quaternion", 4);
    camera.rotation = quaternion_rotation(q[0], q[1], q[2], q[3], json.place());
  } else {
    const std::vector<double> R = json.rows("rotation", 3, 3);
    for (int k = 0; k < 9; ++k) camera.rotation(k / 3, k % 3) = R[std::size_t(k)];
  }
  const std::vector<double> t = json.numbers("translation", 3);
  camera.translation = Vector3(t[0], t[1], t[2]);
  entry.name = json.text("image");
  return entry;
}

// ---- transforms.json ----

/// A frame, and the whole file, which speaks for frames that are silent.
struct Frame {
  const JsonObject& frame;
  const JsonObject& file;

  const JsonObject* with(const std::string& name) const {
    return frame.has(name) ? &frame : file.has(name) ? &file : nullptr;
  }
  double number(const std::string& name, double otherwise) const {
    const JsonObject* const place = with(name);
    return place ? place->number(name) : otherwise;
  }
};

/// What needs the picture's size: 0 stands for what the file leaves out.
struct Intrinsics {
  double fx = 0, fy = 0, angle_x = 0, angle_y = 0, cx = 0, cy = 0;
  bool has_cx = false, has_cy = false;

  void complete(PinholeCamera& camera) const {
    const auto focal = [](double given, double angle, int side) {
      return given > 0 || angle == 0 ? given : side / (2 * std::tan(angle / 2));
    };
    const double x = focal(fx, angle_x, camera.width), y = focal(fy, angle_y, camera.height);
    camera.fx = x != 0 ? x : y;
    camera.fy = y != 0 ? y : x;
    camera.cx = has_cx ? cx : camera.width / 2.0;
    camera.cy = has_cy ? cy : camera.height / 2.0;
  }
};

/// The lens as its words mean it: those of which numbers, and from what angles.
Lens transforms_lens(const Frame& frame) {
  const JsonObject* const naming = frame.with("camera_model");
  const JsonObject* const flag = frame.with("is_fisheye");
  std::string model = naming ? naming->text("camera_model") : "OPENCV";
  if (!naming && flag && flag->truth("is_fisheye")) model = "OPENCV_FISHEYE";
  static constexpr const char* perspective[] = {"OPENCV", "PINHOLE", "SIMPLE_PINHOLE",
                                                "SIMPLE_RADIAL", "RADIAL"};
  static constexpr const char* fisheye[] = {"OPENCV_FISHEYE", "FISHEYE", "SIMPLE_RADIAL_FISHEYE",
                                            "RADIAL_FISHEYE"};
  Lens lens;
  if (std::ranges::count(fisheye, model) > 0)
    lens.projection = Projection::fisheye;
  else if (std::ranges::count(perspective, model) == 0)
    throw Unsupported(fmt::format("{}: camera_model: found {}, wanted OPENCV, OPENCV_FISHEYE or "
                                  "PINHOLE: undistort the pictures first",
                                  naming->place(), shown(model)));
  for (const char* name : {"k5", "k6"})
    if (frame.number(name, 0) != 0)
      throw Unsupported(
          fmt::format("{}: {}: no lens known here has it", frame.with(name)->place(), name));
  lens.k1 = frame.number("k1", 0), lens.k2 = frame.number("k2", 0);
  lens.k3 = frame.number("k3", 0), lens.k4 = frame.number("k4", 0);
  lens.p1 = frame.number("p1", 0), lens.p2 = frame.number("p2", 0);
  return lens;
}

CameraEntry entry_of_frame(const JsonObject& json, const JsonObject& file) {
  const Frame frame{json, file};
  CameraEntry entry{json.text("file_path"), {}, json.place()};
  entry.camera.lens = transforms_lens(frame);
  const std::vector<double> m = json.rows("transform_matrix", 4, 4);
  Eigen::Matrix4d matrix;
  for (int k = 0; k < 16; ++k) matrix(k / 4, k % 4) = m[std::size_t(k)];
  place_camera(entry.camera, matrix, CameraAxes::backward_z, entry.where);
  const Intrinsics intrinsics{
      frame.number("fl_x", 0), frame.number("fl_y", 0), frame.number("camera_angle_x", 0),
      frame.number("camera_angle_y", 0), frame.number("cx", 0), frame.number("cy", 0),
      frame.with("cx") != nullptr, frame.with("cy") != nullptr};
  if (intrinsics.fx == 0 && intrinsics.angle_x == 0 && intrinsics.fy == 0 && intrinsics.angle_y == 0)
    throw IoError(entry.where + ": found no \"fl_x\" and no \"camera_angle_x\", wanted one of them, "
                                "here or for all frames");
  const JsonObject *const w = frame.with("w"), *const h = frame.with("h");
  if (w && h) {
    entry.camera.width = w->whole("w", 1, most_camera_pixels);
    entry.camera.height = h->whole("h", 1, most_camera_pixels);
    intrinsics.complete(entry.camera);
  } else {
    entry.complete = [intrinsics](PinholeCamera& camera) { intrinsics.complete(camera); };
  }
  return entry;
}

nlohmann::ordered_json matrix_json(const PinholeCamera& camera) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = camera.rotation.transpose();
  matrix.block<3, 2>(0, 1) *= -1;
  matrix.topRightCorner<3, 1>() = camera.center();
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (int r = 0; r < 4; ++r)
    rows.push_back({matrix(r, 0), matrix(r, 1), matrix(r, 2), matrix(r, 3)});
  return rows;
}

nlohmann::ordered_json intrinsics_json(const PinholeCamera& c) {
  return {{"w", c.width},      {"h", c.height},     {"fl_x", c.fx},      {"fl_y", c.fy},
          {"cx", c.cx},        {"cy", c.cy},        {"k1", c.lens.k1},   {"k2", c.lens.k2},
          {"k3", c.lens.k3},   {"k4", c.lens.k4},   {"p1", c.lens.p1},   {"p2", c.lens.p2}};
}

/// Refuses what transforms.json has no word for.
void check_words(const Photograph& photograph, const Lens& first) {
  const PinholeCamera& camera = photograph.camera;
  const Lens& lens = camera.lens;
  const bool fisheye = lens.projection == Projection::fisheye;
  Lens sayable{.projection = lens.projection, .k1 = lens.k1, .k2 = lens.k2, .k3 = lens.k3, .k4 = lens.k4};
  if (!fisheye) sayable.p1 = lens.p1, sayable.p2 = lens.p2;
  if (!(sayable == lens) || camera.skew != 0 || !(fisheye || lens.projection == Projection::perspective))
    throw Unsupported(fmt::format(
        "{}: transforms.json has no word for its lens ({}{}): write our own JSON, or undistort the picture",
        photograph.picture.string(), lens_text(lens), camera.skew == 0 ? "" : ", skew"));
  if (lens.projection != first.projection)
    throw Unsupported(fmt::format("{}: is {}, and the first {}: transforms.json has one camera_model for all",
                                  photograph.picture.string(), projection_name(lens.projection),
                                  projection_name(first.projection)));
}

}  // namespace

CameraEntries read_json_cameras(const fs::path& path) {
  const std::string wanted =
      "an object with \"cameras\", a list of objects with image, width, height, fx, rotation and "
      "translation, or one with \"frames\" of NeRF tools";
  const Bytes bytes = read_file(path);
  const JsonFile file{path.string(), text_of(bytes),
                      parse_json(path.string(), text_of(bytes), wanted)};
  const JsonObject top(file, wanted);
  CameraEntries entries{"JSON", path.parent_path(), {}, 0, {}, {path}};
  if (top.has("frames")) {
    entries.format = "transforms.json";
    for (const JsonObject& frame : top.objects("frames"))
      entries.cameras.push_back(entry_of_frame(frame, top));
    if (top.has("applied_transform") || top.has("applied_scale"))
      entries.notes.push_back(
          path.string() +
          ": its cameras have been moved (applied_transform): they are read as they stand, for a mesh "
          "in the same place");
    return entries;
  }
  for (const JsonObject& camera : top.objects("cameras"))
    entries.cameras.push_back(entry_of_object(camera));
  return entries;
}

void write_transforms(const fs::path& path, const std::vector<Photograph>& photographs) {
  if (photographs.empty()) throw InvalidInput(path.string() + ": there is no camera to write");
  nlohmann::ordered_json frames = nlohmann::ordered_json::array(), top;
  const PinholeCamera& first = photographs.front().camera;
  const nlohmann::ordered_json common = intrinsics_json(first);
  const bool same = std::ranges::all_of(
      photographs, [&](const Photograph& one) { return intrinsics_json(one.camera) == common; });
  for (const Photograph& photograph : photographs) {
    check_words(photograph, first.lens);
    nlohmann::ordered_json frame = {{"file_path", photograph.picture.generic_string()}};
    if (!same) frame.update(intrinsics_json(photograph.camera));
    frame["transform_matrix"] = matrix_json(photograph.camera);
    frames.push_back(std::move(frame));
  }
  top["camera_model"] =
      first.lens.projection == Projection::fisheye ? "OPENCV_FISHEYE" : "OPENCV";
  if (same) top.update(common);
  top["frames"] = frames;
  write_file(path, bytes_of(top.dump(2) + "\n"));
}

}  // namespace mq
