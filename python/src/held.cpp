// HeldFiles with the arrays that its views look at.
#include <pybind11/stl.h>

#include <cmath>
#include <cstring>

#include "arrays.h"
#include "mq/base/error.h"
#include "parts.h"

namespace mq::python {
namespace {

class HeldArrays {
 public:
  std::string path(const std::string& name) const { return held_.path(name).string(); }

  void put_picture(const std::string& name, const py::array& array) {
    held_.put(name, picture_from(array, name.c_str()));
    kept_.push_back(array);
  }

  void put_model(const std::string& name, const py::array& vertices, const py::array& faces,
                 const py::object& uvs, const py::object& textures, const py::object& colors) {
    Model model;
    model.mesh = mesh_from(vertices, faces, uvs, textures);
    if (!colors.is_none()) model.colors = colours_from(colors, vertices.shape(0));
    held_.put(name, std::move(model));
  }

  py::dict pictures() {
    py::dict all;
    for (auto& [name, picture] : held_.pictures()) all[py::str(name)] = array_of(std::move(picture));
    held_.pictures().clear();
    return all;
  }

  py::dict models() {
    py::dict all;
    for (auto& [name, model] : held_.models()) {
      py::dict one = arrays_of(model.mesh);
      one["colors"] = model.colors.channels == 0 ? py::object(py::none()) : array_of_colours(model.colors);
      one["pictures"] = model.pictures;
      all[py::str(name)] = one;
    }
    return all;
  }

  py::dict fields() {
    py::dict all;
    for (const auto& [name, field] : held_.fields()) {
      std::vector<double> values;
      for (const Vector3& v : field) values.insert(values.end(), {v[0], v[1], v[2]});
      all[py::str(name)] = array_owning(std::move(values), {py::ssize_t(field.size()), 3});
    }
    return all;
  }

  py::dict files() {
    py::dict all;
    for (const auto& [name, bytes] : held_.files())
      all[py::str(name)] = py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return all;
  }

 private:
  /// Columns of a table of records begin at any byte.
  template <class Value>
  static Value stored(const std::byte* at) {
    Value value;
    std::memcpy(&value, at, sizeof value);
    return value;
  }

  /// (V, C) as a picture of V rows with one pixel each.
  static VertexSignal colours_from(const py::array& array, py::ssize_t vertices) {
    if (array.ndim() != 2 || array.shape(0) != vertices || array.shape(1) < 1 || array.shape(1) > 4)
      throw InvalidInput("colors: wanted an array of shape (vertices, 1 to 4)");
    const PictureView view = picture_from(array.attr("reshape")(1, vertices, array.shape(1)), "colors");
    VertexSignal colours{.channels = int(array.shape(1)), .values = {}, .depth = view.depth};
    for (py::ssize_t v = 0; v < vertices; ++v)
      for (py::ssize_t c = 0; c < colours.channels; ++c) {
        const auto* at = static_cast<const std::byte*>(view.values) + v * view.pixel_step + c * view.channel_step;
        const float value = view.depth == Depth::u8    ? float(stored<std::uint8_t>(at)) / 255
                            : view.depth == Depth::u16 ? float(stored<std::uint16_t>(at)) / 65535
                                                       : stored<float>(at);
        require(std::isfinite(value), "colors: wanted finite numbers");
        colours.values.push_back(value);
      }
    return colours;
  }

  static py::object array_of_colours(const VertexSignal& colours) {
    const py::ssize_t vertices = py::ssize_t(colours.values.size()) / colours.channels;
    const py::array values = array_owning(std::vector<float>(colours.values), {vertices, colours.channels});
    if (colours.depth >= Depth::half) return values;
    const int largest = colours.depth == Depth::u8 ? 255 : 65535;
    const py::object scaled = values.attr("clip")(0, 1) * py::float_(double(largest)) + py::float_(0.5);
    return scaled.attr("astype")(colours.depth == Depth::u8 ? "uint8" : "uint16");
  }

  HeldFiles held_;
  std::vector<py::object> kept_;
};

}  // namespace

void add_held_files(py::module_& module) {
  py::class_<HeldArrays>(module, "Held")
      .def(py::init<>())
      .def("path", &HeldArrays::path)
      .def("put_picture", &HeldArrays::put_picture)
      .def("put_model", &HeldArrays::put_model)
      .def("pictures", &HeldArrays::pictures)
      .def("models", &HeldArrays::models)
      .def("fields", &HeldArrays::fields)
      .def("files", &HeldArrays::files);
}

}  // namespace mq::python
