// What materials say beside their pictures, where textures are baked.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cli/gltf_square.h"
#include "cli/refusal.h"
#include "mq/image/colour.h"
#include "mq/image/resample.h"
#include "mq/io/file_names.h"
#include "mq/io/materials.h"

namespace mq::test {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::FloatNear;
using testing::HasSubstr;
using Json = nlohmann::json;
using Words = std::vector<std::string>;

constexpr float step = 1.0F / 255;

Result run_bake(const Folder& folder, const Words& words) {
  Result result = marquetry(folder, words);
  EXPECT_EQ(result.status, 0) << result.error;
  return result;
}

/// two.gltf: a painted square that shines, and beside it one of dark orange glass without pictures.
void write_two(const Folder& folder) {
  write_pbr(folder);
  Json gltf = Json::parse(file_bytes(folder / "pbr.gltf"));
  gltf["materials"][0]["name"] = "painted";
  gltf["materials"][0]["emissiveFactor"] = {1, 1, 1};
  gltf["materials"].push_back({{"name", "glass"},
                               {"doubleSided", true},
                               {"alphaMode", "BLEND"},
                               {"pbrMetallicRoughness",
                                {{"baseColorFactor", {1, 0.5, 0, 1}}, {"metallicFactor", 0}, {"roughnessFactor", 0.25}}}});
  gltf["meshes"].push_back(gltf["meshes"][0]);
  gltf["meshes"][1]["primitives"][0]["material"] = 1;
  gltf["nodes"].push_back({{"mesh", 1}, {"translation", {2, 0, 0}}});
  gltf["scenes"][0]["nodes"] = {0, 1};
  write_bytes(folder / "two.gltf", gltf.dump(1));
}

bool is_glass(const Model& model, int t) { return model.mesh.position(t, 0).x() > 1.5; }

/// What a slot shows in the middle of the first triangle of the glass, or of the paint.
std::vector<float> shown(const Folder& folder, const std::string& file, const std::string& slot, bool of_glass) {
  const Model model = read_model(folder / file, {.textures = {}, .slot = slot});
  for (int t = 0; t < model.mesh.triangle_count(); ++t) {
    if (is_glass(model, t) != of_glass) continue;
    const Texture& texture = model.textures[std::size_t(model.mesh.texture(t))];
    const Vector2 uv = (model.mesh.uv(t, 0) + model.mesh.uv(t, 1) + model.mesh.uv(t, 2)) / 3;
    std::vector<float> values(std::size_t(texture.pixels.channels()));
    sample(texture.pixels, uv.x() * texture.pixels.width() - 0.5, (1 - uv.y()) * texture.pixels.height() - 0.5,
           texture.wrap, values);
    return values;
  }
  ADD_FAILURE() << "no such triangle";
  return {};
}

TEST(VerbUnwrap, KeepsMaterialsOfWhatItBakes) {
  const Folder folder;
  write_two(folder);
  run_bake(folder, {"unwrap", "two.gltf", "--bake", "-o", "new.glb", "--size", "64"});
  const Model model = read_model(folder / "new.glb");
  const ModelMaterials found = file_materials(model);
  ASSERT_EQ(found.materials.size(), 2u);
  for (int t = 0; t < model.mesh.triangle_count(); ++t)
    EXPECT_EQ(found.of(t)->name, is_glass(model, t) ? "glass" : "painted");
  const Material& glass = found.materials[found.materials[0].name == "glass" ? 0 : 1];
  EXPECT_THAT(glass.base_colour, ElementsAre(1, 0.5F, 0, 1));
  EXPECT_EQ(glass.roughness, 0.25F);
  EXPECT_TRUE(glass.is_double_sided);
  EXPECT_EQ(glass.alpha, Material::Alpha::blend);
  EXPECT_THAT(glass.emissive, Each(0));
  // Times the factors it is what it was.
  EXPECT_THAT(shown(folder, "new.glb", "base-colour", true), ElementsAre(1, 1, 0));
  EXPECT_THAT(shown(folder, "new.glb", "emissive", true), Each(0));
  EXPECT_THAT(shown(folder, "new.glb", "metallic-roughness", true), ElementsAre(1, 1, 0));
  EXPECT_THAT(shown(folder, "new.glb", "normal", true),
              ElementsAre(FloatNear(0.5F, step), FloatNear(0.5F, step), 1));
}

TEST(VerbBake, PutsFactorsThatDifferIntoThePictures) {
  const Folder folder;
  write_two(folder);
  run_bake(folder, {"unwrap", "two.gltf", "-o", "target.obj"});
  run_bake(folder, {"bake", "two.gltf", "target.obj", "-o", "new.glb", "--size", "64"});
  const ModelMaterials found = file_materials(read_model(folder / "new.glb"));
  ASSERT_EQ(found.materials.size(), 1u);
  EXPECT_TRUE(found.materials[0].is_double_sided);
  EXPECT_THAT(found.materials[0].base_colour, Each(1));
  EXPECT_THAT(found.materials[0].emissive, Each(1));
  EXPECT_THAT(shown(folder, "new.glb", "base-colour", true),
              ElementsAre(1, FloatNear(float(srgb_from_linear(0.5)), step), 0));
  EXPECT_THAT(shown(folder, "new.glb", "emissive", true), Each(0));
  EXPECT_THAT(shown(folder, "new.glb", "metallic-roughness", true),
              ElementsAre(1, FloatNear(0.25F, step), 0));
  EXPECT_THAT(shown(folder, "new.glb", "emissive", false), testing::Not(Each(0)));
}

TEST(VerbBake, LeavesFactorsThatAllHaveInTheMaterial) {
  const Folder folder;
  write_pbr(folder);
  Json gltf = Json::parse(file_bytes(folder / "pbr.gltf"));
  gltf["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = {0.5, 0.5, 0.5, 1};
  write_bytes(folder / "dark.gltf", gltf.dump(1));
  write_square_obj(folder, "target", "0.2", "0.8", "none.png");
  write_bytes(folder / "target.mtl", "newmtl m\n");
  for (const std::string name : {"pbr", "dark"})
    run_bake(folder, {"bake", name + ".gltf", "target.obj", "-o", name + "_new.glb", "--size", "64"});
  const Model plain = read_model(folder / "pbr_new.glb"), dark = read_model(folder / "dark_new.glb");
  EXPECT_TRUE(std::ranges::equal(plain.textures[0].pixels.values(), dark.textures[0].pixels.values()));
  EXPECT_THAT(file_materials(dark).materials.at(0).base_colour, ElementsAre(0.5F, 0.5F, 0.5F, 1));
}

TEST(VerbUnwrap, LeavesNoColoursBesideAPictureOfThem) {
  const Folder folder;
  write_bytes(folder / "painted.obj",
              "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0 1 1 0\nf 1 2 3\nf 1 3 4\n");
  run_bake(folder, {"unwrap", "painted.obj", "--bake", "-o", "new.glb", "--size", "64"});
  EXPECT_EQ(read_model(folder / "new.glb").colors.channels, 0);
  run_bake(folder, {"unwrap", "painted.obj", "--bake", "-o", "new.ply", "--size", "64"});
  EXPECT_EQ(read_model(folder / "new.ply").colors.channels, 3);
}

TEST(VerbUnwrap, PutsFactorsIntoPicturesOfObj) {
  const Folder folder;
  write_two(folder);
  run_bake(folder, {"unwrap", "two.gltf", "--bake", "-o", "new.obj", "--size", "64"});
  EXPECT_THAT(shown(folder, "new.obj", "base-colour", true),
              ElementsAre(1, FloatNear(float(srgb_from_linear(0.5)), step), 0));
  run_bake(folder, {"filter", "new.obj", "--beta", "1", "-o", "back.glb"});
  for (const Material& material : file_materials(read_model(folder / "back.glb")).materials)
    EXPECT_THAT(material.base_colour, Each(1)) << material.name;
  for (const Material& material : file_materials(read_model(folder / "new.obj")).materials)
    if (material.name == "glass") {
      EXPECT_EQ(material.roughness, 0.25F);  // has no picture in MTL
    }
}

TEST(Bakes, KeepOcclusionThatSharesAPicture) {
  const Folder folder;
  write_pbr(folder);
  Json gltf = Json::parse(file_bytes(folder / "pbr.gltf"));
  gltf["materials"][0]["occlusionTexture"] = {{"index", 1}};
  write_bytes(folder / "orm.gltf", gltf.dump(1));
  write_square_obj(folder, "target", "0.2", "0.8", "none.png");
  write_bytes(folder / "target.mtl", "newmtl m\n");
  run_bake(folder, {"unwrap", "orm.gltf", "--bake", "-o", "new.gltf", "--size", "64"});
  run_bake(folder, {"bake", "orm.gltf", "target.obj", "-o", "onto.gltf", "--size", "64"});
  for (const std::string name : {"new.gltf", "onto.gltf"}) {
    const Json made = Json::parse(file_bytes(folder / name));
    EXPECT_EQ(made["materials"][0]["occlusionTexture"]["index"],
              made["materials"][0]["pbrMetallicRoughness"]["metallicRoughnessTexture"]["index"]) << name;
  }
  // MTL has a word for one of the two; its picture is one of those that are announced, and named as such.
  write_bytes(folder / "metallic-roughness.png", "precious");
  const Result result =
      run_bake(folder, {"unwrap", "orm.gltf", "--bake", "-o", "third.obj", "--size", "64", "--json", "--no-clobber"});
  EXPECT_EQ(file_bytes(folder / "metallic-roughness.png"), "precious");
  const std::string line = "map_AO ", mtl = file_bytes(folder / "third.mtl");
  const std::size_t begin = mtl.find(line) + line.size();
  EXPECT_THAT(result.json()["result"]["outputs"].dump(), HasSubstr(mtl.substr(begin, mtl.find('\n', begin) - begin)));
}

TEST(VerbBake, ShowsWhatTheSourceDoesByOneSlotToo) {
  const Folder folder;
  write_square_obj(folder, "target", "0.2", "0.8", "none.png");
  write_bytes(folder / "target.mtl", "newmtl grey\nKd 0.8 0.8 0.8\n");
  write_image(folder / "p.png", busy_picture(16, 16));
  const Json material{{"doubleSided", true},
                      {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}, {"metallicFactor", 0.5}}}};
  write_bytes(folder / "source.gltf", square_gltf({"p.png"}, material).dump(1));
  run_bake(folder, {"bake", "source.gltf", "target.obj", "-o", "new.glb", "--size", "32"});
  const ModelMaterials found = file_materials(read_model(folder / "new.glb"));
  ASSERT_EQ(found.materials.size(), 1u);
  EXPECT_TRUE(found.materials[0].is_double_sided);
  EXPECT_EQ(found.materials[0].metallic, 0.5F);
  EXPECT_THAT(found.materials[0].base_colour, Each(1));
}

TEST(VerbBake, TakesColoursAtVerticesOfGltfAsLight) {
  const Folder folder;
  write_square_obj(folder, "target", "0.2", "0.8", "none.png");
  write_bytes(folder / "target.mtl", "newmtl m\n");
  Image<float> grey(16, 16, 3, 128.0F / 255);
  write_image(folder / "grey.png", grey);
  write_square_obj(folder, "source", "0.1", "0.9", "grey.png");
  run_bake(folder, {"bake", "source.obj", "target.obj", "--vertices", "-o", "at.glb"});
  for (const float value : read_model(folder / "at.glb").colors.values)
    EXPECT_NEAR(value, linear_from_srgb(128.0 / 255), 1e-4);
  run_bake(folder, {"bake", "at.glb", "target.obj", "-o", "back.png", "--size", "16"});
  EXPECT_NEAR(read_texture(folder / "back.png").pixels(8, 8, 0), 128.0 / 255, 1.1 / 255);
}

TEST(VerbFilter, TakesColoursAtVerticesWithoutPictures) {
  const Folder folder;
  write_square_obj(folder, "target", "0.2", "0.8", "none.png");
  write_bytes(folder / "target.mtl", "newmtl m\n");
  write_image(folder / "p.png", busy_picture(16, 16));
  write_square_obj(folder, "source", "0.1", "0.9", "p.png");
  run_bake(folder, {"bake", "source.obj", "target.obj", "--vertices", "-o", "at.glb"});
  run_bake(folder, {"filter", "at.glb", "--vertices", "--beta", "0", "--length", "50%", "-o", "smooth.glb"});
  EXPECT_NE(read_model(folder / "smooth.glb").colors.values, read_model(folder / "at.glb").colors.values);
}

/// A map whose normals lean towards +v, green up, and the same with green down.
void write_leaning(const Folder& folder) {
  for (const auto& [name, green] : {std::pair("up", 0.75F), {"down", 0.25F}}) {
    Image<float> map(32, 32, 3);
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < 32; ++x) map(x, y, 0) = 0.5F, map(x, y, 1) = green, map(x, y, 2) = 0.933F;
    write_image(folder / (std::string(name) + ".png"), map);
    write_square_obj(folder, name, "0.1", "0.9", "none.png");
    write_bytes(folder / (std::string(name) + ".mtl"), "newmtl m\nnorm " + std::string(name) + ".png\n");
  }
}

TEST(NormalSpace, DirectXStaysGreenDownButInGltf) {
  const Folder folder;
  write_leaning(folder);
  const auto green = [&](const Words& words) {
    run_bake(folder, words);
    const std::string& file = words[words.size() - 1];
    const Image<float> map = names_picture(file) ? read_texture(folder / file).pixels
                                                      : read_model(folder / file, {.textures = {}, .slot = "normal"})
                                                            .textures[0].pixels;
    return map(map.width() / 2, map.height() / 2, 1);
  };
  const auto up = FloatNear(0.75F, 2 * step), down = FloatNear(0.25F, 2 * step);
  const Words directx{"--normal-space", "directx", "-o"};
  const auto with = [&](Words words, const Words& more, const std::string& file) {
    words.insert(words.end(), more.begin(), more.end());
    words.push_back(file);
    return words;
  };
  const Words bake_up{"bake", "up.obj", "down.obj", "--slot", "normal"};
  const Words bake_down{"bake", "down.obj", "up.obj", "--slot", "normal"};
  EXPECT_THAT(green(with(bake_up, {"-o"}, "a.png")), up);
  EXPECT_THAT(green(with(bake_down, directx, "b.png")), down);
  EXPECT_THAT(green(with(bake_down, directx, "b.glb")), up);
  const Words filter{"filter", "down.obj", "--slot", "normal", "--beta", "0"};
  EXPECT_THAT(green(with(filter, directx, "d.png")), down);
  EXPECT_THAT(green(with(filter, directx, "d.glb")), up);
}

}  // namespace
}  // namespace mq::test
