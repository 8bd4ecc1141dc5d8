// export: what evolving meshes become in other files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "cli/moving_body.h"
#include "cli/moving_square.h"
#include "mq/io/animation_read.h"
#include "mq/io/evolving_file.h"
#include "mq/io/frame_files.h"
#include "mq/io/image_file.h"
#include "mq/io/model.h"

namespace mq::test {
namespace {

using testing::HasSubstr;

/// A store of two segments: frames 0 and 1, and frame 2 with its own mesh.
void make_store(const Folder& folder) {
  make_body(folder, "bending", 2);
  ASSERT_EQ(marquetry(folder, {"track", "body", "-o", "two.evolving", "--frames", "0-1"}).status,
            0);
  EvolvingMesh evolving = EvolvingReader(folder / "two.evolving").read();
  const Mesh other = read_model(folder / "body/frame_0002.ply").mesh;
  evolving.segments.push_back(
      segment_of(other, next_vertex_id(evolving), next_triangle_id(evolving)));
  evolving.frames.push_back({2, 1, other.positions});
  write_evolving(folder / "body.evolving", evolving, store_step(2));
}

TEST(Export, SaysWhatAnEvolvingMeshIs) {
  const Folder folder;
  make_store(folder);
  const Result result = marquetry(folder, {"export", "body.evolving", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto found = result.json()["result"];
  EXPECT_EQ(found["frames"], 3);
  EXPECT_EQ(found["segments"], 2);
  EXPECT_EQ(found["triangles_throughout"], 0);
  EXPECT_EQ(found["broken"], "");
  const std::string words = marquetry(folder, {"export", "body.evolving"}).output;
  EXPECT_THAT(words, HasSubstr("segment 1: from frame 2, 1 frame, "));
}

TEST(Export, WritesFramesAsFiles) {
  const Folder folder;
  make_store(folder);
  const EvolvingMesh evolving = EvolvingReader(folder / "body.evolving").read();
  std::filesystem::create_directory(folder / "out");
  for (const std::string name : {"out/f_%03d.ply", "out/f_%03d.obj"}) {
    ASSERT_EQ(marquetry(folder, {"export", "body.evolving", "-o", name}).status, 0);
    for (int f = 0; f < 3; ++f) {
      const Mesh mesh = read_model(folder / frame_name(name, f)).mesh;
      EXPECT_EQ(mesh.triangles, evolving.mesh(f).triangles);
      EXPECT_EQ(mesh.positions, evolving.mesh(f).positions);
    }
  }
}

TEST(Export, GivesFramesThatDoNotNeedWhatWasDamaged) {
  const Folder folder;
  make_store(folder);
  const EvolvingReader whole(folder / "body.evolving");
  std::string blocks = file_bytes(folder / "body.blocks");
  blocks[std::size_t(whole.segments()[1].offset) + 9] ^= 1;
  write_bytes(folder / "body.blocks", blocks);
  const Result result =
      marquetry(folder, {"export", "body.evolving", "-o", "f_%d.ply", "--frames", "0-1", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["damaged"], nlohmann::json::array({2}));
  EXPECT_EQ(result.json()["result"]["triangles_throughout"], whole.segments()[0].triangles);
  EXPECT_THAT(result.error, HasSubstr("cannot give frame 2"));
  EXPECT_EQ(read_model(folder / "f_1.ply").mesh.positions, whole.positions(1));
  const Result all = marquetry(folder, {"export", "body.evolving", "-o", "f_%d.ply"});
  EXPECT_EQ(all.status, 2);
  EXPECT_THAT(all.error, HasSubstr("2 of 3 frames were written; damaged, and not written: 2"));
  // A damaged frame in between costs no other.
  blocks[std::size_t(whole.segments()[1].offset) + 9] ^= 1;
  blocks[std::size_t(whole.frames()[1].offset) + 1] ^= 1;
  write_bytes(folder / "body.blocks", blocks);
  EXPECT_EQ(marquetry(folder, {"export", "body.evolving", "-o", "g_%d.ply"}).status, 2);
  EXPECT_TRUE(std::filesystem::exists(folder / "g_0.ply"));
  EXPECT_FALSE(std::filesystem::exists(folder / "g_1.ply"));
  EXPECT_EQ(read_model(folder / "g_2.ply").mesh.positions, whole.positions(2));
}

TEST(Export, WritesAnAnimationWithATargetForEachFurtherFrame) {
  const Folder folder;
  make_store(folder);
  const EvolvingMesh evolving = EvolvingReader(folder / "body.evolving").read();
  ASSERT_EQ(marquetry(folder, {"export", "body.evolving", "-o", "body.glb"}).status, 0);
  const std::string bytes = file_bytes(folder / "body.glb");
  std::uint32_t size = 0;
  std::memcpy(&size, bytes.data() + 12, sizeof size);
  const auto gltf = nlohmann::json::parse(bytes.substr(20, size));
  ASSERT_EQ(gltf["meshes"].size(), 2U);
  EXPECT_EQ(gltf["meshes"][0]["primitives"][0]["targets"].size(), 1U);
  EXPECT_FALSE(gltf["meshes"][1]["primitives"][0].contains("targets"));
  EXPECT_EQ(gltf["animations"][0]["channels"].size(), 3U);  // weights, and both come and go
  // Base and target of a vertex add up to its second frame.
  const auto value = [&](const nlohmann::json& accessor, int vertex, int k) {
    const auto& view = gltf["bufferViews"][accessor["bufferView"].get<int>()];
    float found = 0;
    std::memcpy(&found,
                bytes.data() + 28 + size + view["byteOffset"].get<std::size_t>() +
                    std::size_t(12 * vertex + 4 * k),
                sizeof found);
    return found;
  };
  const auto& primitive = gltf["meshes"][0]["primitives"][0];
  const auto& base = gltf["accessors"][primitive["attributes"]["POSITION"].get<int>()];
  const auto& target = gltf["accessors"][primitive["targets"][0]["POSITION"].get<int>()];
  const int first = evolving.segments[0].triangles[0][0];  // the first corner is vertex 0
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(value(base, 0, k) + value(target, 0, k), evolving.frames[1].positions[first][k],
                1e-6);
  // Without the animation the first frame is seen, and nothing else.
  EXPECT_EQ(read_model(folder / "body.glb").mesh.triangle_count(),
            evolving.mesh(0).triangle_count());
}

TEST(Export, CarriesTheColoursOfTheFirstFrameAlong) {
  const Folder folder;
  make_store(folder);
  ASSERT_EQ(marquetry(folder, {"export", "body.evolving", "-o", "f_%d.ply", "--paint",
                               "body/frame_0000.ply"})
                .status,
            0);
  // Vertices of the store have an order of their own.
  const Model source = read_model(folder / "body/frame_0000.ply");
  const Model first = read_model(folder / "f_0.ply"), second = read_model(folder / "f_1.ply");
  const auto near = [&](const Vector3& p) {
    int best = 0;
    for (int v = 0; v < source.mesh.vertex_count(); ++v)
      if ((source.mesh.positions[v] - p).norm() < (source.mesh.positions[best] - p).norm())
        best = v;
    return best;
  };
  // Of a mesh so coarse there are more of them: those on the way from one to another are in
  // between.
  int same = 0;
  for (int v = 0; v < first.mesh.vertex_count(); ++v) {
    const int u = near(first.mesh.positions[v]);
    if ((first.mesh.positions[v] - source.mesh.positions[u]).norm() > 1e-3) continue;
    ++same;
    for (int c = 0; c < 3; ++c)
      ASSERT_NEAR(first.colors.values[std::size_t(3 * v + c)],
                  source.colors.values[std::size_t(3 * u + c)], 0.01);
  }
  EXPECT_EQ(same, source.mesh.vertex_count());
  EXPECT_NE(first.mesh.positions, second.mesh.positions);
  EXPECT_EQ(first.colors.values, second.colors.values);
  // The third frame is a mesh of its own.
  for (const float value : read_model(folder / "f_2.ply").colors.values)
    ASSERT_NEAR(value, 0.5, 0.01);
}

TEST(Export, CarriesThePicturesOfFilesThatMove) {
  const Folder folder;
  make_square(folder);
  const auto values = [](const Image<float>& picture) {
    return std::vector<float>(picture.values().begin(), picture.values().end());
  };
  const std::vector<float> wanted = values(read_texture(folder / "colours.png").pixels);
  for (const std::string name : {"again.usda", "again.usdz", "again.glb", "packed.glb"}) {
    SCOPED_TRACE(name);
    const bool packed = name == "packed.glb";
    const Result made =
        marquetry(folder, {"export", "square.usda", "-o", name, "--json", "--compress", packed ? "meshopt" : "none"});
    ASSERT_EQ(made.status, 0) << made.error;
    EXPECT_THAT(made.error, testing::Not(HasSubstr("picture")));
    const OpenAnimation found = open_animation(folder / name);
    EXPECT_EQ(values(found.pictures.at(0)), wanted);
    EXPECT_NEAR(found.frames_per_second, 12, 1e-5);
    EXPECT_EQ(found.reader.frames().back().number, 14);
    EXPECT_NEAR(found.numbers_per_second, 24, 1e-5);  // 4 codes last a sixth of a second, as they did
  }
  EXPECT_THAT(file_bytes(folder / "again.usda"), HasSubstr("again_0.png"));
  EXPECT_EQ(values(read_texture(folder / "again_0.png").pixels), wanted);
  for (const std::string name : {"f_%d.obj", "f_%d.ply", "f_%d.glb"}) {
    SCOPED_TRACE(name);
    ASSERT_EQ(marquetry(folder, {"export", "square.usda", "-o", name, "--overwrite"}).status, 0);
    const Model model = read_model(folder / frame_name(name, 12));
    ASSERT_EQ(model.textures.size(), 1U);
    EXPECT_EQ(values(model.textures[0].pixels), wanted);
  }
}

TEST(Export, WritesWhatPlayDoesNotRepeat) {
  const Folder folder;
  make_square(folder);
  EXPECT_THAT(marquetry(folder, {"play", "square.usda", "-o", "once.html"}).error, testing::Not(HasSubstr("repeated")));
  std::string text = file_bytes(folder / "square.usda");
  text.replace(text.find("(1, 1), (0, 1)] ("), 6, "(3, 1)");
  write_bytes(folder / "wide.usda", text);
  const Result played = marquetry(folder, {"play", "wide.usda", "-o", "often.html"});
  EXPECT_EQ(played.status, 0);
  EXPECT_THAT(played.error, testing::AllOf(HasSubstr("warning: wide.usda"), HasSubstr("3, 1"), HasSubstr("repeated")));
  ASSERT_EQ(marquetry(folder, {"export", "wide.usda", "-o", "again.usda"}).status, 0);
  EXPECT_THAT(file_bytes(folder / "again.usda"), HasSubstr("inputs:wrapS = \"repeat\""));
}

TEST(Export, SaysWhatBecomesOfUnits) {
  const Folder folder;
  make_square(folder);
  const auto side = [&](const std::string& name) {
    double most = 0;
    for (const Vector3& p : read_model(folder / name).mesh.positions) most = std::max(most, p.x());
    return most;
  };
  Result made = marquetry(folder, {"export", "square.usda", "-o", "f_%d.glb"});
  EXPECT_THAT(made.error, testing::AllOf(HasSubstr("its unit is 0.01 m"), HasSubstr("multiplied")));
  EXPECT_FLOAT_EQ(side("f_12.glb"), 0.5);
  made = marquetry(folder, {"export", "square.usda", "-o", "f_%d.ply"});
  EXPECT_THAT(made.error, testing::AllOf(HasSubstr("its unit is 0.01 m"), HasSubstr("stay as they are")));
  EXPECT_FLOAT_EQ(side("f_12.ply"), 50);
  made = marquetry(folder, {"export", "square.usda", "-o", "walk.usda"});
  EXPECT_THAT(made.error, testing::Not(HasSubstr("its unit")));
  EXPECT_THAT(file_bytes(folder / "walk.usda"), HasSubstr("metersPerUnit = 0.01"));
  // Frames that were captured are in the same unit, and so is what is made of them.
  made = marquetry(folder, {"export", "square.usda", "-o", "t_%d.glb", "--from", "f_%d.ply", "--size", "16"});
  ASSERT_EQ(made.status, 0) << made.error;
  EXPECT_FLOAT_EQ(side("t_12.glb"), 0.5);
  made = marquetry(folder, {"export", "square.usda", "-o", "t.usda", "--from", "f_%d.ply", "--size", "16"});
  ASSERT_EQ(made.status, 0) << made.error;
  EXPECT_NEAR(open_animation(folder / "t.usda").numbers_per_second, 24, 1e-9);
}

TEST(Export, RefusesWhatItCannotWrite) {
  const Folder folder;
  make_store(folder);
  const auto refusal = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "export");
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 2);
    return result.error;
  };
  EXPECT_THAT(refusal({"body.evolving", "-o", "frame.ply"}), HasSubstr("wanted an animation"));
  EXPECT_THAT(refusal({"body.evolving", "-o", "one_%d_%d.ply"}), HasSubstr("two places"));
  EXPECT_THAT(refusal({"body.evolving", "-o", "f%d.ply", "--frames", "7"}),
              HasSubstr("has no frame 7; it has 0-2"));
  EXPECT_THAT(refusal({"body.evolving", "-o", "a.glb", "--frames", "0-2x2"}),
              HasSubstr("takes all frames"));
  EXPECT_THAT(
      refusal({"body.evolving", "-o", "f%d.ply", "--paint", "body/material/frame_0000.ply"}),
      HasSubstr("wants colours"));
  EXPECT_THAT(refusal({"body.evolving", "-o", "f%d.ply", "--size", "64"}), HasSubstr("--from"));
  ASSERT_EQ(marquetry(folder, {"sample", "torus", "-o", "other.ply"}).status, 0);
  EXPECT_THAT(refusal({"body.evolving", "-o", "f%d.ply", "--paint", "other.ply"}),
              HasSubstr("the first frame's own model"));
  EXPECT_THAT(refusal({"body/frame_0000.ply"}), HasSubstr("found no evolving mesh"));
  EXPECT_THAT(refusal({"none.evolving"}), HasSubstr("none.evolving"));
}

}  // namespace
}  // namespace mq::test
