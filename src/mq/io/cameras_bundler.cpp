// Bundler's v0.3 (Snavely 2006): "# Bundle file v0.3", the numbers of cameras and points, then for each
// camera f k1 k2, three rows of R and t. A point X goes to P = R X + t, the camera looking along −z with
// y up, p = −P / P.z, and to f (1 + k1 |p|² + k2 |p|⁴) p from the middle of the picture, y up. The
// pictures are listed, one a line, in a file of their own; their sizes are nowhere.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mq/base/error.h"
#include "mq/io/bytes.h"
#include "mq/io/detail/camera_entries.h"

namespace mq {
namespace {

namespace fs = std::filesystem;

/// Numbers one after another, wherever lines end.
class NumberStream {
 public:
  NumberStream(std::string file, std::string_view text) : file_(std::move(file)), text_(text), at_(text) {}

  double next(const char* wanted) {
    std::string_view word;
    while ((word = at_.word()).empty()) {
      if (at_.at_end())
        throw IoError(fmt::format("{}: wanted {}, and the file ends: check that it was copied whole",
                                  file_, wanted));
      at_.next_line();
    }
    double value = 0;
    if (!to_number(word, value) || !std::isfinite(value))
      throw IoError(fmt::format("{}: found {}, wanted {}", place(), shown(word), wanted));
    return value;
  }

  void skip_line() { at_.next_line(); }
  std::string place() const {
    const std::size_t at = std::min(at_.offset(), text_.size() - 1);
    return fmt::format("{}, line {}", file_, Scanner::line(text_, at));
  }

 private:
  std::string file_;
  std::string_view text_;
  Scanner at_;
};

/// The list beside a file: NAME.list.txt of NAME.out and, as COLMAP has it, of NAME.bundle.out;
/// list.txt there or a folder further up.
fs::path list_beside(const fs::path& path) {
  fs::path named = path, of_colmap = path;
  of_colmap.replace_extension().replace_extension(".list.txt");
  const std::vector<fs::path> places = {fs::path(path.string() + ".list.txt"),
                                        named.replace_extension(".list.txt"),
                                        of_colmap,
                                        path.parent_path() / "list.txt",
                                        path.parent_path() / ".." / "list.txt"};
  for (const fs::path& place : places)
    if (std::error_code ignored; fs::exists(place, ignored)) return place;
  throw IoError(fmt::format("{}: wanted the list of its pictures, list.txt, beside it or a folder "
                            "further up, or {}",
                            path.string(), places[1].string()));
}

/// A line is a name, or a name, 0 and a focal length.
std::string name_of_line(std::string_view line) {
  std::string name(line);
  const std::size_t last = name.rfind(' ');
  double focal = 0;
  if (last == std::string::npos || last < 2 || !to_number(std::string_view(name).substr(last + 1), focal))
    return name;
  return name.substr(last - 2, 2) == " 0" ? name.substr(0, last - 2) : name;
}

std::vector<std::string> listed_names(const fs::path& path) {
  const Bytes bytes = read_file(path);
  std::vector<std::string> names;
  for (Scanner at(text_of(bytes)); !at.at_end(); at.next_line())
    if (const std::string_view line = at.rest(); !line.empty()) names.push_back(name_of_line(line));
  return names;
}

}  // namespace

CameraEntries read_bundler(const fs::path& path) {
  const Bytes bytes = read_file(path);
  const std::string_view text = text_of(bytes);
  if (!text.starts_with("# Bundle file"))
    throw IoError(path.string() + ", line 1: wanted '# Bundle file v0.3', as Bundler begins its files");
  NumberStream numbers(path.string(), text);
  numbers.skip_line();
  const fs::path list = list_beside(path);
  const std::vector<std::string> names = listed_names(list);
  const double count = numbers.next("the number of cameras");
  if (count != double(names.size()))
    throw IoError(fmt::format("{}: found {} cameras, and {} lists {} pictures: wanted as many",
                              numbers.place(), count, list.string(), names.size()));
  numbers.next("the number of points");
  CameraEntries entries{"Bundler", list.parent_path(), {}, 0, {}, {path, list}};
  for (const std::string& name : names) {
    const double f = numbers.next("a focal length");
    const std::string where = fmt::format("{}, {}", numbers.place(), shown(name));
    CameraEntry entry{name, {}, where};
    entry.camera.lens.k1 = numbers.next("k1"), entry.camera.lens.k2 = numbers.next("k2");
    Eigen::Matrix3d turn;
    for (int k = 0; k < 9; ++k) turn(k / 3, k % 3) = numbers.next("a number of a rotation");
    Vector3 shift;
    for (int k = 0; k < 3; ++k) shift[k] = numbers.next("a number of a translation");
    if (f == 0) {
      ++entries.without_pose;
      continue;
    }
    const Eigen::DiagonalMatrix<double, 3> flip(1, -1, -1);
    entry.camera.rotation = flip * rotation_of_matrix(turn, where);
    entry.camera.translation = flip * shift;
    entry.camera.fx = entry.camera.fy = f;
    entry.complete = [](PinholeCamera& camera) {
      camera.cx = camera.width / 2.0, camera.cy = camera.height / 2.0;
    };
    entries.cameras.push_back(std::move(entry));
  }
  return entries;
}

}  // namespace mq
