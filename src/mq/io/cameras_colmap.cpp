// COLMAP's models. A picture's pose is that from the model's axes to the camera's, x to the right, y
// down, z forward; places in pictures count from the outer corner of the upper left pixel. The rigs
// and frames that newer versions write beside say the same poses once more.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <charconv>
#include <cmath>
#include <map>
#include <sstream>

#include "mq/base/error.h"
#include "mq/io/atomic_file.h"
#include "mq/io/bytes.h"
#include "mq/io/detail/binary_reader.h"
#include "mq/io/detail/camera_entries.h"
#include "mq/io/detail/colmap_lens.h"

namespace mq {
namespace {

namespace fs = std::filesystem;

/// A line's words, with the number of the line for messages.
struct Line {
  std::string where;
  std::vector<std::string> words;

  double number(std::size_t k) const {
    if (k < words.size()) {
      const char* const end = words[k].data() + words[k].size();
      double value = 0;
      const auto [stop, error] = std::from_chars(words[k].data(), end, value);
      if (error == std::errc() && stop == end && std::isfinite(value)) return value;
    }
    throw IoError(fmt::format("{}: word {}: found {}, wanted a number", where, k + 1,
                              k < words.size() ? shown(words[k]) : "the end of the line"));
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

/// MODEL, WIDTH, HEIGHT and the model's parameters, from word 1 on.
PinholeCamera camera_of_line(const Line& line) {
  const ColmapModel& model = colmap_model(line.words.size() > 1 ? line.words[1] : "", line.where);
  PinholeCamera camera;
  camera.width = camera_side(line.number(2)), camera.height = camera_side(line.number(3));
  std::vector<double> values;
  for (std::size_t k = 0; k < model.parameters.size(); ++k) values.push_back(line.number(4 + k));
  set_colmap_parameters(camera, model, values);
  return camera;
}

CameraEntry entry_of_line(const Line& line, const std::map<std::string, PinholeCamera>& lenses) {
  if (line.words.size() < 10)
    throw IoError(line.where + ": wanted IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME");
  const auto lens = lenses.find(line.words[8]);
  if (lens == lenses.end())
    throw IoError(line.where + ": cameras.txt has no camera " + shown(line.words[8]));
  CameraEntry entry{line.words[9], lens->second, line.where};
  for (std::size_t k = 10; k < line.words.size(); ++k) entry.name += " " + line.words[k];
  entry.camera.rotation =
      quaternion_rotation(line.number(1), line.number(2), line.number(3), line.number(4), line.where);
  entry.camera.translation = Vector3(line.number(5), line.number(6), line.number(7));
  return entry;
}

std::map<std::uint32_t, PinholeCamera> binary_lenses(const fs::path& path) {
  constexpr std::size_t least = 24 + 3 * sizeof(double);
  const Bytes bytes = read_file(path);
  BinaryReader reader(path.string(), bytes);
  std::map<std::uint32_t, PinholeCamera> lenses;
  for (std::uint64_t left = reader.count(least, "cameras"); left > 0; --left) {
    const std::string where = reader.place();
    const auto id = reader.number<std::uint32_t>();
    const ColmapModel& model = colmap_model(reader.number<std::int32_t>(), where);
    PinholeCamera camera;
    camera.width = camera_side(double(reader.number<std::uint64_t>()));
    camera.height = camera_side(double(reader.number<std::uint64_t>()));
    std::vector<double> values;
    for (std::size_t k = 0; k < model.parameters.size(); ++k)
      values.push_back(reader.number<double>());
    set_colmap_parameters(camera, model, values);
    if (!lenses.emplace(id, camera).second)
      throw IoError(fmt::format("{}: found camera {} twice", where, id));
  }
  return lenses;
}

template <class Number>
void append_numbers(Bytes& bytes, std::initializer_list<Number> numbers) {
  for (const Number number : numbers) append_raw(bytes, number);
}

/// Cameras and pictures as they are written: a number for each lens and size, from 1.
struct SharedLenses {
  std::vector<PinholeCamera> lenses;
  std::vector<std::size_t> lens_of;  ///< per photograph
};

SharedLenses shared_lenses(const std::vector<Photograph>& photographs) {
  SharedLenses result;
  for (const Photograph& photograph : photographs) {
    const PinholeCamera& camera = photograph.camera;
    colmap_model_of(camera, photograph.picture.string());
    const auto same = [&](const PinholeCamera& c) {
      return c.width == camera.width && c.height == camera.height && c.fx == camera.fx &&
             c.fy == camera.fy && c.cx == camera.cx && c.cy == camera.cy && c.lens == camera.lens;
    };
    const auto found = std::ranges::find_if(result.lenses, same);
    result.lens_of.push_back(std::size_t(found - result.lenses.begin()) + 1);
    if (found == result.lenses.end()) result.lenses.push_back(camera);
  }
  return result;
}

std::string colmap_name(const Photograph& photograph) {
  const std::string name = photograph.picture.generic_string();
  if (name.empty() || name.find_first_of(std::string("\n\r\0", 3)) != std::string::npos)
    throw IoError(fmt::format("{}: COLMAP's lists have no place for a picture of that name: rename it",
                              shown(name)));
  return name;
}

void append_words(std::string& text, std::span<const double> numbers) {
  for (const double number : numbers) {
    text += ' ';
    append_number(text, number);
  }
}

Eigen::Quaterniond quaternion_of(const PinholeCamera& camera) {
  Eigen::Quaterniond q(camera.rotation);
  q.normalize();
  return q.w() < 0 ? Eigen::Quaterniond(-q.coeffs()) : q;
}

}  // namespace

CameraEntries read_colmap_text(const fs::path& folder) {
  CameraEntries entries{"COLMAP's text", folder, {}, 0, {}, {folder / "cameras.txt", folder / "images.txt"}};
  std::map<std::string, PinholeCamera> lenses;
  for (const Line& line : lines_of(folder / "cameras.txt"))
    if (!line.words.empty() && !lenses.emplace(line.words[0], camera_of_line(line)).second)
      throw IoError(fmt::format("{}: found camera {} twice", line.where, shown(line.words[0])));
  const std::vector<Line> lines = lines_of(folder / "images.txt");
  for (std::size_t i = 0; i < lines.size(); i += 2) {  // every second holds the picture's points
    if (lines[i].words.empty() && i + 1 >= lines.size()) break;
    entries.cameras.push_back(entry_of_line(lines[i], lenses));
  }
  return entries;
}

CameraEntries read_colmap_binary(const fs::path& folder) {
  constexpr std::size_t least = 8 + 7 * sizeof(double) + 1 + 8, point = 2 * sizeof(double) + 8;
  CameraEntries entries{"COLMAP's binary", folder, {}, 0, {}, {folder / "cameras.bin", folder / "images.bin"}};
  const auto lenses = binary_lenses(folder / "cameras.bin");
  const fs::path path = folder / "images.bin";
  const Bytes bytes = read_file(path);
  BinaryReader reader(path.string(), bytes);
  for (std::uint64_t left = reader.count(least, "pictures"); left > 0; --left) {
    const std::string where = reader.place();
    reader.skip(4);  // the picture's number
    double pose[7];
    for (double& number : pose) number = reader.number<double>();
    const auto id = reader.number<std::uint32_t>();
    const auto lens = lenses.find(id);
    if (lens == lenses.end())
      throw IoError(fmt::format("{}: cameras.bin has no camera {}", where, id));
    CameraEntry entry{reader.zero_text(), lens->second, {}};
    entry.where = fmt::format("{}, {}", path.string(), shown(entry.name));
    entry.camera.rotation = quaternion_rotation(pose[0], pose[1], pose[2], pose[3], entry.where);
    entry.camera.translation = Vector3(pose[4], pose[5], pose[6]);
    reader.skip(reader.count(point, "points") * point);
    entries.cameras.push_back(std::move(entry));
  }
  return entries;
}

void write_colmap_text(const fs::path& folder, const std::vector<Photograph>& photographs) {
  const auto [lenses, lens_of] = shared_lenses(photographs);
  std::string cameras = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
  for (std::size_t k = 0; k < lenses.size(); ++k) {
    const ColmapModel& model = colmap_model_of(lenses[k], folder.string());
    cameras += fmt::format("{} {} {} {}", k + 1, model.name, lenses[k].width, lenses[k].height);
    append_words(cameras, colmap_parameters(lenses[k], model));
    cameras += '\n';
  }
  std::string images =
      "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n# POINTS2D[] as (X, Y, POINT3D_ID)\n";
  for (std::size_t i = 0; i < photographs.size(); ++i) {
    const PinholeCamera& camera = photographs[i].camera;
    const Eigen::Quaterniond q = quaternion_of(camera);
    const Vector3& t = camera.translation;
    images += std::to_string(i + 1);
    append_words(images, std::array{q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()});
    images += fmt::format(" {} {}\n\n", lens_of[i], colmap_name(photographs[i]));
  }
  write_file(folder / "cameras.txt", bytes_of(cameras));
  write_file(folder / "images.txt", bytes_of(images));
  write_file(folder / "points3D.txt", bytes_of("# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[]\n"));
}

void write_colmap_binary(const fs::path& folder, const std::vector<Photograph>& photographs) {
  const auto [lenses, lens_of] = shared_lenses(photographs);
  Bytes cameras, images, points;
  append_raw(cameras, std::uint64_t(lenses.size()));
  for (std::size_t k = 0; k < lenses.size(); ++k) {
    const ColmapModel& model = colmap_model_of(lenses[k], folder.string());
    append_raw(cameras, std::uint32_t(k + 1));
    append_raw(cameras, std::int32_t(model.id));
    append_numbers(cameras, {std::uint64_t(lenses[k].width), std::uint64_t(lenses[k].height)});
    for (const double number : colmap_parameters(lenses[k], model)) append_raw(cameras, number);
  }
  append_raw(images, std::uint64_t(photographs.size()));
  for (std::size_t i = 0; i < photographs.size(); ++i) {
    const Eigen::Quaterniond q = quaternion_of(photographs[i].camera);
    const Vector3& t = photographs[i].camera.translation;
    append_raw(images, std::uint32_t(i + 1));
    append_numbers(images, {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()});
    append_raw(images, std::uint32_t(lens_of[i]));
    const Bytes name = to_bytes(colmap_name(photographs[i]));
    images.insert(images.end(), name.begin(), name.end());
    images.push_back(std::byte{0});
    append_raw(images, std::uint64_t(0));
  }
  append_raw(points, std::uint64_t(0));
  write_file(folder / "cameras.bin", cameras);
  write_file(folder / "images.bin", images);
  write_file(folder / "points3D.bin", points);
}

}  // namespace mq
