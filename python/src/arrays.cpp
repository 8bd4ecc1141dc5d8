#include "arrays.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "mq/base/error.h"

namespace mq::python {
namespace {

std::string shape_text(const py::array& array) {
  std::string text = "(";
  for (py::ssize_t i = 0; i < array.ndim(); ++i)
    text += fmt::format("{}{}", i == 0 ? "" : ", ", array.shape(i));
  return text + (array.ndim() == 1 ? ",)" : ")");
}

[[noreturn]] void fail_shape(const char* name, const py::array& array, const std::string& wanted) {
  throw InvalidInput(
      fmt::format("{}: found an array of shape {}, wanted {}", name, shape_text(array), wanted));
}

[[noreturn]] void fail_kind(const char* name, const py::array& array, const char* wanted) {
  throw py::type_error(fmt::format("{}: found an array of {}, wanted {}", name,
                                   std::string(py::str(array.dtype())), wanted));
}

/// As doubles, row by row; whole numbers and booleans become numbers.
py::array_t<double, py::array::c_style | py::array::forcecast> as_doubles(const py::array& array,
                                                                          const char* name) {
  const char kind = array.dtype().kind();
  if (kind != 'f' && kind != 'i' && kind != 'u' && kind != 'b') fail_kind(name, array, "numbers");
  auto numbers = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(array);
  if (!numbers) throw py::error_already_set();
  return numbers;
}

void require_finite(std::span<const double> values, const char* name) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i]))
      throw InvalidInput(fmt::format("{}: found {} as value {}, wanted finite numbers", name, values[i], i));
}

/// Whole numbers, row by row.
py::array_t<std::int64_t, py::array::c_style | py::array::forcecast> as_integers(const py::array& array,
                                                                                const char* name) {
  const char kind = array.dtype().kind();
  if (kind != 'i' && kind != 'u') fail_kind(name, array, "whole numbers, such as int32");
  auto numbers = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>::ensure(array);
  if (!numbers) throw py::error_already_set();
  return numbers;
}

int index_in(std::int64_t value, std::int64_t least, std::int64_t most, const char* name) {
  if (value < least || value >= most)
    throw InvalidInput(fmt::format("{}: found {}, wanted {} to {}", name, value, least, most - 1));
  return int(value);
}

/// The places of a matrix that has a row and a column for each of its values.
void check_places(const py::object& matrix, const char* name) {
  const auto rows = as_integers(matrix.attr("row"), name), columns = as_integers(matrix.attr("col"), name);
  const auto count = py::array(matrix.attr("data")).size();
  require(rows.size() == count && columns.size() == count,
          fmt::format("{}: found {} values in {} rows and {} columns, wanted as many of each", name, count, rows.size(),
                      columns.size()));
  const auto shape = matrix.attr("shape").cast<std::pair<std::int64_t, std::int64_t>>();
  for (py::ssize_t n = 0; n < count; ++n) {
    index_in(rows.data()[n], 0, shape.first, name);
    index_in(columns.data()[n], 0, shape.second, name);
  }
}

/// A matrix's arrays can be written to, and scipy sorts and converts rows wherever these say that they are.
void check_structure(const py::object& matrix, const char* name) {
  if (py::hasattr(matrix, "row") && py::hasattr(matrix, "col")) check_places(matrix, name);
  if (!py::hasattr(matrix, "check_format")) return;
  try {
    matrix.attr("check_format")(true);
  } catch (py::error_already_set& error) {
    if (!error.matches(PyExc_ValueError)) throw;
    throw InvalidInput(fmt::format("{}: its arrays of rows, columns and values do not fit each other: {}", name,
                                   std::string(py::str(error.value()))));
  }
}

void read_corner_uvs(const py::array& array, py::ssize_t faces, Mesh& mesh) {
  if (array.ndim() != 3 || array.shape(0) != faces || array.shape(1) != 3 || array.shape(2) != 2)
    fail_shape("uvs", array, fmt::format("({}, 3, 2): two for each corner of each face", faces));
  const auto values = as_doubles(array, "uvs");
  struct Hash {
    std::size_t operator()(const std::pair<std::uint64_t, std::uint64_t>& bits) const {
      return std::size_t((bits.first * 0x9e3779b97f4a7c15ULL) ^ (bits.second + (bits.first >> 29)));
    }
  };
  std::unordered_map<std::pair<std::uint64_t, std::uint64_t>, int, Hash> known;
  mesh.corner_uvs.resize(std::size_t(faces));
  const double* at = values.data();
  for (Triangle& corners : mesh.corner_uvs)
    for (int& corner : corners) {
      const Vector2 uv(*at + 0.0, *(at + 1) + 0.0);  // −0 is 0
      at += 2;
      if (std::isnan(uv[0]) && std::isnan(uv[1])) {
        corner = -1;
        continue;
      }
      const auto [place, added] = known.try_emplace(
          {std::bit_cast<std::uint64_t>(uv[0]), std::bit_cast<std::uint64_t>(uv[1])},
          int(mesh.uvs.size()));
      if (added) mesh.uvs.push_back(uv);
      corner = place->second;
    }
}

}  // namespace

SignalArray signal_from(const py::array& array, Eigen::Index rows, const char* name) {
  const bool flat = array.ndim() == 1;
  if ((!flat && array.ndim() != 2) || (rows >= 0 && array.shape(0) != rows) ||
      (!flat && array.shape(1) == 0))
    fail_shape(name, array,
               rows < 0 ? "one or two axes"
                        : fmt::format("({},) or ({}, channels): a row for each unknown", rows, rows));
  const auto numbers = as_doubles(array, name);
  require_finite({numbers.data(), std::size_t(numbers.size())}, name);
  SignalArray result{Signal(array.shape(0), flat ? 1 : array.shape(1)), flat};
  std::copy_n(numbers.data(), numbers.size(), result.values.data());
  return result;
}

py::array array_of(Signal values, bool flat) {
  auto* owned = new Signal(std::move(values));
  const py::capsule owner(owned, [](void* one) { delete static_cast<Signal*>(one); });
  std::vector<py::ssize_t> shape{owned->rows()};
  if (!flat) shape.push_back(owned->cols());
  return py::array_t<double>(std::move(shape), owned->data(), owner);
}

std::vector<double> numbers_from(const py::array& array, Eigen::Index count, const char* name) {
  if (array.ndim() != 1 || (count >= 0 && array.shape(0) != count))
    fail_shape(name, array, fmt::format("({},)", count));
  const auto numbers = as_doubles(array, name);
  require_finite({numbers.data(), std::size_t(numbers.size())}, name);
  return {numbers.data(), numbers.data() + numbers.size()};
}

std::vector<float> floats_from(const py::array& array, Eigen::Index count, const char* name) {
  const std::vector<double> numbers = numbers_from(array, count, name);
  return {numbers.begin(), numbers.end()};
}

std::vector<int> indices_from(const py::array& array, std::int64_t most, const char* name) {
  if (array.ndim() != 1) fail_shape(name, array, "one axis");
  const auto numbers = as_integers(array, name);
  std::vector<int> indices;
  for (py::ssize_t i = 0; i < numbers.size(); ++i)
    indices.push_back(index_in(numbers.data()[i], 0, most, name));
  return indices;
}

py::object sparse_array(SparseMatrix matrix) {
  auto* owned = new SparseMatrix(std::move(matrix));
  const py::capsule owner(owned, [](void* one) { delete static_cast<SparseMatrix*>(one); });
  owned->makeCompressed();
  const py::ssize_t entries = owned->nonZeros(), rows = owned->rows(), columns = owned->cols();
  const py::array_t<double> values({entries}, owned->valuePtr(), owner);
  const py::array_t<int> inner({entries}, owned->innerIndexPtr(), owner);
  const py::array_t<int> outer({rows + 1}, owned->outerIndexPtr(), owner);
  return py::module_::import("scipy.sparse")
      .attr("csr_matrix")(py::make_tuple(values, inner, outer), py::make_tuple(rows, columns));
}

SparseMatrix matrix_from(const py::object& matrix, const char* name) {
  const py::module_ sparse = py::module_::import("scipy.sparse");
  if (!sparse.attr("issparse")(matrix).cast<bool>())
    throw py::type_error(fmt::format("{}: wanted a matrix of scipy.sparse", name));
  check_structure(matrix, name);
  py::object rows = matrix.attr("tocsr")();
  rows = rows.attr("sorted_indices")();
  const py::array data = rows.attr("data");
  const auto values = as_doubles(data, name);
  require_finite({values.data(), std::size_t(values.size())}, name);
  const auto inner = as_integers(rows.attr("indices"), name), outer = as_integers(rows.attr("indptr"), name);
  const auto shape = rows.attr("shape").cast<std::pair<std::int64_t, std::int64_t>>();
  require(shape.first == shape.second && shape.first > 0 &&
              shape.first < std::numeric_limits<int>::max() &&
              values.size() < std::numeric_limits<int>::max(),
          fmt::format("{}: found a matrix of {} x {}, wanted a square one", name, shape.first, shape.second));
  Entries entries;
  entries.reserve(std::size_t(values.size()));
  for (std::int64_t i = 0; i < shape.first; ++i)
    for (std::int64_t at = outer.data()[i]; at < outer.data()[i + 1]; ++at)
      entries.emplace_back(int(i), index_in(inner.data()[at], 0, shape.second, name), values.data()[at]);
  return sparse_matrix(int(shape.first), int(shape.second), entries);
}

Mesh mesh_from(const py::array& vertices, const py::array& faces, const py::object& corner_uvs,
               const py::object& textures) {
  if (vertices.ndim() != 2 || vertices.shape(1) != 3) fail_shape("vertices", vertices, "(vertices, 3)");
  if (faces.ndim() != 2 || faces.shape(1) != 3) fail_shape("faces", faces, "(faces, 3)");
  require(vertices.shape(0) < std::numeric_limits<int>::max() && faces.shape(0) < std::numeric_limits<int>::max() / 3,
          "faces: too many for 32-bit indices");
  const auto points = as_doubles(vertices, "vertices");
  const auto corners = as_integers(faces, "faces");
  Mesh mesh;
  mesh.positions.resize(std::size_t(vertices.shape(0)));
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    mesh.positions[v] = Vector3(points.data()[3 * v], points.data()[3 * v + 1], points.data()[3 * v + 2]);
  require_finite({points.data(), std::size_t(points.size())}, "vertices");
  mesh.triangles.resize(std::size_t(faces.shape(0)));
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k)
      mesh.triangles[t][k] = index_in(corners.data()[3 * t + k], 0, vertices.shape(0), "faces");
  if (!corner_uvs.is_none()) read_corner_uvs(corner_uvs, faces.shape(0), mesh);
  if (textures.is_none()) return mesh;
  const py::array given = textures;
  if (given.ndim() != 1 || given.shape(0) != faces.shape(0))
    fail_shape("textures", given, fmt::format("({},): one for each face", faces.shape(0)));
  const auto numbers = as_integers(given, "textures");
  constexpr std::int64_t most = 10000;
  for (py::ssize_t t = 0; t < numbers.size(); ++t)
    mesh.textures.push_back(index_in(numbers.data()[t], -1, most, "textures"));
  return mesh;
}

py::dict arrays_of(const Mesh& mesh) {
  std::vector<double> points, uvs;
  std::vector<int> corners;
  for (const Vector3& p : mesh.positions) points.insert(points.end(), {p[0], p[1], p[2]});
  for (const Triangle& t : mesh.triangles) corners.insert(corners.end(), {t[0], t[1], t[2]});
  for (const Triangle& t : mesh.corner_uvs)
    for (const int corner : t) {
      const Vector2 uv = corner < 0 ? Vector2::Constant(std::nan("")) : mesh.uvs[std::size_t(corner)];
      uvs.insert(uvs.end(), {uv[0], uv[1]});
    }
  const py::ssize_t V = mesh.vertex_count(), F = mesh.triangle_count();
  py::dict arrays;
  arrays["vertices"] = array_owning(std::move(points), {V, 3});
  arrays["faces"] = array_owning(std::move(corners), {F, 3});
  arrays["uvs"] = mesh.has_uvs() ? py::object(array_owning(std::move(uvs), {F, 3, 2})) : py::none();
  arrays["textures"] =
      mesh.textures.empty() ? py::none() : py::object(array_owning(std::vector<int>(mesh.textures), {F}));
  return arrays;
}

PictureView picture_from(const py::array& array, const char* name) {
  if (array.ndim() != 2 && array.ndim() != 3)
    fail_shape(name, array, "(height, width) or (height, width, channels)");
  const py::ssize_t channels = array.ndim() == 3 ? array.shape(2) : 1;
  if (array.size() == 0) throw InvalidInput(fmt::format("{}: the picture has no pixels", name));
  require(array.shape(0) <= max_picture_side && array.shape(1) <= max_picture_side && channels <= 4,
          fmt::format("{}: found an array of shape {}, wanted at most {} pixels a side and 4 channels", name,
                      shape_text(array), max_picture_side));
  const py::dtype type = array.dtype();
  const bool native = type.attr("isnative").cast<bool>();
  PictureView view{.values = array.data(),
                   .width = int(array.shape(1)),
                   .height = int(array.shape(0)),
                   .channels = int(channels),
                   .row_step = array.strides(0),
                   .pixel_step = array.strides(1),
                   .channel_step = array.ndim() == 3 ? array.strides(2) : 0};
  if (native && type.kind() == 'u' && type.itemsize() == 1)
    view.depth = Depth::u8;
  else if (native && type.kind() == 'u' && type.itemsize() == 2)
    view.depth = Depth::u16;
  else if (native && type.kind() == 'f' && type.itemsize() == 4)
    view.depth = Depth::f32;
  else
    fail_kind(name, array, "uint8 (0 to 255), uint16 (0 to 65535) or float32 (0 to 1)");
  return view;
}

Image<float> image_from(const py::array& array, const char* name) {
  const PictureView view = picture_from(array, name);
  HeldFiles held;
  held.put("picture.png", view);
  return read_texture(held.path("picture.png")).pixels;
}

py::array array_of(const Image<float>& picture) {
  return array_owning(std::vector<float>(picture.values().begin(), picture.values().end()),
                      {picture.height(), picture.width(), picture.channels()});
}

py::array array_of(WrittenPicture picture) {
  auto* owned = new std::vector<std::byte>(std::move(picture.values));
  const py::capsule owner(owned, [](void* one) { delete static_cast<std::vector<std::byte>*>(one); });
  const py::dtype type = picture.depth == Depth::u8    ? py::dtype::of<std::uint8_t>()
                         : picture.depth == Depth::u16 ? py::dtype::of<std::uint16_t>()
                                                       : py::dtype::of<float>();
  std::vector<py::ssize_t> shape{picture.height, picture.width};
  if (picture.channels > 1) shape.push_back(picture.channels);
  const py::array array(type, shape, owned->data(), owner);
  return picture.depth == Depth::half ? py::array(array.attr("astype")("float16")) : array;
}

}  // namespace mq::python
