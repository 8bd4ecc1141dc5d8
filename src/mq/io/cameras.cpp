#include "mq/io/cameras.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "mq/base/error.h"
#include "mq/io/atomic_file.h"
#include "mq/io/bytes.h"
#include "mq/io/json_read.h"

namespace mq {
namespace {

namespace fs = std::filesystem;

constexpr int most_pixels = 1'000'000;  ///< of a side of a picture

Eigen::Matrix3d rotation_of(double w, double x, double y, double z, const std::string& where) {
  const Eigen::Quaterniond q(w, x, y, z);
  if (!(q.norm() > 1e-6) || !std::isfinite(q.norm()))
    throw IoError(where + ": the quaternion of a rotation has no length");
  return q.normalized().toRotationMatrix();
}

/// Refuses what no camera is.
void check(const PinholeCamera& camera, const std::string& where) {
  const bool sizes = camera.width > 0 && camera.height > 0 && camera.fx > 0 && camera.fy > 0;
  const double sum = camera.fx + camera.fy + camera.cx + camera.cy + camera.k1 + camera.k2 +
                     camera.k3 + camera.p1 + camera.p2 + camera.translation.sum();
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

/// COLMAP keeps its models in sparse/0 of a project, or in sparse of undistorted pictures, with the
/// pictures in images beside sparse: so up to two folders further up.
fs::path find_picture(const fs::path& folder, const std::string& name, const std::string& where) {
  const fs::path here = fs::absolute(folder / ".").lexically_normal().parent_path();
  const fs::path above = here.parent_path();
  for (const fs::path& place : {folder / name, folder / "images" / name, above / "images" / name,
                                above / name, above.parent_path() / "images" / name})
    if (fs::exists(place)) return place;
  throw IoError(fmt::format(
      "{}: its picture {} is neither beside it nor in a folder 'images' there or up to two "
      "folders further up: move it, or the file with the cameras",
      where, name));
}

/// A line's words, with the number of the line for messages.
struct Line {
  std::string where;
  std::vector<std::string> words;

  /// A number of pixels; 0, which is refused later, where it is none.
  int pixels(std::size_t k) const {
    const double value = number(k);
    return value >= 1 && value <= most_pixels ? int(value) : 0;
  }

  double number(std::size_t k) const {
    if (k < words.size()) {
      const char* const end = words[k].data() + words[k].size();
      double value = 0;
      const auto [stop, error] = std::from_chars(words[k].data(), end, value);
      if (error == std::errc() && stop == end && std::isfinite(value)) return value;
    }
    throw IoError(fmt::format("{}: word {}: found '{}', wanted a number", where, k + 1,
                              k < words.size() ? words[k] : "the end of the line"));
  }
};

/// Lines that are not comments; empty ones are kept, for in images.txt every second one may be.
std::vector<Line> lines_of(const fs::path& path) {
  const Bytes bytes = read_file(path);
  std::istringstream text{std::string(text_of(bytes))};
  std::vector<Line> lines;
  int count = 0;
  for (std::string line; std::getline(text, line);) {
    ++count;
    if (line.starts_with('#')) continue;
    Line next{fmt::format("{}, line {}", path.string(), count), {}};
    std::istringstream words(line);
    for (std::string word; words >> word;) next.words.push_back(word);
    lines.push_back(std::move(next));
  }
  return lines;
}

/// MODEL's parameters, from word 4 on.
PinholeCamera lens_of(const Line& line) {
  static const std::map<std::string, std::size_t> models = {
      {"SIMPLE_PINHOLE", 3}, {"PINHOLE", 4}, {"SIMPLE_RADIAL", 4},
      {"RADIAL", 5},         {"OPENCV", 8},  {"FULL_OPENCV", 12}};
  const std::string model = line.words.size() > 1 ? line.words[1] : "";
  const auto known = models.find(model);
  if (known == models.end())
    throw Unsupported(
        fmt::format("{}: the lens '{}' is not known here; undistort the pictures first "
                    "(PINHOLE), or use SIMPLE_RADIAL, RADIAL or OPENCV",
                    line.where, model));
  PinholeCamera camera;
  camera.width = line.pixels(2), camera.height = line.pixels(3);
  const auto p = [&](std::size_t k) { return line.number(4 + k); };
  const bool single = model.starts_with("SIMPLE") || model == "RADIAL";
  const std::size_t first = single ? 1 : 2;
  camera.fx = p(0), camera.fy = p(single ? 0 : 1), camera.cx = p(first), camera.cy = p(first + 1);
  if (model == "SIMPLE_RADIAL" || model == "RADIAL") camera.k1 = p(3);
  if (model == "RADIAL") camera.k2 = p(4);
  if (model.ends_with("OPENCV"))
    camera.k1 = p(4), camera.k2 = p(5), camera.p1 = p(6), camera.p2 = p(7);
  if (model == "FULL_OPENCV") {
    camera.k3 = p(8);
    if (p(9) != 0 || p(10) != 0 || p(11) != 0)
      throw Unsupported(line.where +
                        ": FULL_OPENCV with k4, k5 or k6: undistort the pictures first");
  }
  return camera;
}

/// The folder of `project`, or of what COLMAP makes in it, that holds cameras.txt.
fs::path model_of(const fs::path& project) {
  const std::array<fs::path, 3> folders = {project, project / "sparse" / "0", project / "sparse"};
  for (const fs::path& folder : folders)
    if (fs::exists(folder / "cameras.txt")) return folder;
  for (const fs::path& folder : folders)
    if (fs::exists(folder / "cameras.bin"))
      throw Unsupported(fmt::format(
          "{}: is COLMAP's binary format; wanted its text: colmap model_converter --input_path {} "
          "--output_path {} --output_type TXT",
          (folder / "cameras.bin").string(), folder.string(), folder.string()));
  throw IoError(
      fmt::format("{}: has no cameras.txt, nor has sparse/0 or sparse in it; wanted a "
                  "folder with COLMAP's text export, or a JSON file with cameras",
                  project.string()));
}

std::vector<Photograph> read_colmap(const fs::path& folder) {
  std::map<std::string, PinholeCamera> lenses;
  for (const Line& line : lines_of(folder / "cameras.txt"))
    if (!line.words.empty()) lenses[line.words[0]] = lens_of(line);
  std::vector<Photograph> photographs;
  const std::vector<Line> lines = lines_of(folder / "images.txt");
  for (std::size_t i = 0; i < lines.size(); i += 2) {  // every second holds the picture's points
    const Line& line = lines[i];
    if (line.words.empty() && i + 1 >= lines.size()) break;
    if (line.words.size() < 10)
      throw IoError(line.where + ": wanted IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME");
    const auto lens = lenses.find(line.words[8]);
    if (lens == lenses.end())
      throw IoError(line.where + ": cameras.txt has no camera " + line.words[8]);
    Photograph photograph{{}, lens->second};
    photograph.camera.rotation =
        rotation_of(line.number(1), line.number(2), line.number(3), line.number(4), line.where);
    photograph.camera.translation = Vector3(line.number(5), line.number(6), line.number(7));
    check(photograph.camera, line.where);
    std::string name = line.words[9];
    for (std::size_t k = 10; k < line.words.size(); ++k) name += " " + line.words[k];
    photograph.picture = find_picture(folder, name, line.where);
    photographs.push_back(std::move(photograph));
  }
  return photographs;
}

Photograph photograph_of(const JsonObject& json, const fs::path& folder) {
  Photograph photograph;
  PinholeCamera& camera = photograph.camera;
  camera.width = json.whole("width", 1, most_pixels);
  camera.height = json.whole("height", 1, most_pixels);
  camera.fx = json.number("fx"), camera.fy = json.number("fy", camera.fx);
  camera.cx = json.number("cx", camera.width / 2.0);
  camera.cy = json.number("cy", camera.height / 2.0);
  camera.k1 = json.number("k1", 0), camera.k2 = json.number("k2", 0);
  camera.k3 = json.number("k3", 0);
  camera.p1 = json.number("p1", 0), camera.p2 = json.number("p2", 0);
  if (json.has("quaternion")) {
    const std::vector<double> q = json.numbers("quaternion", 4);
    camera.rotation = rotation_of(q[0], q[1], q[2], q[3], json.place());
  } else {
    const std::vector<double> R = json.rows("rotation", 3, 3);
    for (int k = 0; k < 9; ++k) camera.rotation(k / 3, k % 3) = R[std::size_t(k)];
  }
  const std::vector<double> t = json.numbers("translation", 3);
  camera.translation = Vector3(t[0], t[1], t[2]);
  check(camera, json.place());
  photograph.picture = find_picture(folder, json.text("image"), json.place());
  return photograph;
}

std::vector<Photograph> read_json(const fs::path& path) {
  const std::string wanted =
      "an object with \"cameras\", a list of objects with image, width, height, fx, rotation and "
      "translation, or a folder of COLMAP's text export";
  const Bytes bytes = read_file(path);
  const JsonFile file{path.string(), text_of(bytes),
                      parse_json(path.string(), text_of(bytes), wanted)};
  std::vector<Photograph> photographs;
  for (const JsonObject& camera : JsonObject(file, wanted).objects("cameras"))
    photographs.push_back(photograph_of(camera, path.parent_path()));
  return photographs;
}

}  // namespace

std::vector<Photograph> read_cameras(const fs::path& path) {
  const std::string name = path.filename().string();
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  const bool text = name == "cameras.txt" || name == "images.txt";
  const bool binary = name == "cameras.bin" || name == "images.bin";
  std::vector<Photograph> photographs = fs::is_directory(path) ? read_colmap(model_of(path))
                                        : text                 ? read_colmap(folder)
                                        : binary               ? read_colmap(model_of(folder))
                                                               : read_json(path);
  if (photographs.empty()) throw IoError(path.string() + ": holds no camera");
  return photographs;
}

void write_cameras(const fs::path& path, const std::vector<Photograph>& photographs) {
  nlohmann::ordered_json cameras = nlohmann::ordered_json::array();
  for (const auto& [picture, c] : photographs) {
    const Eigen::Matrix3d& R = c.rotation;
    cameras.push_back(
        {{"image", picture.string()},
         {"width", c.width},
         {"height", c.height},
         {"fx", c.fx},
         {"fy", c.fy},
         {"cx", c.cx},
         {"cy", c.cy},
         {"k1", c.k1},
         {"k2", c.k2},
         {"k3", c.k3},
         {"p1", c.p1},
         {"p2", c.p2},
         {"rotation",
          {{R(0, 0), R(0, 1), R(0, 2)}, {R(1, 0), R(1, 1), R(1, 2)}, {R(2, 0), R(2, 1), R(2, 2)}}},
         {"translation", {c.translation.x(), c.translation.y(), c.translation.z()}}});
  }
  const std::string text = nlohmann::ordered_json{{"cameras", cameras}}.dump(2) + "\n";
  write_file(path, std::as_bytes(std::span(text.data(), text.size())));
}

}  // namespace mq
