// Corners of a vertex with equal texture coordinates share one entry of the pool, so that a PLY
// with coordinates per corner and an OBJ of the same model become the same mesh.
#include "mq/io/detail/ply.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <climits>
#include <cmath>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/io/detail/ply_body.h"
#include "mq/io/detail/polygon.h"
#include "mq/io/slots.h"
#include "mq/mesh/check.h"

namespace mq {
namespace {

// ---- Header ----

class HeaderParser {
 public:
  HeaderParser(ByteView bytes, const std::string& name) : text_(text_of(bytes)), name_(name) {}

  PlyHeader parse() {
    Scanner scanner(text_);
    if (scanner.word() != "ply") throw IoError(name_ + " is not PLY: it does not begin so");
    scanner.next_line();
    header_.line_end = text_.substr(0, scanner.offset()).ends_with("\r\n") ? "\r\n"
                       : text_.substr(0, scanner.offset()).ends_with("\r") ? "\r"
                                                                           : "\n";
    for (; !scanner.at_end(); next_line(scanner)) {
      line_ = scanner.offset();
      const std::string_view key = scanner.word();
      if (key == "end_header") return finish(scanner);
      read_line(key, scanner);
    }
    fail("the header has no end; the file may be cut short");
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw IoError(fmt::format("{}, line {}: {}", name_, Scanner::line(text_, line_), what));
  }

  /// With CR as line end, LF may be the first byte of the body.
  void next_line(Scanner& scanner) const {
    scanner.rest();
    const std::size_t end = scanner.offset();
    scanner.next_line();
    if (header_.line_end == "\r" && scanner.offset() > end + 1) scanner = Scanner(text_, end + 1);
  }

  void read_line(std::string_view key, Scanner& scanner) {
    if (key == "format") {
      read_format(scanner.word());
    } else if (key == "element") {
      read_element(scanner);
    } else if (key == "property") {
      read_property(scanner);
      header_.elements.back().header_end = end_of_line(scanner);
    } else if (key == "comment") {
      if (scanner.word() == "TextureFile") read_texture(scanner);
    } else if (key != "obj_info" && !key.empty()) {
      fail(fmt::format("{} is no part of a PLY header", shown(key)));
    }
  }

  std::size_t end_of_line(Scanner scanner) const {
    next_line(scanner);
    return scanner.offset();
  }

  void read_format(std::string_view format) {
    has_format_ = true;
    if (format == "ascii") return;
    if (format != "binary_little_endian" && format != "binary_big_endian")
      fail(fmt::format("format {} is none of ascii, binary_little_endian, binary_big_endian",
                       shown(format)));
    header_.encoding = format == "binary_big_endian" ? PlyHeader::Encoding::big_endian
                                                     : PlyHeader::Encoding::little_endian;
  }

  void read_element(Scanner& scanner) {
    PlyElement element;
    element.name = scanner.word();
    const std::string_view count = scanner.word();
    const auto result = std::from_chars(count.data(), count.data() + count.size(), element.count);
    if (result.ec != std::errc() || result.ptr != count.data() + count.size() || element.count < 0)
      fail(fmt::format("{} is not a count of elements", shown(count)));
    element.header_end = end_of_line(scanner);
    header_.elements.push_back(std::move(element));
  }

  PlyType type(std::string_view word) const {
    constexpr const char* names[][2] = {
        {"char", "int8"}, {"uchar", "uint8"}, {"short", "int16"},   {"ushort", "uint16"},
        {"int", "int32"}, {"uint", "uint32"}, {"float", "float32"}, {"double", "float64"}};
    for (int i = 0; i < 8; ++i)
      if (word == names[i][0] || word == names[i][1]) return PlyType(i);
    fail(fmt::format("{} is not a type of PLY", shown(word)));
  }

  void read_property(Scanner& scanner) {
    if (header_.elements.empty()) fail("a property before any element");
    PlyProperty property;
    std::string_view word = scanner.word();
    if (word == "list") {
      property.count_type = type(scanner.word());
      word = scanner.word();
    }
    property.type = type(word);
    property.name = scanner.word();
    header_.elements.back().properties.push_back(std::move(property));
  }

  void read_texture(Scanner& scanner) {
    const std::string_view name = scanner.rest();
    const std::size_t begin = std::size_t(name.data() - text_.data());
    header_.textures.push_back(
        {portable_name(name), Wrap::unspecified, {{-1, begin, begin + name.size(), ""}}, {}});
  }

  PlyHeader finish(Scanner& scanner) {
    header_.last_line = line_;
    header_.body = end_of_line(scanner);
    if (!has_format_) fail("the header names no format");
    const double left = double(text_.size() - header_.body);
    double least = 0;  // bytes that the elements need
    for (const PlyElement& element : header_.elements) {
      double row = 0;
      for (const PlyProperty& p : element.properties)
        row += header_.encoding == PlyHeader::Encoding::text
                   ? 2
                   : size_of(p.count_type.value_or(p.type));
      least += double(element.count) * row;
    }
    // The last line of text need not end.
    if (least > left + 1)
      fail(
          fmt::format("the elements need at least {} bytes, but {} follow; the file may be cut "
                      "short",
                      least, left));
    return std::move(header_);
  }

  std::string_view text_;
  const std::string& name_;
  PlyHeader header_;
  std::size_t line_ = 0;
  bool has_format_ = false;
};

// ---- Values ----

class PlyParser {
 public:
  PlyParser(const Document& document, int uv_set, PlyNormals normals = PlyNormals::skip)
      : document_(document),
        header_(parse_ply_header(document.bytes, document.name)),
        roles_(header_, uv_set),
        reads_normals_(normals == PlyNormals::read && roles_.normal[0] >= 0),
        reader_(document.bytes, header_, document.name) {}

  PlyFile parse() {
    check_elements();
    for (const PlyElement& element : header_.elements) {
      if (&element == roles_.vertex) {
        read_vertices();
      } else if (&element == roles_.face) {
        read_faces();
      } else if (!element.properties.empty()) {
        for (std::int64_t row = 0; row < element.count; ++row) {
          reader_.set_place(element, row);
          reader_.skip(element);
        }
      }
    }
    choose_uvs();
    cut_polygons();
    choose_textures();
    return std::move(result_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw IoError(document_.name + ": " + what);
  }

  void check_elements() const {
    for (const PlyElement& element : header_.elements) {
      if (element.name == "tristrips")
        fail("its triangles come as strips; write it as faces first (MeshLab does)");
      if ((element.name == "vertex" && &element != roles_.vertex) ||
          (element.name == "face" && &element != roles_.face))
        fail("it declares element " + element.name + " twice");
    }
    if (!roles_.vertex) fail("it declares no element vertex");
    for (const int p : roles_.position)
      if (p < 0) fail("its vertices need the properties x, y and z, each a single value");
    if (roles_.vertex->count > INT_MAX / 4 || (roles_.face && roles_.face->count > INT_MAX / 4))
      fail("it has more than 536870911 vertices or faces");
    if (roles_.face && roles_.indices < 0 && roles_.face->count > 0)
      fail("its faces need the property list vertex_indices");
    if (roles_.face && roles_.indices >= 0 &&
        !is_integer(roles_.face->properties[std::size_t(roles_.indices)].type))
      fail("its vertex_indices are not of an integer type");
  }

  void read_vertices() {
    const PlyElement& element = *roles_.vertex;
    const int channels = roles_.channels();
    const double scale = roles_.color_scale();
    MeshFile& file = result_.file;
    file.colors.channels = channels;
    file.colors.depth = roles_.color_depth();
    file.mesh.positions.reserve(std::size_t(element.count));
    file.colors.values.reserve(std::size_t(element.count) * channels);
    std::vector<double> row(element.properties.size());
    std::vector<PlyValue> list;
    for (std::int64_t i = 0; i < element.count; ++i) {
      reader_.set_place(element, i);
      for (std::size_t p = 0; p < row.size(); ++p) {
        const PlyProperty& property = element.properties[p];
        if (property.count_type) {
          reader_.list(property, list);
        } else {
          row[p] = reader_.value(property.type).value;
        }
      }
      const Vector3 position(row[roles_.position[0]], row[roles_.position[1]],
                             row[roles_.position[2]]);
      if (!position.allFinite())
        reader_.fail(fmt::format("its coordinates {}, {}, {} must be finite", position.x(),
                                 position.y(), position.z()));
      if (position.cwiseAbs().maxCoeff() > largest_coordinate)
        reader_.fail(fmt::format("its coordinates {}, {}, {} may be at most {:.0e}: scale the "
                                 "model down",
                                 position.x(), position.y(), position.z(), largest_coordinate));
      file.mesh.positions.push_back(position);
      for (int c = 0; c < channels; ++c)
        file.colors.values.push_back(float(row[roles_.color[c]] / scale));
      if (roles_.uv[0] >= 0) vertex_uvs_.emplace_back(row[roles_.uv[0]], row[roles_.uv[1]]);
      if (reads_normals_)
        result_.normals.emplace_back(row[roles_.normal[0]], row[roles_.normal[1]],
                                     row[roles_.normal[2]]);
    }
  }

  void read_faces() {
    const PlyElement& element = *roles_.face;
    std::vector<PlyValue> indices, uvs, other;
    for (std::int64_t i = 0; i < element.count; ++i) {
      reader_.set_place(element, i);
      double texture = 0;
      for (std::size_t p = 0; p < element.properties.size(); ++p) {
        const PlyProperty& property = element.properties[p];
        if (!property.count_type) {
          const double value = reader_.value(property.type).value;
          if (int(p) == roles_.texture) texture = value;
        } else {
          reader_.list(property, int(p) == roles_.indices      ? indices
                                 : int(p) == roles_.corner_uvs ? uvs
                                                               : other);
        }
      }
      add_face(indices, uvs, texture);
    }
  }

  int index(double value) const {
    // Vertices may follow the faces in the file.
    if (!(value >= 0) || value >= double(roles_.vertex->count) || value != std::floor(value))
      reader_.fail(fmt::format("vertex {} is not there: the file has {}, from 0", value,
                               roles_.vertex->count));
    return int(value);
  }

  void add_face(const std::vector<PlyValue>& indices, const std::vector<PlyValue>& uvs,
                double texture) {
    const std::size_t n = indices.size();
    if (n > std::size_t(max_polygon))
      reader_.fail(
          fmt::format("it has {} corners; cut it into faces of at most {} first", n, max_polygon));
    if (!uvs.empty() && uvs.size() != 2 * n)
      reader_.fail(fmt::format("{} values in texcoord for {} corners; it needs two for each",
                               uvs.size(), n));
    const std::size_t count = header_.textures.size();
    if (!(std::abs(texture) < max_textures) || (count > 0 && texture >= double(count)))
      reader_.fail(
          fmt::format("texnumber {} is not there: the header names {}", texture,
                      counted(std::int64_t(count), "texture")));
    polygons_.push_back({int(n), std::max(-1, int(texture))});
    for (std::size_t k = 0; k < n; ++k) {
      const int vertex = index(indices[k].value);
      corners_.push_back(vertex);
      if (roles_.corner_uvs >= 0)
        result_.corner_uvs.push_back(
            uvs.empty() ? -1 : pooled(vertex, {uvs[2 * k].value, uvs[2 * k + 1].value}));
    }
  }

  /// The entry of the pool for a corner of `vertex`: one of its latest ones, or a new one.
  int pooled(int vertex, const Vector2& uv) {
    if (latest_.empty()) latest_.assign(std::size_t(roles_.vertex->count), -1);
    constexpr int enough = 64;  // a vertex with more different corners than this is rare
    int id = latest_[std::size_t(vertex)];
    for (int k = 0; id >= 0 && k < enough; ++k, id = before_[std::size_t(id)])
      if (pool_[std::size_t(id)] == uv) return id;
    id = int(pool_.size());
    pool_.push_back(uv);
    before_.push_back(latest_[std::size_t(vertex)]);
    latest_[std::size_t(vertex)] = id;
    return id;
  }

  /// Texture coordinates of corners go before those of vertices.
  void choose_uvs() {
    Mesh& mesh = result_.file.mesh;
    if (!pool_.empty()) {
      mesh.uvs = std::move(pool_);
    } else {
      mesh.uvs = std::move(vertex_uvs_);
      result_.corner_uvs = mesh.uvs.empty() ? std::vector<int>() : corners_;
    }
  }

  /// Cuts polygons into triangles, once all vertices are known.
  void cut_polygons() {
    Mesh& mesh = result_.file.mesh;
    std::size_t at = 0;
    int short_faces = 0, polygons = 0;
    std::vector<Vector3> points;
    for (const Polygon& polygon : polygons_) {
      points.clear();
      for (int k = 0; k < polygon.corners; ++k) points.push_back(mesh.positions[corners_[at + k]]);
      short_faces += polygon.corners < 3;
      polygons += polygon.corners > 3;
      if (polygon.corners == 3) {
        add_triangle({0, 1, 2}, at, polygon.texture);
      } else {
        for (const Triangle& t : triangulate(points)) add_triangle(t, at, polygon.texture);
      }
      at += std::size_t(polygon.corners);
    }
    note(short_faces, "face", "of fewer than three corners left out");
    note(polygons, "polygon", "cut into triangles");
    if (mesh.triangles.empty()) result_.file.notes.push_back("it has no faces");
  }

  void add_triangle(const Triangle& t, std::size_t at, int texture) {
    Mesh& mesh = result_.file.mesh;
    const int* vertices = corners_.data() + at;
    mesh.triangles.push_back({vertices[t[0]], vertices[t[1]], vertices[t[2]]});
    mesh.textures.push_back(texture);
    if (result_.corner_uvs.empty()) return;
    const int* uvs = result_.corner_uvs.data() + at;
    mesh.corner_uvs.push_back({uvs[t[0]], uvs[t[1]], uvs[t[2]]});
  }

  /// Numbers without names are textures without pictures; one texture for all needs no numbers.
  void choose_textures() {
    std::vector<int>& ids = result_.file.mesh.textures;
    result_.file.textures = header_.textures;
    const int largest = ids.empty() ? 0 : *std::max_element(ids.begin(), ids.end());
    const int least = ids.empty() ? 0 : *std::min_element(ids.begin(), ids.end());
    if (header_.textures.empty() && largest > 0)
      result_.file.textures.resize(std::size_t(largest) + 1);
    if (largest == 0 && least == 0) ids.clear();
    if (header_.textures.size() > 1 && roles_.texture < 0)
      result_.file.notes.push_back(fmt::format(
          "it names {} textures but its faces none: all use the first", header_.textures.size()));
  }

  void note(int count, const char* noun, const char* what) {
    if (count > 0) result_.file.notes.push_back(counted(count, noun) + " " + what);
  }

  struct Polygon {
    int corners;
    int texture;
  };
  static constexpr double max_textures = 65536;

  const Document& document_;
  const PlyHeader header_;
  const PlyRoles roles_;
  const bool reads_normals_;
  PlyReader reader_;
  PlyFile result_;
  std::vector<Polygon> polygons_;
  std::vector<int> corners_;  ///< vertices of the polygons' corners
  std::vector<Vector2> vertex_uvs_, pool_;
  std::vector<int> latest_, before_;  ///< per vertex and per entry of the pool, an entry
};

}  // namespace

PlyHeader parse_ply_header(ByteView bytes, const std::string& name) {
  return HeaderParser(bytes, name).parse();
}

PlyFile parse_ply(const Document& document, PlyNormals normals) {
  return PlyParser(document, document.choice.uv_set, normals).parse();
}

MeshFile read_ply(const Document& document) {
  const PlyHeader header = parse_ply_header(document.bytes, document.name);
  const int sets = PlyRoles(header).uv_sets;
  require_uv_set(document.choice.uv_set, sets, document.name);
  MeshFile file = parse_ply(document).file;
  for (const TextureSlot& slot : file.textures)
    if (!slot.name.empty()) add_to_slots(file.slots, base_slot, slot.name, 0);
  file.slot = chosen_slot(file.slots, document.choice.slot, document.name);
  // Files with several sets are few: each is read as if it were the only one.
  for (int set = 0; set < sets && sets > 1; ++set) {
    Mesh mesh = PlyParser(document, set).parse().file.mesh;
    if (mesh.corner_uvs.empty()) mesh.corner_uvs.assign(mesh.triangles.size(), {-1, -1, -1});
    file.uv_sets.push_back({std::move(mesh.uvs), std::move(mesh.corner_uvs)});
  }
  return file;
}

}  // namespace mq
