#pragma once
/// Arrays of numpy as the library's types, and back. What goes back keeps its owner alive and is not copied.
/// Wrong kinds of values are a TypeError, wrong shapes and values that are not finite `InvalidInput`.

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <string>
#include <vector>

#include "mq/image/image.h"
#include "mq/io/held_files.h"
#include "mq/io/image_file.h"
#include "mq/linear/matrix.h"
#include "mq/mesh/mesh.h"

namespace mq::python {

namespace py = pybind11;

/// A signal, and whether it had one axis.
struct SignalArray {
  Signal values;
  bool flat = false;
};

/// (rows,) or (rows, channels), finite. `name` is the argument's, for messages; rows −1: any.
SignalArray signal_from(const py::array& array, Eigen::Index rows, const char* name);
py::array array_of(Signal values, bool flat);

/// (count,), finite.
std::vector<double> numbers_from(const py::array& array, Eigen::Index count, const char* name);
std::vector<float> floats_from(const py::array& array, Eigen::Index count, const char* name);

/// (count,) whole numbers from 0 to `most` − 1.
std::vector<int> indices_from(const py::array& array, std::int64_t most, const char* name);

/// scipy.sparse.csr_matrix over the matrix's own arrays.
py::object sparse_array(SparseMatrix matrix);
/// Of one, whatever its format.
SparseMatrix matrix_from(const py::object& matrix, const char* name);

template <class T>
py::array array_owning(std::vector<T> values, std::vector<py::ssize_t> shape) {
  auto* owned = new std::vector<T>(std::move(values));
  const py::capsule owner(owned, [](void* one) { delete static_cast<std::vector<T>*>(one); });
  return py::array_t<T>(std::move(shape), owned->data(), owner);
}

/// vertices (V, 3); faces (F, 3) whole numbers; corner_uvs (F, 3, 2), NaN where a corner has none, or None;
/// textures (F,), −1: none, or None.
Mesh mesh_from(const py::array& vertices, const py::array& faces, const py::object& corner_uvs,
               const py::object& textures);

/// {"vertices", "faces", "uvs", "textures"}; None where the mesh has none.
py::dict arrays_of(const Mesh& mesh);

/// (H, W) or (H, W, C) of uint8, uint16 or float32.
PictureView picture_from(const py::array& array, const char* name);
Image<float> image_from(const py::array& array, const char* name);
py::array array_of(const Image<float>& picture);
py::array array_of(WrittenPicture picture);

}  // namespace mq::python
