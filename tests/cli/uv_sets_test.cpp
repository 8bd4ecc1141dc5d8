#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "cli/gltf_square.h"
#include "cli/refusal.h"

namespace mq::test {
namespace {

using testing::HasSubstr;
using Json = nlohmann::json;
using Words = std::vector<std::string>;

void run(const Folder& folder, const Words& words) {
  const Result result = marquetry(folder, words);
  ASSERT_EQ(result.status, 0) << result.error;
}

TEST(UvSets, AreCountedAndThePictureSaysWhichItUses) {
  const Folder folder;
  write_lightmap(folder);
  const Json json = marquetry(folder, {"inspect", "lightmap.gltf", "--json"}).json();
  EXPECT_EQ(json["result"]["uv_sets"], 2);
  EXPECT_EQ(json["result"]["slots"][0]["slot"], "occlusion");
  EXPECT_EQ(json["result"]["slots"][0]["pictures"][0]["uv_set"], 1);
  EXPECT_NEAR(json["result"]["atlas"]["texel_area"].get<double>(), 0.8 * 0.8 * 64 * 64, 0.01);
  const Json first =
      marquetry(folder, {"inspect", "lightmap.gltf", "--uv-set", "0", "--json"}).json();
  EXPECT_NEAR(first["result"]["atlas"]["texel_area"].get<double>(), 0.9 * 0.9 * 64 * 64, 0.01);
}

TEST(UvSets, ALightmapIsFilteredWithItsOwn) {
  const Folder folder;
  write_lightmap(folder);
  write_square_obj(folder, "set0", "0.05", "0.95", "light.png");
  write_square_obj(folder, "set1", "0.1", "0.9", "light.png");
  run(folder, {"filter", "lightmap.gltf", "-o", "its.png", "--beta", "0"});
  run(folder, {"filter", "lightmap.gltf", "-o", "first.png", "--beta", "0", "--uv-set", "0"});
  run(folder, {"filter", "set0.obj", "-o", "obj0.png", "--beta", "0"});
  run(folder, {"filter", "set1.obj", "-o", "obj1.png", "--beta", "0"});
  EXPECT_EQ(file_bytes(folder / "its.png"), file_bytes(folder / "obj1.png"));
  EXPECT_EQ(file_bytes(folder / "first.png"), file_bytes(folder / "obj0.png"));
  EXPECT_NE(file_bytes(folder / "obj0.png"), file_bytes(folder / "obj1.png"));
}

TEST(UvSets, ComeBackWithTheModel) {
  const Folder folder;
  write_lightmap(folder);
  std::filesystem::create_directory(folder / "out");
  run(folder, {"filter", "lightmap.gltf", "-o", "out/lightmap.gltf", "--beta", "1"});
  EXPECT_EQ(file_bytes(folder / "out/lightmap.gltf"), file_bytes(folder / "lightmap.gltf"));
  run(folder, {"filter", "lightmap.gltf", "-o", "made.glb", "--beta", "1"});
  const Json made = marquetry(folder, {"inspect", "made.glb", "--json"}).json();
  EXPECT_EQ(made["result"]["uv_sets"], 2);
  EXPECT_NEAR(made["result"]["atlas"]["texel_area"].get<double>(), 0.64 * 64 * 64, 0.01);
  const Json other = marquetry(folder, {"inspect", "made.glb", "--json", "--uv-set", "0"}).json();
  EXPECT_NEAR(other["result"]["atlas"]["texel_area"].get<double>(), 0.81 * 64 * 64, 0.01);
}

TEST(UvSets, OfPlyAreReadAndGivenBack) {
  const Folder folder;
  write_bytes(folder / "two.ply",
              "ply\nformat ascii 1.0\ncomment TextureFile light.png\nelement vertex 4\n"
              "property float x\nproperty float y\nproperty float z\n"
              "property float s\nproperty float t\nproperty float u1\nproperty float v1\n"
              "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
              "0 0 0 .05 .05 .1 .1\n1 0 0 .95 .05 .9 .1\n1 1 0 .95 .95 .9 .9\n0 1 0 .05 .95 .1 .9\n"
              "3 0 1 2\n3 0 2 3\n");
  write_image(folder / "light.png", busy_picture(64, 64));
  const auto area = [&](const std::string& file, const Words& more) {
    Words words = {"inspect", file, "--json"};
    words.insert(words.end(), more.begin(), more.end());
    const Json json = marquetry(folder, words).json();
    EXPECT_EQ(json["result"]["uv_sets"], 2) << file;
    return json["result"]["atlas"]["texel_area"].get<double>() / (64 * 64);
  };
  EXPECT_NEAR(area("two.ply", {}), 0.81, 1e-5);
  EXPECT_NEAR(area("two.ply", {"--uv-set", "1"}), 0.64, 1e-5);
  std::filesystem::create_directory(folder / "out");
  run(folder, {"filter", "two.ply", "-o", "out/two.ply", "--beta", "0", "--uv-set", "1"});
  EXPECT_NEAR(area("out/two.ply", {"--uv-set", "1"}), 0.64, 1e-5);
  write_pbr(folder);
  run(folder, {"filter", "pbr.gltf", "-o", "made.ply", "--beta", "1"});
  EXPECT_NEAR(area("made.ply", {}), 0.81, 1e-5);
  EXPECT_NEAR(area("made.ply", {"--uv-set", "1"}), 0.64, 1e-5);
}

TEST(UvSets, ThatAreNotThereAreRefused) {
  const Folder folder;
  write_lightmap(folder);
  write_strip(folder);
  write_image(folder / "picture.png", busy_picture(8, 8));
  EXPECT_THAT(marquetry(folder, {"inspect", "lightmap.gltf", "--uv-set", "2"}).error,
              HasSubstr("lightmap.gltf: --uv-set 2: it has 2 sets"));
  EXPECT_EQ(marquetry(folder, {"inspect", "strip.obj", "--uv-set", "0"}).status, 0);
  EXPECT_THAT(marquetry(folder, {"inspect", "strip.obj", "--uv-set", "1"}).error,
              HasSubstr("strip.obj: --uv-set 1: it has 1 set"));
  EXPECT_THAT(marquetry(folder, {"inspect", "picture.png", "--uv-set", "1"}).error,
              HasSubstr("picture.png: is a picture"));
  EXPECT_EQ(marquetry(folder, {"inspect", "strip.obj", "--uv-set", "-1"}).status, 2);
}

TEST(UvSets, ATransformIsOfTheSetThatItNames) {
  const Folder folder;
  write_lightmap(folder);
  const Json transform = {{"KHR_texture_transform", {{"texCoord", 1}, {"scale", {0.5, 0.5}}}}};
  write_bytes(folder / "moved.gltf",
              square_gltf({"light.png"},
                          {{"occlusionTexture", {{"index", 0}, {"extensions", transform}}}})
                  .dump());
  const auto area = [&](const Words& words) {
    return marquetry(folder, words).json()["result"]["atlas"]["texel_area"].get<double>();
  };
  EXPECT_NEAR(area({"inspect", "moved.gltf", "--json"}), 0.16 * 4096, 0.01);
  EXPECT_NEAR(area({"inspect", "moved.gltf", "--json", "--uv-set", "1"}), 0.16 * 4096, 0.01);
  EXPECT_NEAR(area({"inspect", "moved.gltf", "--json", "--uv-set", "0"}), 0.81 * 4096, 0.01);
}

TEST(UvSets, AreMissedInWordsThatNameTheFileOnce) {
  const Folder folder;
  write_bytes(folder / "square.gltf",
              square_gltf({"light.png"}, {{"pbrMetallicRoughness",
                                           {{"baseColorTexture", {{"index", 0}, {"texCoord", 5}}}}}})
                  .dump());
  write_image(folder / "light.png", busy_picture(8, 8));
  for (const char* verb : {"inspect", "export"}) {
    const Result result = marquetry(folder, {verb, "square.gltf"});
    EXPECT_THAT(result.error, HasSubstr("square.gltf, materials[0] names UV set 5")) << verb << result.error;
    EXPECT_THAT(result.error, testing::Not(HasSubstr("square.gltf: square.gltf"))) << verb;
  }
}

}  // namespace
}  // namespace mq::test
