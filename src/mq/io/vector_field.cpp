// The binary format says a vector by its components along two edges: the canonical parameterization
// of the thesis (2.12), in which a vector does not change when the mesh is bent without stretching.

#include "mq/io/vector_field.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstring>

#include "mq/base/error.h"
#include "mq/base/words.h"
#include "mq/io/atomic_file.h"
#include "mq/io/detail/held.h"
#include "mq/io/detail/ply_body.h"
#include "mq/io/file_names.h"

namespace mq {

static_assert(std::endian::native == std::endian::little, "the format is little-endian");

namespace {

Eigen::Matrix<double, 3, 2> edges_of(const Mesh& mesh, int t) {
  Eigen::Matrix<double, 3, 2> edges;
  for (int k = 0; k < 2; ++k) edges.col(k) = mesh.position(t, k + 1) - mesh.position(t, 0);
  return edges;
}

VectorField read_edge_frames(const std::filesystem::path& path, const Mesh& mesh) {
  const Bytes bytes = read_file(path);
  std::uint32_t count = 0;
  if (bytes.size() >= sizeof count) std::memcpy(&count, bytes.data(), sizeof count);
  const std::size_t wanted = sizeof count + 16 * std::size_t(mesh.triangle_count());
  if (std::int64_t(count) != mesh.triangle_count() || bytes.size() != wanted)
    throw IoError(
        fmt::format("{}: says {} and has {} bytes; a field for this mesh of {} has {}: a 32-bit "
                    "count, then two "
                    "doubles for each",
                    path.string(), counted(count, "triangle"), bytes.size(),
                    counted(mesh.triangle_count(), "triangle"), wanted));
  VectorField field;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    Vector2 components;
    std::memcpy(components.data(), bytes.data() + sizeof count + 16 * std::size_t(t), 16);
    if (!components.allFinite())
      throw IoError(fmt::format("{}: the vector of triangle {} is not finite", path.string(), t));
    field.vectors.push_back(edges_of(mesh, t) * components);
  }
  return field;
}

/// The three properties of an element, or nothing.
std::vector<int> components_in(const PlyElement& element) {
  static constexpr const char* names[2][3] = {{"vx", "vy", "vz"},
                                              {"field_x", "field_y", "field_z"}};
  for (const auto& three : names) {
    std::vector<int> found;
    for (const char* name : three)
      for (std::size_t p = 0; p < element.properties.size(); ++p)
        if (element.properties[p].name == name && !element.properties[p].count_type)
          found.push_back(int(p));
    if (found.size() == 3) return found;
  }
  return {};
}

std::vector<Vector3> read_rows(const PlyElement& element, const std::vector<int>& components,
                               PlyReader& reader) {
  std::vector<Vector3> vectors;
  std::vector<double> row(element.properties.size());
  std::vector<PlyValue> list;
  for (std::int64_t i = 0; i < element.count; ++i) {
    reader.set_place(element, i);
    for (std::size_t p = 0; p < row.size(); ++p) {
      const PlyProperty& property = element.properties[p];
      if (property.count_type)
        reader.list(property, list);
      else
        row[p] = reader.value(property.type).value;
    }
    vectors.emplace_back(row[components[0]], row[components[1]], row[components[2]]);
    if (!vectors.back().allFinite()) reader.fail("its vector is not finite");
  }
  return vectors;
}

VectorField read_properties(const std::filesystem::path& path, const Mesh& mesh) {
  const Bytes bytes = read_file(path);
  const std::string name = path.string();
  const PlyHeader header = parse_ply_header(bytes, name);
  PlyReader reader(bytes, header, name);
  for (const PlyElement& element : header.elements) {
    const bool faces = element.name == "face";
    const std::vector<int> components = components_in(element);
    if ((!faces && element.name != "vertex") || components.empty()) {
      for (std::int64_t i = 0; i < element.count; ++i) {
        reader.set_place(element, i);
        reader.skip(element);
      }
      continue;
    }
    const int wanted = faces ? mesh.triangle_count() : mesh.vertex_count();
    if (element.count != wanted)
      throw IoError(fmt::format("{}: has vectors for {}, and the mesh has {}", name,
                                counted(element.count, element.name),
                                counted(wanted, faces ? "triangle" : "vertex")));
    return {faces ? VectorField::At::triangles : VectorField::At::vertices,
            read_rows(element, components, reader)};
  }
  throw IoError(name +
                ": has no vectors: give its vertices or its faces the properties vx, vy and "
                "vz (or field_x, field_y, field_z)");
}

void write_edge_frames(const std::filesystem::path& path, const Mesh& mesh,
                       const std::vector<Vector3>& field) {
  const std::int32_t count = mesh.triangle_count();
  Bytes bytes(sizeof count + 16 * std::size_t(count));
  std::memcpy(bytes.data(), &count, sizeof count);
  for (int t = 0; t < count; ++t) {
    const Eigen::Matrix<double, 3, 2> e = edges_of(mesh, t);
    const Eigen::Matrix2d gram = e.transpose() * e;
    Vector2 components = gram.ldlt().solve(e.transpose() * field[t]);
    if (!components.allFinite()) components.setZero();  // a triangle without area
    std::memcpy(bytes.data() + sizeof count + 16 * std::size_t(t), components.data(), 16);
  }
  write_file(path, bytes);
}

/// A binary PLY as it grows.
class PlyText {
 public:
  explicit PlyText(const std::string& header) : text_(header) {}
  template <class Value>
  void add(const Value& value) {
    text_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void add_vector(const Vector3& v) {
    for (int k = 0; k < 3; ++k) add(v[k]);
  }
  void add_triangle(const Triangle& triangle) {
    add(std::uint8_t(3));
    for (const int v : triangle) add(std::int32_t(v));
  }
  void write(const std::filesystem::path& path) const { write_file(path, to_bytes(text_)); }

 private:
  std::string text_;
};

std::string ply_header(const Mesh& mesh, const std::string& of_vertices, const std::string& of_faces) {
  return fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\n"
      "property double x\nproperty double y\nproperty double z\n{}"
      "element face {}\nproperty list uchar int vertex_indices\n{}end_header\n",
      mesh.vertex_count(), of_vertices, mesh.triangle_count(), of_faces);
}

void write_properties(const std::filesystem::path& path, const Mesh& mesh,
                      const std::vector<Vector3>& field) {
  PlyText ply(ply_header(mesh, "", "property double vx\nproperty double vy\nproperty double vz\n"));
  for (const Vector3& p : mesh.positions) ply.add_vector(p);
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    ply.add_triangle(mesh.triangles[t]);
    ply.add_vector(field[t]);
  }
  ply.write(path);
}

}  // namespace

bool names_vector_field(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  return extension == ".vf" || extension == ".ply";
}

VectorField read_vector_field(const std::filesystem::path& path, const Mesh& mesh) {
  if (lower_extension(path) == ".vf") return read_edge_frames(path, mesh);
  if (lower_extension(path) == ".ply") return read_properties(path, mesh);
  throw IoError(path.string() + ": a vector field comes as .vf or .ply");
}

void write_vector_field(const std::filesystem::path& path, const Mesh& mesh,
                        const std::vector<Vector3>& field) {
  require(std::ssize(field) == mesh.triangle_count(), "one vector per triangle is needed");
  if (hold_field(path, field)) return;
  if (lower_extension(path) == ".vf")
    write_edge_frames(path, mesh, field);
  else if (lower_extension(path) == ".ply")
    write_properties(path, mesh, field);
  else
    throw IoError(path.string() + ": a vector field is written as .vf or .ply");
}

void write_vertex_values(const std::filesystem::path& path, const Mesh& mesh, std::span<const double> values,
                         std::span<const Colour> colours) {
  require(std::ssize(values) == mesh.vertex_count() && (colours.empty() || colours.size() == values.size()),
          "one value per vertex is needed");
  PlyText ply(ply_header(mesh,
                         std::string("property double quality\n") +
                             (colours.empty() ? "" : "property uchar red\nproperty uchar green\nproperty uchar blue\n"),
                         ""));
  for (std::size_t v = 0; v < values.size(); ++v) {
    ply.add_vector(mesh.positions[v]);
    ply.add(values[v]);
    if (!colours.empty())
      for (const float c : colours[v]) ply.add(std::uint8_t(std::lround(255 * std::clamp(c, 0.0F, 1.0F))));
  }
  for (const Triangle& triangle : mesh.triangles) ply.add_triangle(triangle);
  ply.write(path);
}

}  // namespace mq
