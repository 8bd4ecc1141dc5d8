#include "io/compressed_gltf.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "io/folder.h"
#include "mq/io/document.h"
#include "mq/io/image_file.h"
#include "mq/io/normals.h"
#include "mq/mesh/surface.h"

namespace mq {
namespace {

using test::by_draco;
using test::by_meshopt;
using test::expect_same_triangles;
using test::GltfParts;
using test::Json;
using test::tube;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

class CompressedGltf : public FolderTest {
 protected:
  GltfParts plain(const Model& model) const {
    write_model(folder / "plain.glb", model);
    return GltfParts(get("plain.glb"));
  }
  Model read(const GltfParts& parts) const {
    put("m.glb", parts.glb());
    return read_model(folder / "m.glb");
  }
  std::string refusal(const GltfParts& parts) const {
    try {
      read(parts);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }
};

/// Seams are seams: what was one vertex in the plain file is one here.
void expect_same_surface(const Mesh& a, const Mesh& b) {
  const Surface expected = make_surface(a), surface = make_surface(b);
  EXPECT_EQ(surface.boundary_edges, expected.boundary_edges);
  EXPECT_EQ(surface.euler_characteristic, expected.euler_characteristic);
  EXPECT_EQ(surface.components, expected.components);
}

TEST_F(CompressedGltf, OfDracoReadAsTheirPlainTwins) {
  const Model model = tube(24, 8, false);
  const GltfParts parts = plain(model);
  for (const test::DracoHow& how : {test::DracoHow{0, 14, 5}, {1, 14, 5}, {1, 11, 0}, {1, 12, 10}, {0, 0, 5}}) {
    SCOPED_TRACE(fmt::format("method {}, {} bits, speed {}", how.method, how.bits, how.speed));
    const Model back = read(by_draco(parts, how));
    const double range = 2, step = how.bits ? range / ((1 << how.bits) - 1) : 0;
    expect_same_triangles(model.mesh, back.mesh, 0.5 * step + 1e-7, how.bits ? 0.5 / 16383 + 1e-6 : 1e-7);
    expect_same_surface(model.mesh, back.mesh);
    EXPECT_THAT(back.notes, Contains(HasSubstr("Draco")));
  }
}

TEST_F(CompressedGltf, PrimitivesThatDracoRoundedApartMeet) {
  const Model model = tube(24, 8, true);
  const Model back = read(by_draco(plain(model), {1, 10, 5}));
  expect_same_surface(model.mesh, back.mesh);
  EXPECT_EQ(make_surface(back.mesh).boundary_edges, 48);
  EXPECT_THAT(back.notes, Contains(HasSubstr("24 vertices where two meet")));
  // Each vertex moved by less than the roundings of the two.
  expect_same_triangles(model.mesh, back.mesh, 1.5 * 2 / 1023, 0.5 / 16383 + 1e-6);
}

TEST_F(CompressedGltf, OfMeshoptReadAsTheirPlainTwins) {
  const Model model = tube(24, 8, true);
  const GltfParts parts = plain(model);
  for (const test::MeshoptHow& how :
       {test::MeshoptHow{true, false, false}, {true, false, true}, {false, false, false}, {false, true, false}}) {
    SCOPED_TRACE(fmt::format("{} {} {}", how.quantised, how.exponential, how.sequence));
    const Model back = read(by_meshopt(parts, how));
    const double error = how.quantised ? 0.5 / test::meshopt_grid + 1e-7 : how.exponential ? 2e-4 : 0;
    expect_same_triangles(model.mesh, back.mesh, error, how.quantised ? 0.5 / 65535 + 1e-7 : 1e-7);
    expect_same_surface(model.mesh, back.mesh);
    EXPECT_THAT(back.notes, Contains(HasSubstr("meshopt")));
  }
}

TEST_F(CompressedGltf, HaveTheFramesOfTheirPlainTwins) {
  const GltfParts bare = plain(tube(24, 8, false)), full = test::with_frames(bare);
  for (const auto& [parts, error] : {std::pair(full, 1e-6), {by_draco(full, {0, 0, 5}), 1e-6},
                                     {by_draco(full, {1, 14, 5}), 1.0 / 256},
                                     {test::with_octahedral_frames(by_meshopt(bare, {}), bare), 1.0 / 64}}) {
    const Model model = read(parts);
    const CornerFrames frames = file_frames(model);
    ASSERT_EQ(frames.normals.size(), 3 * model.mesh.triangles.size());
    ASSERT_EQ(frames.tangents.size(), frames.normals.size());
    for (std::size_t c = 0; c < frames.normals.size(); ++c) {
      const Vector3& p = model.mesh.position(int(c / 3), int(c % 3));
      const auto frame = test::tube_frame(p.x(), p.y());
      ASSERT_LT((frames.normals[c] - Eigen::Vector3f::Map(frame.data())).norm(), error);
      ASSERT_LT((frames.tangents[c] - Eigen::Vector4f::Map(frame.data() + 4)).norm(), error);
    }
  }
}

TEST_F(CompressedGltf, FramesThatDracoDoesNotHoldAreMissed) {
  GltfParts parts = by_draco(test::with_frames(plain(tube(12, 4, false))), {});
  Json& primitive = parts.json["meshes"][0]["primitives"][0];
  primitive["extensions"]["KHR_draco_mesh_compression"]["attributes"].erase("NORMAL");
  const Model model = read(parts);
  try {
    file_frames(model);
    ADD_FAILURE() << "normals of nothing";
  } catch (const IoError& error) {
    EXPECT_THAT(error.what(), HasSubstr("it has no data"));
  }
}

TEST_F(CompressedGltf, KeepTheirBytesWhereAPictureAloneChanges) {
  const GltfParts parts = plain(tube(24, 8, true));
  for (const GltfParts& compressed : {by_draco(parts, {}), by_meshopt(parts, {})}) {
    Model model = read(compressed);
    write_model(folder / "same.glb", model);
    EXPECT_EQ(get("same.glb"), get("m.glb"));
    model.textures[0].pixels = ramp_texture("larger", 50, 40).pixels;
    EXPECT_THAT(write_model(folder / "n.glb", model), Not(Contains(HasSubstr("compress"))));
    const GltfParts now(get("n.glb"));
    EXPECT_GT(now.binary.size(), compressed.binary.size());
    for (std::size_t v = 0; v < now.json["bufferViews"].size(); ++v) {
      Json view = now.json["bufferViews"][v], before = compressed.json["bufferViews"][v];
      if (now.json["images"][0]["bufferView"] == v) continue;
      for (auto* one : {&view, &before})
        if (one->contains("extensions")) *one = (*one)["extensions"]["EXT_meshopt_compression"];
      const std::size_t length = view["byteLength"];
      ASSERT_EQ(length, before["byteLength"]);
      EXPECT_EQ(std::memcmp(now.binary.data() + std::size_t(view["byteOffset"]),
                            compressed.binary.data() + std::size_t(before["byteOffset"]), length),
                0)
          << v;
    }
    const Model back = read_model(folder / "n.glb");
    EXPECT_EQ(back.mesh.positions, model.mesh.positions);
    EXPECT_EQ(back.mesh.triangles, model.mesh.triangles);
    EXPECT_EQ(back.textures[0].pixels, model.textures[0].pixels);
    EXPECT_EQ(back.textures[1].pixels, model.textures[1].pixels);
  }
}

TEST_F(CompressedGltf, AreWrittenPlainWhereTheMeshChanges) {
  const GltfParts parts = plain(tube(24, 8, false));
  for (const GltfParts& compressed : {by_draco(parts, {}), by_meshopt(parts, {})}) {
    Model model = read(compressed);
    model.mesh.positions[3] += Vector3(0.25, 0, 0.5);
    EXPECT_THAT(write_model(folder / "n.glb", model), Contains(HasSubstr("not compressed")));
    EXPECT_FALSE(GltfParts(get("n.glb")).json.contains("extensionsUsed"));
    const Model back = read_model(folder / "n.glb");
    expect_same_triangles(model.mesh, back.mesh, 1e-6, 1e-6);
    expect_same_surface(model.mesh, back.mesh);
  }
}

TEST_F(CompressedGltf, StreamsThatAreDamagedAreRefusedOrHarmless) {
  const GltfParts parts = plain(tube(12, 4, true));
  std::mt19937 random(7);
  for (const GltfParts& compressed :
       {by_draco(parts, {0, 12, 5}), by_draco(parts, {1, 12, 5}), by_draco(parts, {1, 12, 0}),
        by_meshopt(parts, {}), by_meshopt(parts, {false, true, true})}) {
    std::size_t begin = 0;  // behind the pictures
    for (const Json& image : compressed.json["images"]) {
      const Json& view = compressed.json["bufferViews"][int(image["bufferView"])];
      begin = std::max(begin, std::size_t(view["byteOffset"]) + std::size_t(view["byteLength"]));
    }
    int refused = 0;
    for (int i = 0; i < 400; ++i) {
      GltfParts damaged = compressed;
      for (unsigned k = 0; k <= random() % 3; ++k)
        damaged.binary[begin + random() % (damaged.binary.size() - begin)] = std::byte(random());
      Document document;
      document.format = Document::Format::glb;
      document.name = "damaged.glb";
      document.bytes = to_bytes(damaged.glb());
      try {
        const MeshFile file = read_document(document);
        for (const Triangle& t : file.mesh.triangles)
          for (const int v : t) ASSERT_TRUE(v >= 0 && v < file.mesh.vertex_count());
        for (const Vector3& p : file.mesh.positions) ASSERT_TRUE(p.allFinite());
      } catch (const Error& error) {
        EXPECT_THAT(error.what(), HasSubstr("damaged.glb"));
        ++refused;
      }
    }
    EXPECT_GT(refused, 20);
  }
}

TEST_F(CompressedGltf, StreamsThatAreCutAreRefusedWithTheirPlace) {
  const GltfParts parts = plain(tube(12, 4, false));
  GltfParts draco = by_draco(parts, {});
  const Json extension =
      draco.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"];
  Json& stream = draco.json["bufferViews"][int(extension["bufferView"])];
  const int whole = stream["byteLength"];
  for (int length = 0; length < whole; length += 7) {
    stream["byteLength"] = length;
    EXPECT_THAT(refusal(draco), HasSubstr("meshes[0].primitives[0].extensions.KHR_draco_mesh_compression: "
                                          "compressed by Draco, and "))
        << length;
  }
  GltfParts meshopt = by_meshopt(parts, {});
  for (std::size_t v = 0; v < meshopt.json["bufferViews"].size(); ++v) {
    if (!meshopt.json["bufferViews"][v].contains("extensions")) continue;
    GltfParts cut = meshopt;
    Json& length = cut.json["bufferViews"][v]["extensions"]["EXT_meshopt_compression"]["byteLength"];
    for (const int less : {1, 5, 17}) {
      length = std::max(0, int(meshopt.json["bufferViews"][v]["extensions"]["EXT_meshopt_compression"]
                                           ["byteLength"]) - less);
      EXPECT_THAT(refusal(cut), HasSubstr(fmt::format("bufferViews[{}]: compressed by meshopt, and its "
                                                      "stream is cut short", v)));
    }
  }
}

TEST_F(CompressedGltf, CountsAndWordsThatCannotBeAreRefused) {
  const GltfParts parts = plain(tube(12, 4, false));
  const auto meshopt_with = [&](const char* key, const Json& value) {
    GltfParts changed = by_meshopt(parts, {});
    const int id = changed.json["accessors"][0]["bufferView"];
    changed.json["bufferViews"][id]["extensions"]["EXT_meshopt_compression"][key] = value;
    return refusal(changed);
  };
  EXPECT_THAT(meshopt_with("count", 1000000000), HasSubstr("cannot hold 1000000000 elements"));
  EXPECT_THAT(meshopt_with("byteStride", 7), HasSubstr("elements have 7 bytes"));
  EXPECT_THAT(meshopt_with("mode", "LINES"), HasSubstr("is none of ATTRIBUTES"));
  EXPECT_THAT(meshopt_with("filter", "SHARPEN"), HasSubstr("is none of OCTAHEDRAL"));
  EXPECT_THAT(meshopt_with("filter", "QUATERNION"), Not(HasSubstr("does not fit")));
  EXPECT_THAT(meshopt_with("mode", "TRIANGLES"), HasSubstr("elements have 8 bytes"));
  EXPECT_THAT(meshopt_with("byteOffset", 100000000), HasSubstr("of a buffer of"));

  GltfParts draco = by_draco(parts, {});
  draco.json["accessors"][0]["count"] = 12;
  EXPECT_THAT(refusal(draco), HasSubstr("accessor 0 says 12 elements, and Draco's stream holds"));
  draco = by_draco(parts, {});
  Json& extension = draco.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"];
  extension["attributes"]["POSITION"] = 77;
  EXPECT_THAT(refusal(draco), HasSubstr("it has no attribute 77"));
  extension["attributes"] = {{"NORMAL", 0}};
  EXPECT_THAT(refusal(draco), HasSubstr("is no attribute of it"));
  extension.erase("bufferView");
  EXPECT_THAT(refusal(draco), HasSubstr("bufferViews[-1]"));
}

TEST_F(CompressedGltf, AStreamOfAMillionTrianglesInAFewBytesIsNotBelieved) {
  GltfParts draco = by_draco(plain(tube(12, 4, false)), {1, 12, 5});
  const Json extension =
      draco.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"];
  const std::size_t at = draco.json["bufferViews"][int(extension["bufferView"])]["byteOffset"];
  // Behind head and traversal: the number of vertices, here one of five bytes.
  for (std::size_t i = 0; i < 4; ++i) draco.binary[at + 12 + i] = std::byte(0xff);
  draco.binary[at + 16] = std::byte(0x0f);
  EXPECT_THAT(refusal(draco), HasSubstr("bytes cannot hold"));
}

}  // namespace
}  // namespace mq
