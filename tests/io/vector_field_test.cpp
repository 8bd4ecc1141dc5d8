// Vector fields as files: what is written is read back, what does not fit is refused.

#include "mq/io/vector_field.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>

#include "fixtures.h"
#include "io/folder.h"
#include "mq/base/error.h"
#include "mq/io/atomic_file.h"
#include "mq/io/bytes.h"
#include "mq/io/model.h"

namespace mq {
namespace {

class VectorFieldFile : public FolderTest {};

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST_F(VectorFieldFile, ComesBackFromItsFile) {
  const Mesh mesh = fixtures::torus(8, 6);
  std::vector<Vector3> field;
  for (int t = 0; t < mesh.triangle_count(); ++t)
    field.push_back((mesh.position(t, 1) - mesh.position(t, 0)) * 0.3 +
                    (mesh.position(t, 2) - mesh.position(t, 1)) * t);
  write_vector_field(folder / "f.vf", mesh, field);
  EXPECT_EQ(std::filesystem::file_size(folder / "f.vf"), 4 + 16 * field.size());
  const VectorField read = read_vector_field(folder / "f.vf", mesh);
  ASSERT_EQ(read.at, VectorField::At::triangles);
  for (std::size_t t = 0; t < field.size(); ++t)
    EXPECT_LE((read.vectors[t] - field[t]).norm(), 1e-12 * (1 + field[t].norm()));
  EXPECT_THAT([&] { read_vector_field(folder / "f.vf", fixtures::one_triangle()); },
              ThrowsMessage<IoError>(HasSubstr("1 triangle")));
  write_file(folder / "short.vf", std::vector<std::byte>(3));
  EXPECT_THROW(read_vector_field(folder / "short.vf", mesh), IoError);
  EXPECT_THROW(read_vector_field(folder / "none.vf", mesh), IoError);
  EXPECT_THROW(read_vector_field(folder / "f.txt", mesh), IoError);
}

TEST_F(VectorFieldFile, IsWrittenWithItsMeshToo) {
  const Mesh mesh = fixtures::torus(8, 6);
  std::vector<Vector3> field;
  for (int t = 0; t < mesh.triangle_count(); ++t) field.emplace_back(t, 1.0 / (t + 1), -0.1);
  write_vector_field(folder / "f.ply", mesh, field);
  const VectorField read = read_vector_field(folder / "f.ply", mesh);
  EXPECT_EQ(read.at, VectorField::At::triangles);
  EXPECT_EQ(read.vectors, field);
  const Mesh again = read_model(folder / "f.ply").mesh;
  EXPECT_EQ(again.positions, mesh.positions);
  EXPECT_EQ(again.triangles, mesh.triangles);
  EXPECT_THROW(write_vector_field(folder / "f.txt", mesh, field), IoError);
  field.pop_back();
  EXPECT_THROW(write_vector_field(folder / "g.ply", mesh, field), InvalidInput);
}

TEST_F(VectorFieldFile, IsFoundAmongTheProperties) {
  const Mesh mesh = fixtures::one_triangle();
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
      "z\n";
  const auto write = [&](const std::string& text) {
    write_file(folder / "f.ply", to_bytes(text));
    return read_vector_field(folder / "f.ply", mesh);
  };
  const VectorField vertices =
      write(head +
            "property float vx\nproperty float vy\nproperty float vz\nelement face 1\n"
            "property list uchar int vertex_indices\nend_header\n"
            "0 0 0 1 2 3\n1 0 0 4 5 6\n0 1 0 7 8 9\n3 0 1 2\n");
  EXPECT_EQ(vertices.at, VectorField::At::vertices);
  EXPECT_EQ(vertices.vectors[1], Vector3(4, 5, 6));
  const VectorField faces =
      write(head +
            "element face 1\nproperty list uchar int vertex_indices\nproperty float field_x\n"
            "property float field_y\nproperty float field_z\nend_header\n"
            "0 0 0\n1 0 0\n0 1 0\n3 0 1 2 -1 0.5 2\n");
  EXPECT_EQ(faces.at, VectorField::At::triangles);
  EXPECT_EQ(faces.vectors[0], Vector3(-1, 0.5, 2));
  EXPECT_THAT([&] { write(head + "end_header\n0 0 0\n1 0 0\n0 1 0\n"); },
              ThrowsMessage<IoError>(HasSubstr("has no vectors")));
}

TEST_F(VectorFieldFile, HasValuesAtVerticesAsQuality) {
  const Mesh mesh = fixtures::one_triangle();
  const std::vector<double> values = {0.25, -3, 1e-9};
  write_vertex_values(folder / "values.ply", mesh, values);
  const std::string bytes(text_of(read_file(folder / "values.ply")));
  EXPECT_THAT(bytes, HasSubstr("property double quality\n"));
  const std::size_t data = bytes.find("end_header\n") + 11;
  for (std::size_t v = 0; v < 3; ++v) {
    double value = 0;
    std::memcpy(&value, bytes.data() + data + (4 * v + 3) * sizeof(double), sizeof value);
    EXPECT_EQ(value, values[v]);
  }
  EXPECT_EQ(read_model(folder / "values.ply").mesh.positions, mesh.positions);
  EXPECT_THROW(write_vertex_values(folder / "few.ply", mesh, std::vector<double>{1}), InvalidInput);
}

}  // namespace
}  // namespace mq
