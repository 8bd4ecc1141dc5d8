#include <gmock/gmock.h>
#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <cmath>

#include "io/compressed_gltf.h"
#include "io/folder.h"
#include "mq/base/error.h"
#include "mq/mesh/surface.h"

namespace mq {
namespace {

namespace fs = std::filesystem;

using test::by_draco;
using test::by_meshopt;
using test::expect_same_triangles;
using test::GltfParts;
using test::Json;
using test::tube;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A GLB with more than a mesh and pictures.
GltfParts furnished(GltfParts parts) {
  for (Json& material : parts.json["materials"]) {
    material["name"] = "leather";
    material["pbrMetallicRoughness"]["baseColorFactor"] = {0.5, 0.25, 1.0, 0.75};
    material["alphaMode"] = "BLEND";
    material["doubleSided"] = true;
    material["extensions"]["KHR_materials_ior"] = {{"ior", 1.45}};
  }
  parts.json["extensionsUsed"].push_back("KHR_materials_ior");
  parts.json["nodes"][0]["name"] = "tube";
  parts.json["nodes"].push_back({{"camera", 0}, {"translation", {0, 0, 3.5}}});
  parts.json["scenes"][0]["nodes"].push_back(1);
  parts.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.6}, {"znear", 0.01}}}}};
  parts.json["extras"] = {{"kept", {1, 2.5, "three"}}};
  // A view that an animation names, between those of the mesh.
  const std::vector<float> times{0, 1};
  const std::size_t view = parts.add_view(std::as_bytes(std::span(times)));
  parts.json["accessors"].push_back({{"bufferView", view}, {"componentType", 5126}, {"count", 2},
                                     {"type", "SCALAR"}, {"min", {0}}, {"max", {1}}});
  const std::size_t input = parts.json["accessors"].size() - 1;
  parts.json["animations"] = {{{"samplers", {{{"input", input}, {"output", input}}}},
                               {"channels", Json::array()}}};
  return parts;
}

/// What is left of the JSON without where its bytes are.
Json without_places(Json json) {
  for (const char* name : {"buffers", "bufferViews"}) json.erase(name);
  for (Json& accessor : json["accessors"]) accessor.erase("bufferView");
  if (json.contains("images"))
    for (Json& image : json["images"]) image = Json::object();
  return json;
}

class GltfContainers : public FolderTest {
 protected:
  GltfParts plain(const Model& model) const {
    write_model(folder / "plain.glb", model);
    return GltfParts(get("plain.glb"));
  }
};

void expect_same_model(const Model& a, const Model& b) {
  EXPECT_EQ(a.mesh.positions, b.mesh.positions);
  EXPECT_EQ(a.mesh.triangles, b.mesh.triangles);
  EXPECT_EQ(a.mesh.uvs, b.mesh.uvs);
  EXPECT_EQ(a.mesh.corner_uvs, b.mesh.corner_uvs);
  EXPECT_EQ(a.mesh.textures, b.mesh.textures);
  ASSERT_EQ(a.textures.size(), b.textures.size());
  for (std::size_t t = 0; t < a.textures.size(); ++t) EXPECT_EQ(a.textures[t].pixels, b.textures[t].pixels);
}

TEST_F(GltfContainers, KeepAllThatTheJsonSaysOnTheWayThereAndBack) {
  for (const bool compressed : {false, true}) {
    const GltfParts bare = plain(tube(24, 8, true));
    const GltfParts parts = furnished(compressed ? by_meshopt(bare, {}) : bare);
    put("m.glb", parts.glb());
    Model model = read_model(folder / "m.glb");
    ASSERT_EQ(model.textures.size(), 2u);
    model.textures[1].pixels(0, 0, 0) = 1 - model.textures[1].pixels(0, 0, 0);
    EXPECT_THAT(write_model(folder / "n.gltf", model), IsEmpty());
    const Json there = Json::parse(get("n.gltf"));
    EXPECT_EQ(without_places(there), without_places(parts.json));
    for (const Json& image : there["images"]) {
      ASSERT_TRUE(image.contains("uri"));
      EXPECT_TRUE(fs::is_regular_file(folder / std::string(image["uri"])));
    }
    EXPECT_LT(fs::file_size(folder / "n.bin"), parts.binary.size());
    const Model between = read_model(folder / "n.gltf");
    expect_same_model(between, model);
    // Bytes of pictures that did not change are those that were embedded.
    EXPECT_EQ(to_bytes(get(std::string(there["images"][0]["uri"]))),
              Bytes(parts.view(parts.json["images"][0]["bufferView"]).begin(),
                    parts.view(parts.json["images"][0]["bufferView"]).end()));

    EXPECT_THAT(write_model(folder / "o.glb", between), IsEmpty());
    const GltfParts back(get("o.glb"));
    EXPECT_EQ(without_places(back.json), without_places(parts.json));
    for (const Json& image : back.json["images"]) EXPECT_TRUE(image.contains("bufferView"));
    expect_same_model(read_model(folder / "o.glb"), model);
    // The animation finds its times again.
    const Json& times = back.json["accessors"][int(back.json["animations"][0]["samplers"][0]["input"])];
    float last = 0;
    std::memcpy(&last, back.view(times["bufferView"]).data() + 4, 4);
    EXPECT_EQ(last, 1.f);
  }
}

TEST_F(GltfContainers, TakePositionsThatChanged) {
  put("m.glb", furnished(plain(tube(24, 8, false))).glb());
  Model model = read_model(folder / "m.glb");
  model.mesh.positions[3] = Vector3(0.25, 1.5, 0.5);
  EXPECT_THAT(write_model(folder / "n.gltf", model), IsEmpty());
  EXPECT_EQ(Json::parse(get("n.gltf"))["materials"][0]["name"], "leather");
  expect_same_model(read_model(folder / "n.gltf"), model);
}

TEST_F(GltfContainers, AreMadeAnewWhereViewsAreNamedInOtherWays) {
  GltfParts parts = plain(tube(24, 8, false));
  parts.json["extensionsUsed"].push_back("EXT_structural_metadata");
  parts.json["materials"][0]["alphaMode"] = "BLEND";
  put("m.glb", parts.glb());
  const Model model = read_model(folder / "m.glb");
  EXPECT_THAT(write_model(folder / "n.gltf", model), Contains(HasSubstr("made anew")));
  EXPECT_EQ(read_model(folder / "n.gltf").mesh.triangle_count(), model.mesh.triangle_count());
}

// ---- Compressed on request ----

double largest(const std::vector<Vector3>& positions) {
  Eigen::AlignedBox3d box;
  for (const Vector3& p : positions) box.extend(p);
  return box.sizes().maxCoeff();
}

TEST_F(GltfContainers, AreCompressedOnRequest) {
  for (const std::string name : {"c.glb", "c.gltf"})
    for (const Compression how : {Compression::meshopt, Compression::draco}) {
      const bool draco = how == Compression::draco;
      SCOPED_TRACE(name + (draco ? " draco" : " meshopt"));
      Model model = tube(48, 32, true);
      write_model(folder / "plain.gltf", model);
      model.compression = how;
      EXPECT_THAT(write_model(folder / name, model), IsEmpty());
      const Model back = read_model(folder / name);
      EXPECT_THAT(back.notes, Contains(HasSubstr(draco ? "Draco" : "meshopt")));
      expect_same_triangles(model.mesh, back.mesh, draco ? 0.5 * largest(model.mesh.positions) / 65535 + 1e-7 : 1e-7,
                  draco ? 0.5 / 65535 + 1e-7 : 1e-7);
      const Surface expected = make_surface(read_model(folder / "plain.gltf").mesh);
      const Surface surface = make_surface(back.mesh);
      EXPECT_EQ(surface.boundary_edges, expected.boundary_edges);
      EXPECT_EQ(surface.euler_characteristic, expected.euler_characteristic);
      for (std::size_t t = 0; t < 2; ++t) EXPECT_EQ(back.textures[t].pixels, model.textures[t].pixels);
      if (name == "c.glb") continue;
      EXPECT_LT(double(fs::file_size(folder / "c.bin")),
                (draco ? 0.3 : 0.7) * double(fs::file_size(folder / "plain.bin")));
    }
}

TEST_F(GltfContainers, AreCompressedWithAllElseKept) {
  const GltfParts parts = furnished(plain(tube(24, 8, true)));
  put("m.glb", parts.glb());
  for (const Compression how : {Compression::meshopt, Compression::draco}) {
    Model model = read_model(folder / "m.glb");
    model.compression = how;
    EXPECT_THAT(write_model(folder / "c.glb", model), IsEmpty());
    const GltfParts now(get("c.glb"));
    for (const char* name : {"materials", "nodes", "cameras", "animations", "extras", "textures"})
      EXPECT_EQ(now.json[name], parts.json[name]) << name;
    // What is compressed stays as it is.
    Model again = read_model(folder / "c.glb");
    again.compression = how;
    write_model(folder / "d.glb", again);
    expect_same_model(read_model(folder / "d.glb"), again);
  }
}

TEST_F(GltfContainers, SharedAccessorsAndMorphTargetsAreNotHarmed) {
  GltfParts parts = plain(tube(24, 8, false));
  Json& primitives = parts.json["meshes"][0]["primitives"];
  Json second = primitives[0];
  second["targets"] = {{{"POSITION", second["attributes"]["POSITION"]}}};
  primitives.push_back(second);
  put("m.glb", parts.glb());
  Model model = read_model(folder / "m.glb");
  model.compression = Compression::draco;
  EXPECT_THAT(write_model(folder / "c.glb", model), Contains(HasSubstr("meshes[0].primitives[1]")));
  const Model back = read_model(folder / "c.glb");
  EXPECT_EQ(back.mesh.triangle_count(), model.mesh.triangle_count());
  model.compression = Compression::meshopt;
  write_model(folder / "d.glb", model);
  EXPECT_EQ(read_model(folder / "d.glb").mesh.positions, model.mesh.positions);
}

/// Positions on a grid of integers, as gltfpack writes them, are not Draco's.
TEST_F(GltfContainers, LeaveQuantisedPositionsToMeshopt) {
  put("m.glb", by_meshopt(plain(tube(24, 8, false)), {}).glb());
  Model model = read_model(folder / "m.glb");
  model.document = nullptr;  // plain again
  write_model(folder / "p.glb", model);
  GltfParts parts(get("p.glb"));
  const std::vector<float> floats = parts.numbers<float>(parts.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"]);
  std::vector<std::int16_t> integers;
  for (std::size_t i = 0; i < floats.size(); ++i) {
    integers.push_back(std::int16_t(std::lround(floats[i] * 1000)));
    if (i % 3 == 2) integers.push_back(0);
  }
  Json& accessor = parts.json["accessors"][int(parts.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"])];
  accessor["bufferView"] = parts.add_view(std::as_bytes(std::span(integers)));
  accessor["componentType"] = 5122;
  parts.json["bufferViews"].back()["byteStride"] = 8;
  put("q.glb", parts.glb());
  Model quantised = read_model(folder / "q.glb");
  for (const Compression how : {Compression::draco, Compression::meshopt}) {
    quantised.compression = how;
    const auto notes = write_model(folder / "c.glb", quantised);
    if (how == Compression::draco) {
      EXPECT_THAT(notes, Contains(HasSubstr("positions in floats")));
    }
    EXPECT_EQ(read_model(folder / "c.glb").mesh.positions, quantised.mesh.positions);
  }
}

/// A vertex far away that nobody uses, values that are no numbers, texture coordinates over a million textures.
TEST_F(GltfContainers, AreCompressedWhateverTheirValues) {
  for (const std::string what : {"unused", "nan", "far"}) {
    SCOPED_TRACE(what);
    GltfParts parts = test::with_frames(plain(tube(24, 8, false)));
    const Json& primitive = parts.json["meshes"][0]["primitives"][0];
    const auto bytes_of_accessor = [&](const char* name) {
      const Json& accessor = parts.json["accessors"][int(primitive["attributes"][name])];
      return parts.binary.data() + std::size_t(parts.json["bufferViews"][int(accessor["bufferView"])]["byteOffset"]);
    };
    const float strange = what == "nan" ? std::nanf("") : 1e6F;
    if (what == "far") std::memcpy(bytes_of_accessor("TEXCOORD_0"), &strange, 4);
    if (what == "nan") std::memcpy(bytes_of_accessor("TANGENT"), &strange, 4);
    if (what == "unused") {
      std::memcpy(bytes_of_accessor("POSITION"), &strange, 4);
      const auto corners = parts.numbers<std::uint32_t>(primitive["indices"]);
      std::vector<std::uint32_t> without;
      for (std::size_t i = 0; i < corners.size(); i += 3)
        if (corners[i] && corners[i + 1] && corners[i + 2])
          without.insert(without.end(), corners.begin() + i, corners.begin() + i + 3);
      Json& accessor = parts.json["accessors"][int(primitive["indices"])];
      accessor["bufferView"] = parts.add_view(std::as_bytes(std::span(without)));
      accessor["count"] = without.size();
    }
    put("m.glb", parts.glb());
    Model model = read_model(folder / "m.glb");
    model.compression = Compression::draco;
    EXPECT_THAT(write_model(folder / "c.glb", model), IsEmpty());
    EXPECT_TRUE(GltfParts(get("c.glb")).json.contains("extensionsUsed"));
    const Model back = read_model(folder / "c.glb");
    EXPECT_EQ(back.mesh.triangle_count(), model.mesh.triangle_count());
    const double range = what == "unused" ? 2 : largest(model.mesh.positions);
    expect_same_triangles(model.mesh, back.mesh, 0.5 * range / 65535 + 1e-6, 0.5 / 65535 + 1e-6);
  }
}

TEST_F(GltfContainers, OtherFormatsAreNotCompressed) {
  Model model = tube(12, 4, false);
  model.compression = Compression::meshopt;
  EXPECT_THROW(write_model(folder / "m.obj", model), InvalidInput);
  EXPECT_FALSE(there("m.obj"));
}

}  // namespace
}  // namespace mq
