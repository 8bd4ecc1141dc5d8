// Normal maps in tangent space, from files to files.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cli/gltf_square.h"
#include "cli/refusal.h"
#include "mq/io/normals.h"

namespace mq::test {
namespace {

using testing::HasSubstr;
using testing::Not;
using Json = nlohmann::json;
using Words = std::vector<std::string>;

Image<float> picture_of(int width, int height, const Eigen::Vector3f& colour) {
  Image<float> picture(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) picture(x, y, c) = colour[c];
  return picture;
}

const Eigen::Vector3f flat_colour(128.0F / 255, 128.0F / 255, 1);

/// The strip of two charts, whose material names a colour and a normal map.
void write_strip_with_normals(const Folder& folder, const Image<float>& normals) {
  write_strip(folder);
  write_bytes(folder / "strip.mtl", "newmtl strip\nmap_Kd strip.png\nnorm normal.png\n");
  write_image(folder / "normal.png", normals);
}

/// Slopes of a slight wave, as tangent space has them.
Image<float> waves() {
  Image<float> map(64, 48, 3);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) {
      const Vector3 n = Vector3(0.4 * std::sin(0.9 * x), 0.3 * std::cos(0.7 * y), 1).normalized();
      for (int c = 0; c < 3; ++c) map(x, y, c) = float((n[c] + 1) / 2);
    }
  return map;
}

TEST(NormalMaps, ThatAreFlatComeBackByteForByte) {
  for (const char* verb : {"filter", "denoise", "seams", "shock"}) {
    const Folder folder;
    write_strip_with_normals(folder, picture_of(64, 48, flat_colour));
    Words words = {verb, "strip.obj", "--slot", "normal", "-o", "out.png"};
    if (words[0] == "filter") words.insert(words.end(), {"--beta", "0", "--length", "9tx"});
    const Result result = marquetry(folder, words);
    ASSERT_EQ(result.status, 0) << verb << result.error;
    EXPECT_EQ(file_bytes(folder / "out.png"), file_bytes(folder / "normal.png")) << verb;
  }
}

TEST(NormalMaps, AreAmongAllSlotsOfAModelWithSeams) {
  const Folder folder;
  write_strip_with_normals(folder, waves());
  const Result result = marquetry(
      folder, {"filter", "strip.obj", "--slot", "all", "--beta", "0", "-o", "pictures/", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["slots"].size(), 2U);
  EXPECT_NE(file_bytes(folder / "pictures/normal.png"), file_bytes(folder / "normal.png"));
}

TEST(NormalMaps, ComeBackByteForByteWithBetaOne) {
  const Folder folder;
  write_strip_with_normals(folder, waves());
  const Result result = marquetry(folder, {"filter", "strip.obj", "normal.png", "--normals", "--beta",
                                           "1", "-o", "out.png"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(file_bytes(folder / "out.png"), file_bytes(folder / "normal.png"));
}

TEST(NormalMaps, GivenWithoutTheirSlotAreTakenByTheirValuesOrByWord) {
  const Folder folder;
  write_strip(folder);
  write_image(folder / "map.png", waves());
  const auto filtered = [&](const Words& more, const std::string& out) {
    Words words = {"filter", "strip.obj", "map.png", "--beta", "0", "--length", "2tx", "-o", out};
    words.insert(words.end(), more.begin(), more.end());
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 0) << result.error;
    return result.error;
  };
  EXPECT_THAT(filtered({"--normals"}, "a.png"),
              HasSubstr("of its normals point along z, so they are taken to be in tangent space"));
  EXPECT_THAT(filtered({"--normal-space", "tangent"}, "b.png"), Not(HasSubstr("taken to be")));
  filtered({"--normal-space", "object"}, "c.png");
  filtered({"--normal-space", "directx"}, "d.png");
  EXPECT_EQ(file_bytes(folder / "a.png"), file_bytes(folder / "b.png"));
  EXPECT_NE(file_bytes(folder / "a.png"), file_bytes(folder / "c.png"));
  const std::string refused = marquetry(folder, {"filter", "strip.obj", "map.png", "--beta", "0", "-o",
                                                 "e.png", "--normal-space", "dx"})
                                  .error;
  EXPECT_THAT(refused, HasSubstr("directx"));
}

/// Both charts of the strip hold one flat map: their colours jump where their normals do not.
TEST(NormalMaps, AreMeasuredAtSeamsInTheModelsAxes) {
  const Folder folder;
  write_strip_with_normals(folder, waves());
  const Result result = marquetry(
      folder, {"seams", "strip.obj", "--slot", "normal", "-o", "out.png", "--json", "--depth", "16"});
  ASSERT_EQ(result.status, 0) << result.error;
  const Json seams = result.json()["result"]["seams"];
  EXPECT_GT(seams["before"]["rms"], 0.02);
  EXPECT_LT(seams["after"]["rms"].get<double>(), 0.2 * seams["before"]["rms"].get<double>());
}

TEST(NormalMaps, AreFilledAndStitchedAcrossSeams) {
  const Folder folder;
  write_strip_with_normals(folder, waves());
  for (const Words& words : {Words{"fill", "strip.obj", "--slot", "normal", "-o", "fill.png"},
                             Words{"stitch", "strip.obj", "--slot", "normal", "-o", "stitch.png"}}) {
    Words all = words;
    all.push_back("--json");
    const Result result = marquetry(folder, all);
    ASSERT_EQ(result.status, 0) << result.error;
    const Json seams = result.json()["result"]["seams"];
    EXPECT_LT(seams["after"]["rms"], seams["before"]["rms"]) << words[0];
    const Image<float> after = read_texture(folder / words.back()).pixels;
    for (const float blue : after.values()) EXPECT_TRUE(std::isfinite(blue));
  }
}

TEST(NormalMaps, AreDescribed) {
  const Folder folder;
  write_pbr(folder);
  const Result result = marquetry(folder, {"inspect", "pbr.gltf", "--slot", "normal", "--json"});
  const Json normals = result.json()["result"]["normals"];
  EXPECT_EQ(normals["axes"], "tangent");
  EXPECT_EQ(normals["upright"], 1);
  EXPECT_THAT(normals["frames"], HasSubstr("MikkTSpace"));
  for (const char* verb : {"inspect", "check"})
    EXPECT_THAT(marquetry(folder, {verb, "pbr.gltf", "--slot", "normal"}).output,
                HasSubstr("in tangent space (100 % point along z)"));
  EXPECT_TRUE(marquetry(folder, {"inspect", "pbr.gltf", "--json"}).json()["result"]["normals"].is_null());
}

TEST(NormalMaps, ThatCannotBeTakenAreRefused) {
  const Folder folder;
  write_strip(folder);
  const auto refused = [&](const std::string& map, const Words& more) {
    Words words = {"filter", "strip.obj", map, "--beta", "0", "-o", "out.png"};
    words.insert(words.end(), more.begin(), more.end());
    return refusal(folder, words, "out.png");
  };
  write_image(folder / "xy.png", picture_of(64, 48, {0.5F, 0.5F, 0}));
  EXPECT_THAT(refused("xy.png", {"--normal-space", "tangent"}), HasSubstr("blue is 0 everywhere"));
  write_image(folder / "grey.png", Image<float>(64, 48, 1, 0.5F));
  EXPECT_THAT(refused("grey.png", {"--normals"}), HasSubstr("this picture has 1 channel"));
  write_image(folder / "n.png", waves());
  EXPECT_EQ(refused("n.png", {"--normal-space", "tangent", "--vertices"}).empty(), false);
  write_pbr(folder);
  EXPECT_THAT(
      refusal(folder,
              {"bake", "pbr.gltf", "pbr.gltf", "--slot", "normal", "--vertices", "-o", "b.ply"},
              "b.ply"),
      HasSubstr("in tangent space, which vertices have not"));
}

/// Of a map's texels whose centres lie in the strip's charts, as the model's normals: what they
/// differ.
double off_in_charts(const Image<float>& a, const Image<float>& b) {
  double most = 0;
  for (int y = 8; y < 40; ++y)
    for (int x : {6, 10, 15, 20, 25, 38, 45, 50, 55})
      for (int c = 0; c < 3; ++c) most = std::max(most, std::abs(double(a(x, y, c)) - b(x, y, c)));
  return most;
}

/// Waves that are wide enough for texels to show them.
Image<float> wide_waves() {
  Image<float> map(64, 48, 3);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) {
      const Vector3 n = Vector3(0.4 * std::sin(0.3 * x), 0.3 * std::cos(0.2 * y), 1).normalized();
      for (int c = 0; c < 3; ++c) map(x, y, c) = float((n[c] + 1) / 2);
    }
  return map;
}

TEST(NormalMaps, AreBakedByUnwrapAndBackByBake) {
  const Folder folder;
  write_strip_with_normals(folder, wide_waves());
  const Result made = marquetry(
      folder, {"unwrap", "strip.obj", "--bake", "-o", "new.glb", "--size", "256", "--json"});
  ASSERT_EQ(made.status, 0) << made.error;
  const Json slots = made.json()["result"]["slots"];
  ASSERT_EQ(slots.size(), 2U);
  EXPECT_THAT(slots[1]["frames"]["target"], HasSubstr("computed normals"));
  EXPECT_LE(slots[1]["seams"]["target"]["rms"], slots[1]["seams"]["source"]["rms"]);
  const Model model = read_model(folder / "new.glb", {.textures = {}, .slot = "normal"});
  const CornerFrames frames = file_frames(model);
  for (const Eigen::Vector3f& n : frames.normals)
    EXPECT_LT((n - Eigen::Vector3f::UnitZ()).norm(), 1e-6F);
  for (const Eigen::Vector4f& t : frames.tangents) EXPECT_FALSE(t.isZero());
  const Result one = marquetry(folder, {"unwrap", "strip.obj", "--bake", "--slot", "normal", "-o",
                                        "one.glb", "--size", "256"});
  ASSERT_EQ(one.status, 0) << one.error;
  EXPECT_TRUE(std::ranges::equal(read_model(folder / "one.glb").textures.front().pixels.values(),
                                 model.textures.front().pixels.values()));
  const Result back = marquetry(
      folder, {"bake", "new.glb", "strip.obj", "--slot", "normal", "-o", "back.png", "--json"});
  ASSERT_EQ(back.status, 0) << back.error;
  EXPECT_THAT(back.json()["result"]["frames"]["source"], HasSubstr("tangents of the file"));
  EXPECT_LT(off_in_charts(read_texture(folder / "normal.png").pixels,
                          read_texture(folder / "back.png").pixels),
            0.02);
}

TEST(NormalMaps, ThatAreFlatAreFlatInOtherCharts) {
  const Folder folder;
  write_strip_with_normals(folder, picture_of(64, 48, flat_colour));
  ASSERT_EQ(marquetry(folder, {"unwrap", "strip.obj", "--bake", "--slot", "normal", "-o", "new.obj",
                               "--size", "64"})
                .status,
            0);
  const Model model = read_model(folder / "new.obj");
  EXPECT_EQ(model.slot, "normal");
  EXPECT_THAT(file_bytes(folder / "new.obj"), HasSubstr("vn 0 0 1"));
  const Image<float> map = picture_of(64, 64, flat_colour);
  EXPECT_TRUE(std::ranges::equal(model.textures.front().pixels.values(), map.values()));
}

TEST(NormalMaps, AreBakedOfAPictureThatNoMaterialNames) {
  const Folder folder;
  write_strip_with_normals(folder, wide_waves());
  const auto baked = [&](const Words& given, const std::string& out) {
    Words words{"bake", "strip.obj", "strip.obj"};
    words.insert(words.end(), given.begin(), given.end());
    words.insert(words.end(), {"--slot", "normal", "-o", out, "--json"});
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 0) << result.error;
    EXPECT_THAT(result.json()["result"]["frames"]["source"], HasSubstr("computed normals"));
  };
  baked({}, "named.png");
  write_bytes(folder / "strip.mtl", "newmtl strip\nmap_Kd strip.png\n");
  baked({"normal.png"}, "given.png");
  EXPECT_EQ(file_bytes(folder / "given.png"), file_bytes(folder / "named.png"));
}

TEST(NormalMaps, AreOfTheShapeWhereThereIsNone) {
  const Folder folder;
  write_strip(folder);
  const Result result = marquetry(folder, {"bake", "strip.obj", "strip.obj", "--slot", "normal",
                                           "-o", "shape.png", "--size", "32"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_THAT(result.error,
              HasSubstr("has no normal map: the shading normals of its shape are baked"));
  EXPECT_TRUE(std::ranges::equal(read_texture(folder / "shape.png").pixels.values(),
                                 picture_of(32, 32, flat_colour).values()));
}

}  // namespace
}  // namespace mq::test
