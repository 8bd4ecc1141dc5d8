// An OBJ index counts from 1 over all vertices of the file, from −1 back over those read so far.
// An index may run ahead of its vertex, so the largest are checked when all lines are read.
#include "mq/io/detail/obj.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <climits>
#include <cmath>
#include <filesystem>
#include <map>
#include <unordered_map>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/io/detail/polygon.h"
#include "mq/mesh/check.h"

namespace mq {
namespace {

class ObjParser {
 public:
  ObjParser(ByteView bytes, const std::string& name, ObjNormals normals)
      : text_(text_of(bytes)), name_(name), reads_normals_(normals == ObjNormals::read) {}

  ObjFile parse() {
    for (Scanner scanner(text_); !scanner.at_end(); scanner.next_line()) {
      line_ = scanner.offset();
      read_line(scanner);
    }
    if (file_.vertices.empty() && faces_ == 0) refuse_other_file();
    last_line_ = line_;
    check_ahead(vertex_ahead_, int(file_.mesh.positions.size()), "vertex");
    check_ahead(uv_ahead_, int(file_.mesh.uvs.size()), "texture coordinate");
    cut_polygons();
    finish_colors();
    finish_uvs();
    add_notes();
    look_for_a_cut();
    return std::move(file_);
  }

 private:
  /// What is no other format is taken for this one, whatever its name is.
  [[noreturn]] void refuse_other_file() const {
    const std::string extension = std::filesystem::path(name_).extension().string();
    if (extension.empty() || extension == ".obj" || extension == ".OBJ")
      throw IoError(fmt::format("{} is not an OBJ file: it has no line with a vertex or a face; check that it is the mesh "
                                "and not cut short",
                                name_));
    throw IoError(fmt::format("{}: found neither a mesh (OBJ, PLY, glTF, GLB) nor a picture (PNG, JPEG, WebP, TIFF, EXR): "
                              "it is cut short, or of another format ({}), and wants converting",
                              name_, extension));
  }

  /// The largest index that ran ahead of what was read, and where.
  struct Ahead {
    int index = -1;
    std::size_t place = 0;
  };
  /// A polygon: its corners in `corner_vertices_` begin here.
  struct Polygon {
    std::size_t begin;
    std::size_t line;
    int material;
  };

  [[noreturn]] void fail(const std::string& what) const {
    throw IoError(fmt::format("{}, line {}: {}", name_, Scanner::line(text_, line_), what));
  }

  void read_line(Scanner& scanner) {
    std::string_view key = scanner.word();
    if (line_ == 0 && key.starts_with("\xef\xbb\xbf")) key.remove_prefix(3);
    if (key == "v") return read_vertex(scanner);
    if (key == "vt") return read_uv(scanner);
    if (key == "vn" && reads_normals_) return read_normal(scanner);
    if (key == "f" || key == "fo") return read_face(scanner);
    if (key == "usemtl") return use_material(scanner.rest());
    if (key == "mtllib") return read_library(scanner);
    if (!file_.vertices.empty() && key.find('\0') != key.npos)
      fail("it holds zero bytes, so it is damaged; copy it again");
    if (key == "l" || key == "p") ++lines_and_points_;
    if (key == "curv" || key == "curv2" || key == "surf") ++free_forms_;
  }

  /// The numbers of a line, up to `most`, for all of which there is room in `numbers`.
  int read_numbers(Scanner& scanner, double* numbers, int most) const {
    int count = 0;
    for (; count < most; ++count) {
      const std::string_view word = scanner.word();
      if (word.empty() || word[0] == '#') break;
      if (!to_number(word, numbers[count])) fail(fmt::format("{} is not a number", shown(word)));
    }
    return count;
  }

  void read_vertex(Scanner& scanner) {
    file_.vertices.push_back(scanner.offset());
    double n[7];
    const int count = read_numbers(scanner, n, 7);
    if (count < 3) fail(fmt::format("a vertex of {} numbers; it needs three", count));
    for (int i = 0; i < 3; ++i)
      if (!std::isfinite(n[i]))
        fail(fmt::format("vertex {} has the coordinate {}; it must be finite",
                         file_.vertices.size(), n[i]));
      else if (std::abs(n[i]) > largest_coordinate)
        fail(fmt::format("vertex {} has the coordinate {}; at most {:.0e} can be used: scale the "
                         "model down",
                         file_.vertices.size(), n[i], largest_coordinate));
    file_.mesh.positions.emplace_back(n[0], n[1], n[2]);
    const int channels = count >= 6 ? count - 3 : 0;
    channels_ = file_.vertices.size() == 1 ? channels : std::min(channels_, channels);
    if (channels > 0) ++colored_vertices_;
    if (colored_vertices_ == 0) return;
    colors_.resize((file_.vertices.size() - 1) * 4);
    for (int i = 0; i < 4; ++i) colors_.push_back(i < channels ? float(n[3 + i]) : 0.0f);
  }

  void read_uv(Scanner& scanner) {
    file_.uvs.push_back(scanner.offset());
    double n[2] = {0, 0};
    if (read_numbers(scanner, n, 2) == 0) fail("a texture coordinate without a number");
    file_.mesh.uvs.emplace_back(n[0], n[1]);
  }

  /// A line that is no normal is one of length 0, so that the others keep their numbers.
  void read_normal(Scanner& scanner) {
    Vector3 normal = Vector3::Zero();
    for (int i = 0; i < 3; ++i)
      if (!to_number(scanner.word(), normal[i])) normal[i] = 0;
    file_.normals.push_back(normal);
  }

  /// What is behind the second slash of a corner; −1 where it is no index.
  int normal_index(std::string_view text) const {
    int index = 0;
    const auto result = std::from_chars(text.data(), text.data() + text.size(), index);
    if (result.ec != std::errc() || result.ptr != text.data() + text.size()) return -1;
    return index < 0 ? int(std::ssize(file_.normals)) + index : index - 1;
  }

  /// The index, from 0, that `text` spells; `ahead` remembers one beyond `count`.
  int read_index(std::string_view text, std::string_view word, int count, Ahead& ahead,
                 const char* what) const {
    long long index = 0;
    const auto result = std::from_chars(text.data(), text.data() + text.size(), index);
    if (result.ptr != text.data() + text.size() || text.empty() || index == 0 ||
        result.ec != std::errc())
      fail(
          fmt::format("{} is not a corner of a face: the index of a {} counts from 1, or from -1 "
                      "backwards",
                      shown(word), what));
    if (index < 0 && -index > count)
      fail(fmt::format("{} goes back {} from {}", shown(word), -index, counted(count, what)));
    if (index > INT_MAX) fail(fmt::format("{}: {} {} is not there", shown(word), what, index));
    const int id = index < 0 ? int(count + index) : int(index - 1);
    if (id >= count && id > ahead.index) ahead = {id, line_};
    return id;
  }

  void check_ahead(const Ahead& ahead, int count, const char* what) {
    line_ = ahead.place;
    if (ahead.index >= count)
      fail(fmt::format("a face uses {} {}, but the file has {}; it may be cut short", what,
                       ahead.index + 1LL, count));
  }

  void read_face(Scanner& scanner) {
    const std::size_t begin = corner_vertices_.size();
    for (;;) {
      const std::string_view word = scanner.word();
      if (word.empty() || word[0] == '#') break;
      const std::size_t slash = std::min(word.find('/'), word.size());
      const std::size_t second = std::min(word.find('/', slash + 1), word.size());
      corner_vertices_.push_back(read_index(word.substr(0, slash), word, int(file_.vertices.size()),
                                            vertex_ahead_, "vertex"));
      const bool has_uv = second > slash + 1;
      if (has_uv) any_uv_ = true;
      corner_uvs_.push_back(!has_uv ? -1
                                    : read_index(word.substr(slash + 1, second - slash - 1), word,
                                                 int(file_.uvs.size()), uv_ahead_,
                                                 "texture coordinate"));
      if (reads_normals_)
        corner_normals_.push_back(
            second < word.size() ? normal_index(word.substr(second + 1)) : -1);
    }
    ++faces_;
    const std::size_t corners = corner_vertices_.size() - begin;
    if (corners > std::size_t(max_polygon))
      fail(fmt::format("a face of {} corners; cut it into faces of at most {} first", corners,
                       max_polygon));
    if (corners >= 3) {
      polygons_.push_back({begin, line_, material_of_next_face()});
      return;
    }
    ++short_faces_;
    corner_vertices_.resize(begin);
    corner_uvs_.resize(begin);
    corner_normals_.resize(reads_normals_ ? begin : 0);
  }

  void use_material(std::string_view name) {
    material_name_ = name;
    material_ = unknown;
  }

  /// Materials are numbered when a face uses them.
  int material_of_next_face() {
    if (material_ != unknown) return material_;
    const auto found =
        material_ids_.try_emplace(std::string(material_name_), int(file_.materials.size()));
    if (found.second) file_.materials.emplace_back(material_name_);
    return material_ = found.first->second;
  }

  void read_library(Scanner& scanner) {
    const std::string_view names = scanner.rest();
    const std::size_t begin = std::size_t(names.data() - text_.data());
    if (!names.empty())
      file_.libraries.push_back({std::string(names), {-1, begin, begin + names.size(), ""}});
  }

  void cut_polygons() {
    Mesh& mesh = file_.mesh;
    mesh.triangles.reserve(polygons_.size());
    if (any_uv_) mesh.corner_uvs.reserve(polygons_.size());
    std::vector<Vector3> corners;
    for (std::size_t i = 0; i < polygons_.size(); ++i) {
      const std::size_t begin = polygons_[i].begin;
      const std::size_t end =
          i + 1 < polygons_.size() ? polygons_[i + 1].begin : corner_vertices_.size();
      if (end - begin == 3) {
        add_triangle(polygons_[i], {0, 1, 2});
        continue;
      }
      corners.clear();
      for (std::size_t c = begin; c < end; ++c)
        corners.push_back(mesh.positions[corner_vertices_[c]]);
      for (const Triangle& t : triangulate(corners)) add_triangle(polygons_[i], t);
    }
  }

  void add_triangle(const Polygon& polygon, const Triangle& corners) {
    const int* vertices = corner_vertices_.data() + polygon.begin;
    file_.mesh.triangles.push_back(
        {vertices[corners[0]], vertices[corners[1]], vertices[corners[2]]});
    if (!file_.materials.empty()) file_.mesh.textures.push_back(polygon.material);
    if (reads_normals_) add_normals(corner_normals_.data() + polygon.begin, corners);
    if (!any_uv_) return;
    const int* uvs = corner_uvs_.data() + polygon.begin;
    const Triangle triangle{uvs[corners[0]], uvs[corners[1]], uvs[corners[2]]};
    file_.mesh.corner_uvs.push_back(triangle);
  }

  void add_normals(const int* of_polygon, const Triangle& corners) {
    Triangle normals;
    for (int k = 0; k < 3; ++k) {
      const int normal = of_polygon[corners[k]];
      normals[k] = normal < std::ssize(file_.normals) ? normal : -1;
    }
    file_.corner_normals.push_back(normals);
  }

  void finish_colors() {
    if (channels_ == 0) {
      if (colored_vertices_ > 0)
        file_.notes.push_back(
            fmt::format("colours are left out: only {} of {} have one", colored_vertices_,
                        counted(std::int64_t(file_.vertices.size()), "vertex")));
      return;
    }
    file_.colors = {channels_, {}, Depth::f32};
    for (std::size_t i = 0; i < colors_.size(); ++i)
      if (int(i % 4) < channels_) file_.colors.values.push_back(colors_[i]);
  }

  /// Texture coordinates no corner names are no texture coordinates of the mesh.
  void finish_uvs() {
    if (!any_uv_) {
      if (!file_.uvs.empty()) file_.notes.push_back("its texture coordinates belong to no face");
      file_.mesh.uvs.clear();
      file_.uvs.clear();
    }
  }

  void note(long long count, const char* noun, const char* what) {
    if (count > 0) file_.notes.push_back(counted(count, noun) + " " + what);
  }

  /// How many come after the last that a face uses.
  static std::int64_t unused_at_end(const std::vector<int>& used, std::size_t count) {
    const int last = used.empty() ? -1 : *std::max_element(used.begin(), used.end());
    return std::int64_t(count) - 1 - last;
  }

  void may_be_cut(const char* element, std::int64_t count, std::int64_t id, std::string message) {
    file_.defects.push_back({"maybe_cut_short", Defect::Severity::warning, element, count, {id},
                             std::move(message) + ", as in a file that was cut short: compare it "
                                                  "with its source if anything is missing"});
  }

  /// A cut that leaves valid lines shows in a last line without an end, or in vertices whose faces
  /// are gone.
  void look_for_a_cut() {
    const bool ended = text_.ends_with('\n') || text_.ends_with('\r');
    Scanner scanner(text_, last_line_);
    const std::string_view key = scanner.word();
    if (!ended && (key == "f" || key == "fo" || key.starts_with("v")))
      may_be_cut("line", 1, Scanner::line(text_, last_line_),
                 fmt::format("the last line, {}, has no line end", shown(text_.substr(last_line_))));
    const std::int64_t vertices = unused_at_end(corner_vertices_, file_.vertices.size());
    const std::int64_t uvs = any_uv_ ? unused_at_end(corner_uvs_, file_.uvs.size()) : 0;
    if (polygons_.empty() || (vertices == 0 && uvs == 0)) return;
    if (vertices > 0)
      may_be_cut("vertex", vertices, std::int64_t(file_.vertices.size()) - vertices,
                 fmt::format("no face uses the last {} in the file",
                             counted(vertices, "vertex")));
    else
      may_be_cut("texture coordinate", uvs, std::int64_t(file_.uvs.size()) - uvs,
                 fmt::format("no face uses the last {} in the file",
                             counted(uvs, "texture coordinate")));
  }

  void add_notes() {
    if (file_.mesh.triangles.empty()) file_.notes.push_back("it has no faces");
    note(short_faces_, "face", "of fewer than three corners left out");
    note(lines_and_points_, "line or point element", "not used");
    note(free_forms_, "free-form curve or surface", "not used");
    if (polygons_.size() < file_.mesh.triangles.size())
      file_.notes.push_back(
          fmt::format("{} cut into {}", counted(std::int64_t(polygons_.size()), "polygon"),
                      counted(file_.mesh.triangle_count(), "triangle")));
  }

  static constexpr int unknown = -2;

  std::string_view text_;
  const std::string& name_;
  const bool reads_normals_;
  ObjFile file_;
  std::size_t line_ = 0;  ///< where the line being read begins
  std::size_t last_line_ = 0;
  std::vector<int> corner_vertices_, corner_uvs_, corner_normals_;
  std::vector<Polygon> polygons_;
  Ahead vertex_ahead_, uv_ahead_;
  std::string_view material_name_;
  int material_ = -1;
  std::unordered_map<std::string, int> material_ids_;
  std::vector<float> colors_;  ///< four per vertex, once one has any
  int channels_ = 0;
  bool any_uv_ = false;
  long long faces_ = 0, short_faces_ = 0, lines_and_points_ = 0, free_forms_ = 0;
  long long colored_vertices_ = 0;
};

}  // namespace

/// Looks at the lines that begin with the word, whether a backslash ends the one before or not: a face or a vertex that
/// goes on with it is refused by `parse_obj`, and others do not go on.
std::vector<ObjFile::Library> obj_libraries(ByteView bytes) {
  constexpr std::string_view key = "mtllib", mark = "\xef\xbb\xbf";
  const std::string_view text = text_of(bytes);
  std::vector<ObjFile::Library> libraries;
  for (std::size_t at = text.find(key); at != text.npos; at = text.find(key, at + key.size())) {
    std::size_t begin = at;
    while (begin > 0 && (text[begin - 1] == ' ' || text[begin - 1] == '\t')) --begin;
    const bool after_mark = at == mark.size() && text.starts_with(mark);
    if (begin > 0 && text[begin - 1] != '\n' && text[begin - 1] != '\r' && !after_mark) continue;
    Scanner scanner(text, at);
    if (scanner.word() != key) continue;
    const std::string_view names = scanner.rest();
    const std::size_t first = std::size_t(names.data() - text.data());
    if (!names.empty()) libraries.push_back({std::string(names), {-1, first, first + names.size(), ""}});
  }
  return libraries;
}

ObjFile parse_obj(ByteView bytes, const std::string& name, ObjNormals normals) {
  return ObjParser(bytes, name, normals).parse();
}

}  // namespace mq
