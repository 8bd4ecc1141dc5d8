#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "cli/models.h"
#include "cli/refusal.h"
#include "evolving/evolving_models.h"
#include "mq/io/evolving_file.h"
#include "mq/io/image_file.h"

namespace mq::test {
namespace {

using testing::HasSubstr;

/// Two squares side by side, as quads, with a colour at each vertex, and a vertex nobody uses.
const char* const corner_obj =
    "v 7 7 7 0 0 0\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 2 0 0 0 0 1\nv 0 1 0 1 1 0\nv 1 1 0 0 1 1\nv 2 "
    "1 0 1 0 1\n"
    "f 2 3 6 5\nf 3 4 7 6\n";

TEST(Unwrap, LeavesTheShapeAloneAndAddsCoordinatesToCorners) {
  const Folder folder;
  write_bytes(folder / "corner.obj", corner_obj);
  const Result result =
      marquetry(folder, {"unwrap", "corner.obj", "-o", "flat.obj", "--size", "64", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto figures = result.json()["result"];
  EXPECT_EQ(figures["flipped"], 0);
  EXPECT_EQ(figures["overlapping_charts"], 0);
  EXPECT_EQ(figures["overlapping_texels"], 0);
  EXPECT_NEAR(figures["stretch"].get<double>(), 1, 1e-9);
  EXPECT_GT(figures["occupancy"].get<double>(), 0.4);
  for (const char* step : {"charts", "flatten", "pack"})
    EXPECT_TRUE(result.json()["seconds"].contains(step)) << step;
  const Model before = read_model(folder / "corner.obj"), after = read_model(folder / "flat.obj");
  EXPECT_EQ(after.mesh.positions, before.mesh.positions);
  EXPECT_EQ(after.mesh.triangles, before.mesh.triangles);
  EXPECT_EQ(after.colors.values, before.colors.values);
  ASSERT_TRUE(after.mesh.has_uvs());
  EXPECT_EQ(marquetry(folder, {"check", "flat.obj"}).status, 0);
}

/// Pictures lie by the texture coordinates that were there.
TEST(Unwrap, SaysWhatItWritesAndThatPicturesStayBehind) {
  const Folder folder;
  ASSERT_EQ(marquetry(folder, {"sample", "cube", "-o", "./", "--size", "64"}).status, 0);
  const Result made = marquetry(folder, {"unwrap", "cube.obj", "-o", "flat.obj", "--trials", "5", "--json"});
  ASSERT_EQ(made.status, 0) << made.error;
  EXPECT_THAT(made.error, HasSubstr("without cube.png, which lies by the old texture coordinates: --bake brings it over"));
  EXPECT_EQ(made.json()["result"]["outputs"], nlohmann::json::parse(R"(["flat.obj", "flat.mtl"])"));
  EXPECT_TRUE(std::filesystem::exists(folder / "flat.mtl"));
  EXPECT_EQ(marquetry(folder, {"check", "flat.obj"}).status, 0);
}

TEST(Unwrap, ReplacesCoordinatesInEveryFormat) {
  const Folder folder;
  ASSERT_EQ(marquetry(folder, {"sample", "cube", "-o", "./", "--size", "64"}).status, 0);
  for (const char* name : {"new.ply", "new.gltf", "new.glb", "new.obj"}) {
    SCOPED_TRACE(name);
    const Result result =
        marquetry(folder, {"unwrap", "cube.ply", "-o", name, "--size", "128", "--trials", "5"});
    ASSERT_EQ(result.status, 0) << result.error;
    EXPECT_THAT(result.output, HasSubstr("chart"));
    EXPECT_EQ(marquetry(folder, {"check", name}).status, 0);
  }
  EXPECT_EQ(read_model(folder / "new.ply").mesh.positions,
            read_model(folder / "cube.ply").mesh.positions);
}

TEST(Unwrap, MakesAnAtlasThatOtherVerbsWorkOn) {
  const Folder folder;
  ASSERT_EQ(marquetry(folder, {"sample", "torus", "-o", "./", "--size", "64", "--triangles", "900"})
                .status,
            0);
  ASSERT_EQ(
      marquetry(folder, {"unwrap", "torus.obj", "-o", "new.obj", "--size", "128", "--trials", "5"})
          .status,
      0);
  write_image(folder / "noise.png", busy_picture(128, 128));
  const Result result = marquetry(folder, {"filter", "new.obj", "noise.png", "-o", "smooth.png",
                                           "--beta", "0", "--length", "4tx", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_TRUE(result.json()["solve"]["converged"]);
}

TEST(Unwrap, RefusesWhatItCannotDo) {
  const Folder folder;
  write_bytes(folder / "corner.obj", corner_obj);
  write_bytes(folder / "line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
  EXPECT_THAT(refusal(folder, {"unwrap", "line.obj", "-o", "flat.obj"}, "flat.obj"),
              HasSubstr("no area"));
  EXPECT_THAT(refusal(folder, {"unwrap", "corner.obj", "-o", "flat.png"}, "flat.png"),
              HasSubstr("wanted a model"));
  EXPECT_THAT(
      refusal(folder, {"unwrap", "corner.obj", "-o", "flat.obj", "--stretch", "1"}, "flat.obj"),
      HasSubstr("stretch"));
  EXPECT_THAT(
      refusal(folder, {"unwrap", "corner.obj", "-o", "flat.obj", "--size", "16", "--gutter", "100"},
              "flat.obj"),
      HasSubstr("smaller gutter"));
  for (const std::vector<std::string>& option : {std::vector<std::string>{"--coherence", "3"},
                                                 {"--renew", "frames"},
                                                 {"--look-ahead", "2"},
                                                 {"--uv-error", "0"}}) {
    std::vector<std::string> words = {"unwrap", "corner.obj", "-o", "flat.obj"};
    words.insert(words.end(), option.begin(), option.end());
    EXPECT_THAT(refusal(folder, words, "flat.obj"),
                testing::AllOf(HasSubstr(option[0]), HasSubstr("evolving mesh")));
  }
  write_evolving(folder / "sheet.evolving", patched_sheet(4, 3, 5), store_step(4));
  EXPECT_THAT(
      refusal(folder, {"unwrap", "sheet.evolving", "--frames", "0-4", "-o", "atlas.evolving"},
              "atlas.evolving"),
      testing::AllOf(HasSubstr("sheet.evolving"), HasSubstr("leave --frames out")));
}

TEST(Unwrap, GivesAnEvolvingMeshOneAtlas) {
  const Folder folder;
  const EvolvingMesh before = patched_sheet(10, 4, 5);
  write_evolving(folder / "sheet.evolving", before, store_step(10), "{\"made\":\"here\"}",
                 std::vector<std::string>(before.frames.size(), "{\"seen\":1}"), 0, 2);
  const Result result =
      marquetry(folder, {"unwrap", "sheet.evolving", "-o", "atlas.evolving", "--size", "128",
                         "--trials", "2", "--coherence", "5", "--picture", "lives.png", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto found = result.json()["result"];
  EXPECT_EQ(found["frames"].size(), before.frames.size());
  EXPECT_EQ(found["frames"][3]["frame"], before.frames[3].number);
  EXPECT_EQ(found["flipped"], 0);
  EXPECT_LE(found["energy"], found["first_energy"]);
  EXPECT_GT(picture_info(folder / "lives.png").width, 400);
  const EvolvingReader reader(folder / "atlas.evolving");
  EXPECT_EQ(reader.broken(), "");
  EXPECT_THAT(reader.about(), HasSubstr("here"));
  EXPECT_EQ(reader.group_frames(), 2);
  EXPECT_THAT(reader.frames()[2].measured, HasSubstr("seen"));
  const EvolvingMesh after = reader.read();
  EXPECT_NO_THROW(check(after));
  ASSERT_EQ(after.segments.size(), before.segments.size());
  for (std::size_t s = 0; s < after.segments.size(); ++s) {
    EXPECT_EQ(after.segments[s].triangle_ids, before.segments[s].triangle_ids);
    EXPECT_FALSE(after.segments[s].uvs.empty());
  }
  // The frames that are exported have it.
  ASSERT_EQ(marquetry(folder, {"export", "atlas.evolving", "-o", "frame_%04d.obj"}).status, 0);
  EXPECT_EQ(marquetry(folder, {"check", "frame_0003.obj"}).status, 0);
}

TEST(Unwrap, RoundsTextureCoordinatesOfAnEvolvingMeshAsItIsAskedTo) {
  const Folder folder;
  write_evolving(folder / "sheet.evolving", patched_sheet(6, 3, 5), store_step(6));
  const auto uvs = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"unwrap", "sheet.evolving", "-o", "atlas.evolving", "--size", "64",
                                      "--trials", "1", "--overwrite"};
    words.insert(words.end(), more.begin(), more.end());
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 0) << result.error;
    return EvolvingReader(folder / "atlas.evolving").segment(0).uvs;
  };
  const std::vector<Vector2> exact = uvs({"--uv-error", "0"}), coarse = uvs({"--uv-error", "0.4"}), usual = uvs({});
  ASSERT_EQ(exact.size(), coarse.size());
  ASSERT_EQ(exact.size(), usual.size());
  double farthest = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    EXPECT_LE(64 * (usual[i] - exact[i]).cwiseAbs().maxCoeff(), store_uv_error);
    farthest = std::max(farthest, 64 * (coarse[i] - exact[i]).cwiseAbs().maxCoeff());
  }
  EXPECT_LE(farthest, 0.4);
  EXPECT_GT(farthest, 0.1);
}

TEST(Unwrap, ForgetsWhereItIsToldTo) {
  const Folder folder;
  write_evolving(folder / "sheet.evolving", patched_sheet(6, 3, 5), store_step(6));
  const auto lifespan = [&](const char* when) {
    const Result result =
        marquetry(folder, {"unwrap", "sheet.evolving", "-o", "atlas.evolving", "--size", "64",
                           "--trials", "1", "--renew", when, "--json", "--overwrite"});
    EXPECT_EQ(result.status, 0) << result.error;
    return result.json()["result"]["lifespan"].get<double>();
  };
  EXPECT_DOUBLE_EQ(lifespan("frames"), 1);
  EXPECT_DOUBLE_EQ(lifespan("segments"), 3);
  EXPECT_GT(lifespan("never"), 3);
}

TEST(Unwrap, MakesAnAtlasThatKnowsOnlySoManyFrames) {
  const Folder folder;
  write_evolving(folder / "sheet.evolving", patched_sheet(8, 4, 5), store_step(8));
  const auto run = [&](std::vector<std::string> more) {
    std::vector<std::string> words = {
        "unwrap", "sheet.evolving", "-o", "atlas.evolving", "--size",
        "64",     "--trials",       "1",  "--json",         "--overwrite"};
    words.insert(words.end(), more.begin(), more.end());
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 0) << result.error;
    return std::pair(result.json()["result"], file_bytes(folder / "atlas.blocks"));
  };
  const auto [whole, whole_blocks] = run({});
  const auto [known, known_blocks] = run({"--look-ahead", "11"});
  EXPECT_EQ(known_blocks, whole_blocks);
  EXPECT_EQ(known["energy"], whole["energy"]);
  const auto [online, online_blocks] = run({"--look-ahead", "2"});
  EXPECT_NE(online_blocks, whole_blocks);
  EXPECT_EQ(whole["plans"], 1);
  EXPECT_EQ(online["plans"], 4 + online["cleared"].size());
  EXPECT_EQ(online["energy_of_whole"], whole["energy"]);
  write_bytes(folder / "corner.obj", corner_obj);
  EXPECT_THAT(
      refusal(folder, {"unwrap", "corner.obj", "-o", "flat.obj", "--look-ahead", "3"}, "flat.obj"),
      HasSubstr("--look-ahead"));
}

TEST(Unwrap, LeavesAStoreAloneWhereItCannot) {
  const Folder folder;
  write_evolving(folder / "sheet.evolving", patched_sheet(6, 2, 5), store_step(10));
  EXPECT_THAT(refusal(folder, {"unwrap", "sheet.evolving", "-o", "sheet.obj"}, "sheet.obj"),
              HasSubstr("ends in .evolving"));
  EXPECT_THAT(refusal(folder,
                      {"unwrap", "sheet.evolving", "-o", "flat.evolving", "--size", "16",
                       "--gutter", "100"},
                      "flat.evolving"),
              HasSubstr("smaller gutter"));
  EXPECT_THAT(refusal(folder, {"unwrap", "sheet.evolving", "-o", "flat.evolving", "--view", "up"},
                      "flat.evolving"),
              HasSubstr("--view"));
  write_bytes(folder / "corner.obj", corner_obj);
  EXPECT_THAT(
      refusal(folder, {"unwrap", "corner.obj", "-o", "flat.obj", "--picture", "a.png"}, "flat.obj"),
      HasSubstr("--picture"));
}

}  // namespace
}  // namespace mq::test
