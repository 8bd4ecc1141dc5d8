#include "mq/io/detail/gltf.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "io/folder.h"
#include "io/gltf_scene.h"
#include "io/models.h"
#include "mq/io/image_file.h"
#include "mq/io/uri.h"
#include "mq/io/vertex_colours.h"

namespace mq {
namespace {

using Json = nlohmann::json;
using test::Scene;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
namespace fs = std::filesystem;

TEST(Gltf, TurnsTextureCoordinatesUp) {
  const MeshFile file = Scene().read();
  EXPECT_THAT(file.mesh.triangles, ElementsAre(Triangle{0, 1, 2}));
  EXPECT_EQ(file.mesh.uv(0, 0), Vector2(0, 0.75));
  EXPECT_EQ(file.mesh.uv(0, 2), Vector2(0, 0));
}

TEST(Gltf, ReadsIndicesOfEveryTypeStripsAndFans) {
  Scene scene;
  scene.attributes().erase("TEXCOORD_0");
  scene.attributes()["POSITION"] = scene.add<float>("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0});
  scene.primitive()["indices"] = scene.add<std::uint8_t>("SCALAR", {2, 1, 0});
  EXPECT_THAT(scene.read().mesh.triangles, ElementsAre(Triangle{2, 1, 0}));
  EXPECT_FALSE(scene.read().mesh.has_uvs());
  scene.primitive()["indices"] = scene.add<std::uint32_t>("SCALAR", {1, 2, 3});
  EXPECT_THAT(scene.read().mesh.triangles, ElementsAre(Triangle{1, 2, 3}));
  scene.primitive()["indices"] = scene.add<std::uint16_t>("SCALAR", {0, 1, 2, 3});
  scene.primitive()["mode"] = 5;
  EXPECT_THAT(scene.read().mesh.triangles, ElementsAre(Triangle{0, 1, 2}, Triangle{1, 3, 2}));
  scene.primitive()["mode"] = 6;
  EXPECT_THAT(scene.read().mesh.triangles, ElementsAre(Triangle{1, 2, 0}, Triangle{2, 3, 0}));
  scene.primitive()["mode"] = 1;
  EXPECT_THAT(scene.read().notes, ElementsAre("points and lines are not used", "it has no faces"));
}

TEST(Gltf, AppliesTransformsOfNodesAndKeepsTheOutsideOutside) {
  Scene scene;
  const double s = std::sqrt(0.5);
  scene.json["nodes"] = {{{"children", {1}}, {"translation", {1, 2, 3}}},
                         {{"mesh", 0}, {"rotation", {0, 0, s, s}}, {"scale", {2, 1, 1}}}};
  MeshFile file = scene.read();
  EXPECT_LT((file.mesh.positions[1] - Vector3(1, 4, 3)).norm(), 1e-15);
  EXPECT_LT((file.mesh.positions[2] - Vector3(0, 2, 3)).norm(), 1e-15);
  scene.json["nodes"] = {
      {{"mesh", 0}, {"matrix", {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1}}}};
  file = scene.read();
  EXPECT_EQ(file.mesh.positions[1], Vector3(4, 0, 0));
  EXPECT_THAT(file.mesh.triangles, ElementsAre(Triangle{0, 2, 1}));
  EXPECT_THAT(file.mesh.corner_uvs, ElementsAre(Triangle{0, 2, 1}));
}

TEST(Gltf, ReadsAMeshOnceForEachNodeThatUsesIt) {
  Scene scene;
  scene.json["nodes"] = {{{"mesh", 0}}, {{"mesh", 0}, {"translation", {0, 0, 1}}}, {{"mesh", 0}}};
  scene.json["scenes"][0]["nodes"] = {0, 1};
  const MeshFile file = scene.read();
  EXPECT_THAT(file.mesh.triangles, ElementsAre(Triangle{0, 1, 2}, Triangle{3, 4, 5}));
  EXPECT_EQ(file.mesh.positions[3], Vector3(0, 0, 1));
  EXPECT_EQ(file.mesh.uvs.size(), 3u);
  scene.json.erase("scenes");  // then all roots are read
  EXPECT_EQ(scene.read().mesh.triangle_count(), 3);
}

TEST(Gltf, SharesVerticesOfPrimitivesWithCommonAccessors) {
  Scene scene;
  Json second = scene.primitive();
  scene.json["meshes"][0]["primitives"].push_back(second);
  EXPECT_EQ(scene.read().mesh.vertex_count(), 3);
}

TEST(Gltf, AppliesTextureTransformsAsTheirSpecificationShows) {
  // Its example: the lower left quadrant of the picture, turned clockwise by 90 degrees.
  Scene scene;
  scene.attributes()["TEXCOORD_0"] = scene.add<float>("VEC2", {0, 0, 1, 0, 0, 1});
  scene.paint({{"uri", "a.png"}});
  Json& info = scene.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
  info["extensions"]["KHR_texture_transform"] = {
      {"offset", {0, 1}}, {"rotation", std::acos(-1) / 2}, {"scale", {0.5, 0.5}}};
  const MeshFile file = scene.read();
  EXPECT_LT((file.mesh.uv(0, 0) - Vector2(0, 0)).norm(), 1e-15);
  EXPECT_LT((file.mesh.uv(0, 1) - Vector2(0, 0.5)).norm(), 1e-15);
  EXPECT_LT((file.mesh.uv(0, 2) - Vector2(0.5, 0)).norm(), 1e-15);
}

TEST(Gltf, ReadsTheTextureCoordinatesThatTheTextureAsksFor) {
  Scene scene;
  scene.attributes()["TEXCOORD_1"] =
      scene.add<std::uint16_t>("VEC2", {65535, 0, 0, 65535, 0, 0}, true);
  scene.paint({{"uri", "a%20b.png"}});
  scene.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = 1;
  scene.json["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33071}}};
  scene.json["textures"][0]["sampler"] = 0;
  const MeshFile file = scene.read();
  EXPECT_EQ(file.mesh.uv(0, 0), Vector2(1, 1));
  EXPECT_EQ(file.mesh.uv(0, 1), Vector2(0, 0));
  EXPECT_EQ(file.textures.at(0).name, "a b.png");
  EXPECT_EQ(file.textures.at(0).wrap, Wrap::clamp);
}

TEST(Gltf, ReadsColoursAndQuantisedPositions) {
  Scene scene;
  scene.attributes()["POSITION"] = scene.add<std::int16_t>("VEC3", {0, 0, 0, 7, 0, 0, 0, -300, 0});
  scene.attributes()["COLOR_0"] =
      scene.add<std::uint8_t>("VEC4", {255, 0, 51, 255, 0, 0, 0, 0, 1, 2, 3, 4}, true);
  const MeshFile file = scene.read();
  EXPECT_EQ(file.mesh.positions[2], Vector3(0, -300, 0));
  EXPECT_EQ(file.colors.channels, 4);
  EXPECT_EQ(file.colors.depth, Depth::u8);
  EXPECT_EQ(file.colors.values[2], 51.0f / 255);
}

TEST(Gltf, ReadsSparseAndInterleavedAccessors) {
  Scene scene;
  const std::size_t indices = scene.view<std::uint16_t>({1});
  const std::size_t values = scene.view<float>({5, 6, 7});
  scene.json["accessors"][0]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", indices}, {"componentType", 5123}}},
      {"values", {{"bufferView", values}}}};
  EXPECT_EQ(scene.read().mesh.positions[1], Vector3(5, 6, 7));
  EXPECT_EQ(scene.read().mesh.positions[2], Vector3(0, 1, 0));
  scene.json["accessors"][0].erase("bufferView");  // then the others are zero
  EXPECT_EQ(scene.read().mesh.positions[2], Vector3(0, 0, 0));

  Scene interleaved;
  const std::size_t view =
      interleaved.view<float>({0, 0, 0, 0.5f, 0.5f, 1, 0, 0, 1, 0.5f, 0, 1, 0, 0.5f, 1});
  interleaved.json["bufferViews"][view]["byteStride"] = 20;
  interleaved.json["accessors"] = {
      {{"bufferView", view}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}},
      {{"bufferView", view},
       {"byteOffset", 12},
       {"componentType", 5126},
       {"count", 3},
       {"type", "VEC2"}}};
  EXPECT_EQ(interleaved.read().mesh.positions[2], Vector3(0, 1, 0));
  EXPECT_EQ(interleaved.read().mesh.uv(0, 2), Vector2(0.5, 0));
}

TEST(Gltf, SaysWhatItDoesNotUse) {
  Scene scene;
  scene.json["nodes"] = {{{"mesh", 0}, {"skin", 0}, {"translation", {1, 1, 1}}}};
  scene.json["skins"] = {{{"joints", {0}}}};
  scene.json["animations"] = {Json::object()};
  scene.primitive()["targets"] = {{{"POSITION", 0}}};
  const MeshFile file = scene.read();
  EXPECT_THAT(file.notes, ElementsAre(HasSubstr("bind pose"), HasSubstr("animations"),
                                      HasSubstr("morph targets")));
  EXPECT_EQ(file.mesh.positions[1], Vector3(1, 0, 0));
}

TEST(Gltf, RefusesWithThePlace) {
  const auto with = [](const auto& change) {
    Scene scene;
    change(scene.json);
    return scene.refusal();
  };
  EXPECT_THAT(with([](Json& j) { j["asset"]["version"] = "1.0"; }),
              HasSubstr("\"1.0\" is not 2.0"));
  EXPECT_THAT(with([](Json& j) { j.erase("asset"); }), HasSubstr("has no asset"));
  EXPECT_THAT(with([](Json& j) { j["extensionsRequired"] = {"ABC_x"}; }),
              HasSubstr("\"ABC_x\" is not known"));
  EXPECT_THAT(with([](Json& j) { j["scenes"][0]["nodes"] = {1}; }),
              HasSubstr("a.gltf, nodes[1]: it is not there, 1 are"));
  EXPECT_THAT(with([](Json& j) { j["nodes"][0]["children"] = {0}; }), HasSubstr("two parents"));
  EXPECT_THAT(with([](Json& j) { j["nodes"][0]["mesh"] = "x"; }),
              HasSubstr("nodes[0]: mesh is not a number"));
  EXPECT_THAT(with([](Json& j) {
                j["nodes"][0]["matrix"] = {1, 2};
              }),
              HasSubstr("matrix is not an array of 16 numbers"));
  EXPECT_THAT(with([](Json& j) { j["accessors"][0]["count"] = 4; }),
              HasSubstr("accessors[0]: its 4 elements reach beyond"));
  EXPECT_THAT(with([](Json& j) { j["accessors"][0]["count"] = 1e15; }),
              HasSubstr("more than the file holds"));
  EXPECT_THAT(with([](Json& j) { j["accessors"][0]["count"] = -1; }),
              HasSubstr("count is not a whole number from 0"));
  EXPECT_THAT(with([](Json& j) { j["accessors"][0]["type"] = "MAT4"; }), HasSubstr("type is not"));
  EXPECT_THAT(with([](Json& j) { j["accessors"][0]["componentType"] = 1; }),
              HasSubstr("componentType is not a type of glTF"));
  EXPECT_THAT(with([](Json& j) { j["accessors"][0].erase("bufferView"); }),
              HasSubstr("has no data"));
  EXPECT_THAT(with([](Json& j) { j["bufferViews"][0]["byteOffset"] = 9e15; }),
              HasSubstr("bufferViews[0]: bytes 9000000000000000"));
  EXPECT_THAT(with([](Json& j) {
                j["buffers"] = {{{"byteLength", 8}, {"uri", "data:;base64,!"}}};
              }),
              HasSubstr("buffers[0]: its data URI is not base64"));
  EXPECT_THAT(with([](Json& j) {
                j["buffers"] = {{{"byteLength", 8}, {"uri", "gone.bin"}}};
              }),
              HasSubstr("its file \"gone.bin\" is not there"));
  EXPECT_THAT(with([](Json& j) {
                j["buffers"] = {{{"byteLength", 999}, {"uri", "data:;base64,AAAA"}}};
              }),
              HasSubstr("should have 999 bytes but has 3"));
  EXPECT_THAT(
      with([](Json& j) { j["meshes"][0]["primitives"][0]["attributes"].erase("POSITION"); }),
      HasSubstr("meshes[0].primitives[0]: it has no POSITION"));
  EXPECT_THAT(with([](Json& j) { j["meshes"][0]["primitives"][0]["material"] = 3; }),
              HasSubstr("materials[3]: it is not there"));
}

TEST(Gltf, RefusesIndicesAndCoordinatesOutOfRange) {
  Scene scene;
  scene.primitive()["indices"] = scene.add<std::uint32_t>("SCALAR", {0, 1, 4294967295});
  EXPECT_THAT(scene.refusal(), HasSubstr("index 4294967295 is out of range: it has 3 vertices"));
  scene.primitive()["indices"] = scene.add<std::uint32_t>("SCALAR", {0, 1});
  EXPECT_THAT(scene.refusal(), HasSubstr("2 corners do not make triangles"));
  scene.attributes()["POSITION"] = scene.add<float>("VEC3", {0, 0, 0, 1, NAN, 0, 0, 1, 0});
  EXPECT_THAT(scene.refusal(), HasSubstr("vertex 1 at 1, nan, 0 must be finite"));
  Scene uvs;
  uvs.attributes()["TEXCOORD_0"] = uvs.add<float>("VEC2", {0, 0});
  EXPECT_THAT(uvs.refusal(), HasSubstr("1 texture coordinates for 3 vertices"));
}

// ---- As files ----

class GltfFiles : public FolderTest {
 protected:
  static Bytes png(const std::string& name, int width) {
    return texture_bytes(ramp_texture(name, width, 3), "png").bytes;
  }
};

/// A model whose numbers floats hold.
Model exact_model() {
  Model model = two_texture_square();
  model.mesh.positions = {{0, 0, 0}, {1, 0, 0.25}, {1, 1, 0}, {0, 1, -0.5}};
  model.mesh.uvs = {{0.125, 0.125}, {0.5, 0.125},   {0.5, 0.25},
                    {0.5, 0.5},     {0.875, 0.875}, {0.5, 1}};
  return model;
}

void expect_same_corners(const Model& a, const Model& b) {
  ASSERT_EQ(a.mesh.triangle_count(), b.mesh.triangle_count());
  ASSERT_EQ(a.textures.size(), b.textures.size());
  // What is light in one file and displayed in another is the same in 8 bits.
  const auto shown = [](const VertexSignal& colors) {
    std::vector<long> levels;
    for (const float value : as_displayed(colors).values) levels.push_back(std::lround(255 * value));
    return levels;
  };
  const std::vector<long> of_a = shown(a.colors), of_b = shown(b.colors);
  for (int t = 0; t < a.mesh.triangle_count(); ++t) {
    EXPECT_EQ(a.mesh.texture(t), b.mesh.texture(t));
    ASSERT_EQ(a.mesh.textured(t), b.mesh.textured(t));
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(a.mesh.position(t, k), b.mesh.position(t, k));
      EXPECT_TRUE(!a.mesh.textured(t) || a.mesh.uv(t, k) == b.mesh.uv(t, k)) << t;
      for (int c = 0; c < a.colors.channels; ++c)
        EXPECT_EQ(of_a[std::size_t(a.mesh.triangles[t][k] * a.colors.channels + c)],
                  of_b[std::size_t(b.mesh.triangles[t][k] * b.colors.channels + c)]);
    }
  }
  for (std::size_t i = 0; i < a.textures.size(); ++i) {
    EXPECT_EQ(a.textures[i].pixels, b.textures[i].pixels);
    EXPECT_EQ(a.textures[i].name, b.textures[i].name);
  }
  EXPECT_EQ(a.colors.channels, b.colors.channels);
}

TEST_F(GltfFiles, ComeBackAsTheyWereMade) {
  for (const std::string name : {"m.glb", "m.gltf"}) {
    EXPECT_THAT(write_model(folder / name, exact_model()), IsEmpty());
    expect_same_corners(read_model(folder / name), exact_model());
    EXPECT_EQ(there("left.png"), name == "m.gltf");
  }
  EXPECT_TRUE(there("m.bin"));
}

TEST_F(GltfFiles, KeepEverythingOnTheWayFromObjOverPlyToGlb) {
  write_model(folder / "a.obj", exact_model());
  write_model(folder / "b.ply", read_model(folder / "a.obj"));
  fs::create_directories(folder / "c");
  write_model(folder / "c/c.glb", read_model(folder / "b.ply"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder / "c"), fs::directory_iterator()), 1);
  Model back = read_model(folder / "c/c.glb");
  expect_same_corners(back, exact_model());
  write_model(folder / "c/d.obj", back);
  expect_same_corners(read_model(folder / "c/d.obj"), exact_model());
}

TEST_F(GltfFiles, ComeBackByteForByteWhenNothingChanged) {
  Scene scene;
  scene.paint({{"bufferView", scene.view(png("p", 5))}, {"mimeType", "image/png"}});
  put("m.gltf", scene.gltf());
  write_model(folder / "n.gltf", read_model(folder / "m.gltf"));
  EXPECT_EQ(get("n.gltf"), get("m.gltf"));
  write_model(folder / "m.glb", exact_model());
  write_model(folder / "n.glb", read_model(folder / "m.glb"));
  EXPECT_EQ(get("n.glb"), get("m.glb"));
}

TEST_F(GltfFiles, ChangeOnlyTheNameOfARenamedPicture) {
  Scene scene;
  scene.paint({{"uri", "maps/a%20b.png"}, {"extras", {1, 2}}});
  fs::create_directories(folder / "maps");
  write_texture(folder / "maps/a b.png", ramp_texture("x"));
  put("m.gltf", scene.gltf());
  Model model = read_model(folder / "m.gltf");
  model.textures[0].name = "maps/c d.png";
  model.textures[0].pixels(0, 0) = 1;
  write_model(folder / "n.gltf", model);
  std::string expected = get("m.gltf");
  expected.replace(expected.find("maps/a%20b.png"), 14, "maps/c%20d.png");
  EXPECT_EQ(get("n.gltf"), expected);
  EXPECT_EQ(read_model(folder / "n.gltf").textures[0].pixels, model.textures[0].pixels);
}

TEST_F(GltfFiles, EmbedAChangedPictureInPlaceOfTheOld) {
  for (const bool in_view : {true, false}) {
    Scene scene;
    const Bytes old = png("p", 3);
    if (in_view) {
      scene.paint({{"bufferView", scene.view(old)}, {"name", "skin"}, {"mimeType", "image/png"}});
    } else {
      scene.paint({{"uri", data_uri("image/png", old)}});
    }
    // What lies behind the picture must be found again.
    scene.attributes()["TEXCOORD_0"] = scene.add<float>("VEC2", {0, 0.5f, 1, 0.25f, 0, 1});
    put("m.gltf", scene.gltf());
    Model model = read_model(folder / "m.gltf");
    EXPECT_EQ(model.textures.at(0).name, in_view ? "skin.png" : "texture_0.png");
    model.textures[0].pixels = ramp_texture("q", 40, 40).pixels;
    write_model(folder / "n.gltf", model);
    expect_same_corners(read_model(folder / "n.gltf"), model);
    EXPECT_EQ(files(), 2);
    // Written back, everything but the picture's own bytes is as it was.
    model = read_model(folder / "n.gltf");
    model.textures[0].pixels = ramp_texture("p", 3, 3).pixels;
    write_model(folder / "o.gltf", model);
    expect_same_corners(read_model(folder / "o.gltf"), read_model(folder / "m.gltf"));
    fs::remove(folder / "o.gltf");
  }
}

TEST_F(GltfFiles, EmbedAChangedWebpAsWebpAndNameItsFallback) {
  Scene scene;
  const Bytes webp = texture_bytes(ramp_texture("w", 6, 3), "webp").bytes;
  scene.paint({{"bufferView", scene.view(png("p", 6))}, {"name", "skin"}, {"mimeType", "image/png"}});
  scene.json["images"].push_back(
      {{"bufferView", scene.view(webp)}, {"name", "skin2"}, {"mimeType", "image/webp"}});
  scene.json["textures"][0]["extensions"]["EXT_texture_webp"]["source"] = 1;
  put("m.gltf", scene.gltf());
  Model model = read_model(folder / "m.gltf");
  ASSERT_EQ(model.textures.size(), 1u);
  EXPECT_EQ(model.textures[0].name, "skin2.webp");
  EXPECT_EQ(model.textures[0].pixels, ramp_texture("w", 6, 3).pixels);
  EXPECT_THAT(model.notes, Contains(HasSubstr("\"skin2.webp\" has a stand-in for other programs, \"skin.png\"")));
  model.textures[0].pixels = ramp_texture("q", 40, 40).pixels;
  write_model(folder / "n.gltf", model);
  const Model back = read_model(folder / "n.gltf");
  EXPECT_EQ(back.textures[0].pixels, model.textures[0].pixels);
  EXPECT_EQ(back.textures[0].format.file_format, "webp");
  EXPECT_EQ(Json::parse(get("n.gltf"))["images"][1]["mimeType"], "image/webp");
  // Made anew, it is WebP by its extension.
  write_model(folder / "o.glb", back);
  const std::string glb = get("o.glb");
  EXPECT_THAT(glb, HasSubstr("EXT_texture_webp"));
  EXPECT_EQ(read_model(folder / "o.glb").textures[0].pixels, model.textures[0].pixels);
}

TEST_F(GltfFiles, ReadTheFallbackOfKtx2AndRefuseItAlone) {
  Scene scene;
  scene.paint({{"bufferView", scene.view(png("p", 6))}, {"name", "skin"}, {"mimeType", "image/png"}});
  const Bytes ktx = to_bytes("\xabKTX 20\xbb\r\n\x1a\n" + std::string(68, 'x'));
  scene.json["images"].push_back({{"bufferView", scene.view(ktx)}, {"mimeType", "image/ktx2"}});
  scene.json["textures"][0]["extensions"]["KHR_texture_basisu"]["source"] = 1;
  put("m.gltf", scene.gltf());
  const Model model = read_model(folder / "m.gltf");
  EXPECT_EQ(model.textures.at(0).name, "skin.png");
  EXPECT_THAT(model.notes, Contains(HasSubstr("stand-in for other programs, \"texture_1.ktx2\"")));
  scene.json["textures"][0].erase("source");
  put("m.gltf", scene.gltf());
  EXPECT_THAT(io_error_of([&] { read_model(folder / "m.gltf"); }),
              AllOf(HasSubstr("texture_1.ktx2"), HasSubstr("KTX container")));
}

TEST_F(GltfFiles, StoreMovedVerticesInTheirNodesAndBounds) {
  Scene scene;
  scene.json["nodes"] = {{{"mesh", 0}, {"translation", {10, 0, 0}}, {"scale", {2, 2, 2}}}};
  scene.json["accessors"][0]["min"] = {0, 0, 0};
  scene.json["accessors"][0]["max"] = {1, 1, 0};
  scene.json["buffers"] = {{{"byteLength", scene.data.size()}, {"uri", "m.bin"}}};
  put("m.gltf", scene.gltf());
  put("m.bin", std::string(text_of(scene.data)));
  Model model = read_model(folder / "m.gltf");
  model.mesh.positions[1] = {20, 0, 4};
  write_model(folder / "n.gltf", model);
  const Json json = Json::parse(get("n.gltf"));
  EXPECT_EQ(json["buffers"][0]["uri"], "n.bin");
  EXPECT_EQ(json["accessors"][0]["max"], Json({5, 1, 2}));
  EXPECT_EQ(read_model(folder / "n.gltf").mesh.positions, model.mesh.positions);
  int different = 0;
  for (std::size_t i = 0; i < scene.data.size(); ++i)
    different += get("n.bin")[i] != get("m.bin")[i];
  EXPECT_LE(different, 12);
  EXPECT_GT(different, 0);
}

TEST_F(GltfFiles, HoldColoursAtVerticesAsLight) {
  Model model = exact_model();
  for (float& value : model.colors.values) value = 188.0F / 255;
  write_model(folder / "m.glb", model);
  const Model light = read_model(folder / "m.glb");
  EXPECT_TRUE(light.colors.is_light);
  for (const float value : light.colors.values) EXPECT_NEAR(value, 0.5028, 1e-4);  // IEC 61966-2-1
  for (int v = 0; v < light.mesh.vertex_count(); ++v)
    for (const float value : displayed_colour(light.colors, v)) EXPECT_NEAR(value, 188.0 / 255, 1e-5);
  write_model(folder / "m.ply", light);
  const Model displayed = read_model(folder / "m.ply");
  EXPECT_FALSE(displayed.colors.is_light);
  for (const float value : displayed.colors.values) EXPECT_NEAR(value, 188.0 / 255, 1e-4);
}

TEST_F(GltfFiles, StoreChangedColoursInTheirType) {
  write_model(folder / "m.glb", exact_model());
  Model model = read_model(folder / "m.glb");
  model.colors.values[3] = 1;
  write_model(folder / "n.glb", model);
  const std::string before = get("m.glb"), after = get("n.glb");
  ASSERT_EQ(before.size(), after.size());
  int different = 0;
  for (std::size_t i = 0; i < before.size(); ++i) different += before[i] != after[i];
  EXPECT_EQ(different, 2);  // one value of 16 bits
  EXPECT_EQ(read_model(folder / "n.glb").colors.values, model.colors.values);
}

TEST_F(GltfFiles, AreWrittenAnewWhenANodeSharesWhatMoved) {
  Scene scene;
  scene.json["nodes"] = {{{"mesh", 0}}, {{"mesh", 0}, {"translation", {0, 0, 1}}}};
  scene.json["scenes"][0]["nodes"] = {0, 1};
  put("m.gltf", scene.gltf());
  Model model = read_model(folder / "m.gltf");
  model.mesh.positions[0] = {-1, 0, 0};
  write_model(folder / "n.gltf", model);
  expect_same_corners(read_model(folder / "n.gltf"), model);
}

TEST_F(GltfFiles, AreWrittenAnewWhereTextureCoordinatesShareBytesWithPositions) {
  Scene scene;
  scene.json["accessors"][1]["bufferView"] = 0;
  put("m.gltf", scene.gltf());
  Model model = read_model(folder / "m.gltf");
  model.mesh.positions[0] = {-1, 0, 0};
  write_model(folder / "n.gltf", model);
  expect_same_corners(read_model(folder / "n.gltf"), model);
}

TEST_F(GltfFiles, AreRefusedWhenCutAnywhere) {
  write_model(folder / "m.glb", exact_model());
  const std::string whole = get("m.glb");
  for (std::size_t size = 0; size < whole.size(); size += 29) {
    put("cut.glb", whole.substr(0, size));
    EXPECT_NE(io_error_of([&] { read_model(folder / "cut.glb"); }), "") << size;
  }
}

TEST_F(GltfFiles, KeepPicturesThatWereNotReadWhereTheyAre) {
  write_model(folder / "m.glb", exact_model());
  write_model(folder / "n.glb",
              read_model(folder / "m.glb", {{}, ReadModelOptions::Pictures::skip}));
  EXPECT_EQ(get("n.glb"), get("m.glb"));
}

}  // namespace
}  // namespace mq
