#include "mq/io/normals.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "io/folder.h"
#include "io/models.h"
#include "mq/base/error.h"
#include "mq/io/bytes.h"
#include "mq/io/uri.h"

namespace mq {
namespace {

using Json = nlohmann::json;
using Vectors = std::vector<Eigen::Vector3f>;

class FileFrames : public FolderTest {
 protected:
  Model model_of(const std::string& name, const std::string& text) const {
    return read_model(put(name, text), {.textures = {}, .pictures = ReadModelOptions::Pictures::skip});
  }
  CornerFrames frames_of_file(const std::string& name, const std::string& text) const {
    return file_frames(model_of(name, text));
  }
};

const Eigen::Vector3f along_x(1, 0, 0), along_y(0, 1, 0), along_z(0, 0, 1), none(0, 0, 0);

TEST_F(FileFrames, OfObjAreThoseOfCorners) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 1 0 0\nvn 0 1 0\nvn 0 0 1\n";
  EXPECT_EQ(frames_of_file("a.obj", vertices + "f 1//1 2//2 3//-1\n").normals, (Vectors{along_x, along_y, along_z}));
  EXPECT_EQ(frames_of_file("a.obj", vertices + "vt 0 0\nf 1/1/3 2/1/2 3/1\nf 1/1/1 3/1/9 4/1/x\n").normals,
            (Vectors{along_z, along_y, none, along_x, none, none}));
  // A polygon is cut into triangles whose corners keep theirs.
  const CornerFrames cut = frames_of_file("a.obj", vertices + "f 1//1 2//2 3//3 4//1\n");
  const Vectors of_corner{along_x, along_y, along_z, along_x};
  ASSERT_EQ(cut.normals.size(), 6U);
  const Model model = model_of("b.obj", vertices + "f 1//1 2//2 3//3 4//1\n");
  for (std::size_t c = 0; c < 6; ++c)
    EXPECT_EQ(cut.normals[c], of_corner[std::size_t(model.mesh.triangles[c / 3][c % 3])]);
  EXPECT_TRUE(frames_of_file("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n").normals.empty());
  EXPECT_EQ(frames_of_file("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 1 oh 0\nvn 0 0 1\nf 1//1 2//2 3//2\n")
                .normals[1],
            along_z)
      << "a line that is no normal keeps its number";
}

TEST_F(FileFrames, OfPlyAreThoseOfVertices) {
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "property float nx\nproperty float ny\nproperty float nz\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n"
      "0 0 0 1 0 0\n1 0 0 0 1 0\n0 1 0 0 0 1\n3 2 0 1\n";
  EXPECT_EQ(frames_of_file("a.ply", ply).normals, (Vectors{along_z, along_x, along_y}));
  std::string without = ply;
  without.replace(without.find("float nz"), 8, "float n3");
  EXPECT_TRUE(frames_of_file("a.ply", without).normals.empty());
}

/// A triangle with NORMAL and TANGENT, seen through a node.
Json triangle_of(const Json& node, bool with_normals = true) {
  Bytes data;
  Json gltf = {{"asset", {{"version", "2.0"}}}};
  const auto add = [&](const std::vector<float>& numbers, const std::string& type) {
    const ByteView bytes = std::as_bytes(std::span(numbers));
    gltf["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", data.size()}, {"byteLength", bytes.size()}});
    data.insert(data.end(), bytes.begin(), bytes.end());
    gltf["accessors"].push_back({{"bufferView", gltf["bufferViews"].size() - 1},
                                 {"componentType", 5126},
                                 {"count", 3},
                                 {"type", type}});
    return gltf["accessors"].size() - 1;
  };
  Json attributes;
  attributes["POSITION"] = add({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3");
  attributes["TEXCOORD_0"] = add({0, 1, 1, 1, 0, 0}, "VEC2");
  if (with_normals) attributes["NORMAL"] = add({0, 0, 1, 1, 0, 0, 0.6F, 0, 0.8F}, "VEC3");
  attributes["TANGENT"] = add({1, 0, 0, 1, 0, 1, 0, -1, 0, 1, 0, 1}, "VEC4");
  gltf["meshes"] = {{{"primitives", {{{"attributes", attributes}, {"material", 0}}}}}};
  gltf["materials"] = {{{"normalTexture", {{"index", 0}}}}};
  gltf["textures"] = {{{"source", 0}}};
  gltf["images"] = {{{"uri", "n.png"}}};
  gltf["nodes"] = {node};
  gltf["nodes"][0]["mesh"] = 0;
  gltf["scenes"] = {{{"nodes", {0}}}};
  gltf["buffers"] = {{{"byteLength", data.size()}, {"uri", data_uri("application/octet-stream", data)}}};
  return gltf;
}

TEST_F(FileFrames, OfGltfAreItsNormalsAndTangents) {
  const CornerFrames frames = frames_of_file("a.gltf", triangle_of(Json::object()).dump());
  EXPECT_EQ(frames.normals, (Vectors{along_z, along_x, {0.6F, 0, 0.8F}}));
  ASSERT_EQ(frames.tangents.size(), 3U);
  EXPECT_EQ(frames.tangents[0], Eigen::Vector4f(1, 0, 0, 1));
  EXPECT_EQ(frames.tangents[1], Eigen::Vector4f(0, 1, 0, -1));
}

/// Normals go with the inverse transpose, tangents with the matrix; a mirror changes w and the order of
/// corners.
TEST_F(FileFrames, OfGltfGoThroughItsNodes) {
  const CornerFrames frames =
      frames_of_file("a.gltf", triangle_of({{"scale", {-2, 1, 4}}}).dump());
  ASSERT_EQ(frames.normals.size(), 3U);
  EXPECT_LT((frames.normals[0] - along_z).norm(), 1e-6F);
  const Eigen::Vector3f turned = Eigen::Vector3f(-0.3F, 0, 0.2F).normalized();
  EXPECT_LT((frames.normals[1] - turned).norm(), 1e-6F) << "the third vertex";
  EXPECT_LT((frames.normals[2] + along_x).norm(), 1e-6F) << "the second";
  EXPECT_EQ(frames.tangents[0], Eigen::Vector4f(-1, 0, 0, -1));
  EXPECT_EQ(frames.tangents[2], Eigen::Vector4f(0, 1, 0, 1));
}

TEST_F(FileFrames, OfGltfWithoutNormalsAreFlat) {
  const CornerFrames frames = frames_of_file("a.gltf", triangle_of(Json::object(), false).dump());
  EXPECT_EQ(frames.normals, (Vectors{along_z, along_z, along_z}));
  EXPECT_EQ(frames.tangents, std::vector<Eigen::Vector4f>(3, Eigen::Vector4f::Zero()))
      << "tangents without normals do not count";
}

TEST_F(FileFrames, OfGltfLeaveOutTangentsOfOtherTextureCoordinates) {
  Json gltf = triangle_of(Json::object());
  gltf["materials"][0]["normalTexture"]["extensions"]["KHR_texture_transform"]["rotation"] = 1.5;
  EXPECT_EQ(frames_of_file("a.gltf", gltf.dump()).tangents[0], Eigen::Vector4f(0, 0, 0, 0));
  gltf["materials"][0]["normalTexture"]["extensions"]["KHR_texture_transform"] = {{"scale", {2, 2}}};
  EXPECT_EQ(frames_of_file("a.gltf", gltf.dump()).tangents[0], Eigen::Vector4f(1, 0, 0, 1));
}

TEST_F(FileFrames, OfGltfMustBeOneForEachVertex) {
  Json gltf = triangle_of(Json::object());
  gltf["accessors"][2]["count"] = 2;
  EXPECT_THROW(frames_of_file("a.gltf", gltf.dump()), IoError);
}

TEST_F(FileFrames, AreNoneOnceTheShapeIsAnother) {
  Model model = model_of("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n");
  EXPECT_EQ(file_frames(model).normals.size(), 3U);
  model.mesh.positions[0].z() = 1;
  EXPECT_TRUE(file_frames(model).normals.empty());
  EXPECT_TRUE(file_frames(Model()).normals.empty());
}

}  // namespace
}  // namespace mq
