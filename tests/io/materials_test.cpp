// What materials say beside their pictures, in files made anew.
#include "mq/io/materials.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "io/folder.h"
#include "io/gltf_scene.h"
#include "io/models.h"
#include "mq/io/bytes.h"
#include "mq/io/normals.h"

namespace mq {
namespace {

using Json = nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

class Materials : public FolderTest {
 protected:
  void put_scene(const std::string& name, const Json& material) const {
    test::Scene scene;
    scene.paint({{"uri", "p.png"}});
    scene.json["materials"][0] = material;
    put(name, scene.gltf());
    write_image(folder / "p.png", ramp_texture("p.png").pixels);
  }
};

const Json glass{{"name", "Dark glass"},
                 {"pbrMetallicRoughness",
                  {{"baseColorTexture", {{"index", 0}}}, {"baseColorFactor", {0.5, 0.25, 0.125, 0.75}}, {"metallicFactor", 0.25}, {"roughnessFactor", 0.5}}},
                 {"emissiveFactor", {0.0, 0.5, 1.0}},
                 {"alphaMode", "MASK"},
                 {"alphaCutoff", 0.25},
                 {"doubleSided", true},
                 {"extensions",
                  {{"KHR_materials_ior", {{"ior", 1.25}}},
                   {"KHR_materials_clearcoat", {{"clearcoatFactor", 0.5}, {"clearcoatTexture", {{"index", 0}}}}}}}};

Material only_material(const std::filesystem::path& path) {
  const ModelMaterials found = file_materials(read_model(path));
  EXPECT_EQ(found.materials.size(), 1u);
  EXPECT_THAT(found.of_triangle, testing::Each(0));
  return found.materials.empty() ? Material() : found.materials[0];
}

/// Written to another file without the one it came from.
std::filesystem::path made_anew(const std::filesystem::path& from, const std::filesystem::path& to) {
  Model model = read_model(from);
  forget_file(model, Tangents::kept);
  write_model(to, model);
  return to;
}

TEST_F(Materials, OfGltfComeBackFromAGltfMadeAnew) {
  put_scene("a.gltf", glass);
  Material before = only_material(folder / "a.gltf");
  EXPECT_EQ(before.name, "Dark glass");
  EXPECT_THAT(before.base_colour, ElementsAre(0.5F, 0.25F, 0.125F, 0.75F));
  EXPECT_EQ(before.metallic, 0.25F);
  EXPECT_EQ(before.roughness, 0.5F);
  EXPECT_THAT(before.emissive, ElementsAre(0, 0.5F, 1));
  EXPECT_EQ(before.alpha, Material::Alpha::mask);
  EXPECT_EQ(before.alpha_cutoff, 0.25F);
  EXPECT_TRUE(before.is_double_sided);
  EXPECT_THAT(before.slots, ElementsAre("base-colour", "clearcoat"));
  const auto path = made_anew(folder / "a.gltf", folder / "b.glb");
  Material after = only_material(path);
  after.slots = before.slots;  // its picture is not in the file made anew, which a remark says
  EXPECT_TRUE(before == after);
  EXPECT_EQ(Json::parse(after.more_gltf),
            Json::parse(R"({"KHR_materials_ior":{"ior":1.25},"KHR_materials_clearcoat":{"clearcoatFactor":0.5}})"));
}

TEST_F(Materials, AreMattInGltfWhereAFileHadNone) {
  put("a.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
               "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  const Material matt = only_material(made_anew(folder / "a.ply", folder / "b.glb"));
  EXPECT_EQ(matt.metallic, 0.0F);
  EXPECT_EQ(matt.base_colour, Material().base_colour);
}

TEST_F(Materials, OfGltfAreInMtlAsFarAsItHasWords) {
  put_scene("a.gltf", glass);
  Model model = read_model(folder / "a.gltf");
  EXPECT_THAT(write_model(folder / "b.obj", model),
              testing::Contains(HasSubstr("of its materials it does not say that they have two sides, where "
                                          "alpha cuts, their extensions")));
  const Material after = only_material(folder / "b.obj");
  EXPECT_EQ(after.name, "Dark_glass");
  EXPECT_THAT(get("b.mtl"), HasSubstr("\nKd 0.5 0.25 0.125\n"));
  EXPECT_THAT(after.base_colour, ElementsAre(1, 1, 1, 0.75F));  // a picture stands for it
  EXPECT_EQ(after.metallic, 0.25F);
  EXPECT_EQ(after.roughness, 0.5F);
  EXPECT_THAT(after.emissive, ElementsAre(0, 0.5F, 1));
}

TEST_F(Materials, OfMtlKeepTheirOtherLines) {
  const std::string lines = "Ns 250\nKs 0.5 0.5 0.5\nillum 2\n";
  put("a.mtl", "newmtl red\n# painted\nKd 1 0.5 0\nTr 0.25\nmap_aat on\n" + lines);
  put("a.obj", "mtllib a.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const Material before = only_material(folder / "a.obj");
  EXPECT_THAT(before.base_colour, ElementsAre(1, 0.5F, 0, 0.75F));
  EXPECT_EQ(before.more_mtl, lines);
  EXPECT_TRUE(before == only_material(made_anew(folder / "a.obj", folder / "b.obj")));
  // glTF has none of these lines; what is not said of metal is matt there.
  Material in_gltf = only_material(made_anew(folder / "a.obj", folder / "b.gltf"));
  EXPECT_EQ(in_gltf.metallic, 0);
  EXPECT_EQ(in_gltf.alpha, Material::Alpha::blend);
  EXPECT_THAT(in_gltf.base_colour, ElementsAre(1, 0.5F, 0, 0.75F));
}

TEST_F(Materials, PicturesOfMtlStandForItsColours) {
  write_image(folder / "p.png", ramp_texture("p.png").pixels);
  put("a.mtl", "newmtl m\nKd 0 0 0\nmap_Kd p.png\nKe 0 0 0\nmap_Ke p.png\nd 1e999\nPm x\n");
  put("a.obj",
              "mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n");
  const Material found = only_material(folder / "a.obj");
  EXPECT_THAT(found.base_colour, ElementsAre(1, 1, 1, 1));
  EXPECT_THAT(found.emissive, ElementsAre(1, 1, 1));
  EXPECT_FALSE(found.metallic);
}

TEST_F(Materials, DoNotShineByAPictureThatIsLeftOut) {
  put_scene("a.gltf",
              {{"emissiveTexture", {{"index", 0}}}, {"emissiveFactor", {1, 1, 1}},
               {"pbrMetallicRoughness", {{"metallicRoughnessTexture", {{"index", 0}}}}}});
  Model model = read_model(folder / "a.gltf");
  forget_file(model, Tangents::kept);
  model.slots.clear();
  model.others.clear();
  model.textures.clear();
  model.mesh.textures.clear();
  write_model(folder / "b.glb", model);
  const Material found = only_material(folder / "b.glb");
  EXPECT_THAT(found.emissive, ElementsAre(0, 0, 0));
  EXPECT_EQ(found.metallic, 0);
}

TEST_F(Materials, ThatShareATextureStaySeveral) {
  write_image(folder / "p.png", ramp_texture("p.png").pixels);
  put("a.mtl", "newmtl one\nmap_Kd p.png\nPr 0.5\nnewmtl two\nmap_Kd p.png\nPr 0.75\nnewmtl bare\nKd 0 1 0\n");
  put("a.obj",
              "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\n"
              "usemtl one\nf 1/1 2/2 3/3\nusemtl bare\nf 2 4 3\nusemtl two\nf 1/1 3/2 5/3\nf 1 2 5\n");
  for (const char* name : {"b.obj", "b.glb"}) {
    const Model model = read_model(made_anew(folder / "a.obj", folder / name));
    const ModelMaterials found = file_materials(model);
    ASSERT_EQ(model.textures.size(), 1u) << name;
    std::vector<std::string> names;
    std::vector<float> rough;
    for (int t = 0; t < model.mesh.triangle_count(); ++t) {
      ASSERT_NE(found.of(t), nullptr);
      names.push_back(found.of(t)->name);
      rough.push_back(found.of(t)->roughness.value_or(-1));
    }
    EXPECT_THAT(names, testing::UnorderedElementsAre("one", "bare", "two", "two")) << name;
    EXPECT_THAT(rough, testing::IsSupersetOf({0.5F, 0.75F, 0.75F}));
    EXPECT_THAT(found.of(int(std::ranges::find(names, "bare") - names.begin()))->base_colour,
                ElementsAre(0, 1, 0, 1));
  }
}

TEST(JoinedMaterials, KeepWhatAllSay) {
  Material a, b;
  a.name = "a", b.name = "b";
  a.base_colour = b.base_colour = {0.5F, 0.5F, 0.5F, 1};
  EXPECT_TRUE(look_alike(a, b));
  const Material alike = joined({&a, &b}, {});
  EXPECT_EQ(alike.base_colour, a.base_colour);
  EXPECT_EQ(alike.name, "");
  EXPECT_EQ(joined({&a, &a}, {}).name, "a");
  b.base_colour[0] = 1;
  b.emissive = {0, 0, 2};
  a.metallic = b.metallic = 0.5F;
  b.alpha = Material::Alpha::blend;
  a.is_double_sided = true;
  const Material different = joined({&a, &b}, {"base-colour", "emissive"});
  EXPECT_EQ(different.metallic, 0.5F);
  EXPECT_THAT(joined({&a, &b}, {"base-colour"}).emissive, testing::Each(0));
  EXPECT_EQ(lost_by_joining({&a, &b}, {"base-colour"}), "emission, which are transparent");
  EXPECT_EQ(different.base_colour, Material().base_colour);
  EXPECT_THAT(different.emissive, ElementsAre(1, 1, 1));
  EXPECT_EQ(different.alpha, Material::Alpha::blend);
  EXPECT_TRUE(different.is_double_sided);
  EXPECT_TRUE(joined({}, {}) == Material());
}

TEST_F(Materials, OfNobodyKnowsWhatAreNone) {
  put("a.mtl", "newmtl untextured\nKa 1 1 1\nKd 1 1 1\nnewmtl plain\n");
  put("a.obj", "mtllib a.mtl\nusemtl untextured\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nusemtl plain\nf 1 3 2\n"
               "usemtl missing\nf 2 3 1\n");
  EXPECT_THAT(file_materials(read_model(folder / "a.obj")).of_triangle, ElementsAre(-1, 0, -1));
}

TEST_F(Materials, OfPicturesWithTheirFactorsHaveNone) {
  Material glow;
  glow.base_colour = {0.5F, 1, 1, 0.5F};
  glow.emissive = {0, 0.25F, 0};
  glow.roughness = 0.5F;
  glow.alpha = Material::Alpha::blend;
  const Material bare = without_factors(glow, {"base-colour", "emissive", "roughness"});
  EXPECT_THAT(bare.base_colour, testing::Each(1));
  EXPECT_THAT(bare.emissive, testing::Each(1));
  EXPECT_EQ(bare.roughness, 1);
  EXPECT_EQ(without_factors(glow, {"emissive"}).roughness, 0.5F);
  EXPECT_EQ(without_factors(glow, {"base-colour"}, AlphaFactor::stays).base_colour[3], 0.5F);
  EXPECT_EQ(bare.alpha, Material::Alpha::blend);
  EXPECT_THAT(without_factors(Material(), {"emissive"}).emissive, testing::Each(0));
}

}  // namespace
}  // namespace mq
