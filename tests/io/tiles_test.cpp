#include "mq/io/tiles.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/folder.h"
#include "io/models.h"
#include "mq/base/error.h"
#include "mq/io/detail/picture_tiles.h"
#include "mq/io/image_file.h"

namespace mq {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(Tiles, AreNumberedInNames) {
  const auto place = [](const char* name) { return tile_name(name).value().place.value(); };
  EXPECT_EQ(place("skin.1001.png"), (TilePlace{0, 0}));
  EXPECT_EQ(place("dir.1002/skin_1012.exr"), (TilePlace{1, 1}));
  EXPECT_EQ(place("a-1999.tif"), (TilePlace{8, 99}));
  EXPECT_EQ(place("skin_u1_v1.png"), (TilePlace{0, 0}));
  EXPECT_EQ(place("skin.u12_v3.png"), (TilePlace{11, 2}));
  EXPECT_EQ(tile_name("skin_u2_v1.png")->pattern(), "skin_<UVTILE>.png");
  EXPECT_EQ(tile_name("a/skin.1002.png")->pattern(), "a/skin.<UDIM>.png");
  EXPECT_EQ(tile_name("skin.<UDIM>.png")->file({3, 2}), "skin.1024.png");
  EXPECT_EQ(tile_name("skin_<UVTILE>.png")->file({0, 2}), "skin_u1_v3.png");
  EXPECT_FALSE(tile_name("skin.<UDIM>.png")->place.has_value());
  for (const char* plain : {"photo1001.png", "IMG_2024.png", "a.1000.png", "a.10011.png", "1001",
                            "1001.png", "a.1001/b.png", "cup_v1.png", "cup_u0_v1.png", ""})
    EXPECT_FALSE(tile_name(plain).has_value()) << plain;
}

TEST(Tiles, HaveNumbersAsFarAsTheyAreCounted) {
  EXPECT_FALSE(tile_name("a.1001.png")->has_number_for({10, 0}));
  EXPECT_FALSE(tile_name("a.1001.png")->has_number_for({-1, 0}));
  EXPECT_TRUE(tile_name("a_u1_v1.png")->has_number_for({10, 0}));
  EXPECT_EQ(common_pattern({"a.1001.png", "a.1013.png"}), "a.<UDIM>.png");
  EXPECT_EQ(common_pattern({"a.1001.png", "b.1013.png"}), "");
  EXPECT_EQ(common_pattern({"a.png", "a.1013.png"}), "");
}

TEST(Tiles, GivenOneByOneAreOnePicture) {
  const auto joined = joined_tiles({"a.1001.png", "b.png", "a.1002.png"}, 2);
  ASSERT_EQ(joined.size(), 2u);
  EXPECT_EQ(joined[0].places.size(), 2u);
  EXPECT_EQ(joined_tiles({"a.1001.png", "a.1002.png"}, 2).size(), 2u);
  EXPECT_EQ(joined_tiles({"a.1001.png", "a.1002.png"}, 1).size(), 1u);
}

/// Two triangles in the tiles 1001 and 1012, and a third beside the first.
class TileFiles : public FolderTest {
 protected:
  TileFiles() {
    put("a.obj",
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n"
        "vt 0.1 0.1\nvt 0.9 0.1\nvt 0.1 0.9\nvt 1.1 1.1\nvt 1.9 1.1\nvt 1.1 1.9\nvt 0.9 0.9\n"
        "usemtl x\nf 1/1 2/2 3/3\nf 1/4 2/5 3/6\nf 2/2 4/7 3/3\n");
    put("a.mtl", "newmtl x\nmap_Kd skin.<UDIM>.png\n");
    write_texture(folder / "skin.1001.png", ramp_texture("a", 8, 8));
    write_texture(folder / "skin.1012.png", ramp_texture("b", 16, 4));
  }
  std::string refusal(const ReadModelOptions& options = {}) {
    try {
      read_model(folder / "a.obj", options);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }
};

TEST_F(TileFiles, AreATextureEach) {
  for (const char* named : {"skin.<UDIM>.png", "skin.1001.png", "skin.1012.png"}) {
    put("a.mtl", std::string("newmtl x\nmap_Kd ") + named + "\n");
    const Model model = read_model(folder / "a.obj");
    ASSERT_EQ(model.textures.size(), 2u) << named;
    EXPECT_EQ(model.textures[0].name, "skin.1001.png");
    EXPECT_EQ(model.textures[1].name, "skin.1012.png");
    EXPECT_EQ(model.textures[1].pixels.width(), 16);
    EXPECT_THAT(model.mesh.textures, ElementsAre(0, 1, 0));
  }
}

TEST_F(TileFiles, MayBeGivenByPatternOrOneByOne) {
  put("a.mtl", "newmtl x\n");
  const Model pattern = read_model(folder / "a.obj", {.textures = {folder / "skin.<UDIM>.png"}});
  EXPECT_THAT(pattern.mesh.textures, ElementsAre(0, 1, 0));
  const Model listed =
      read_model(folder / "a.obj", {.textures = {folder / "skin.1012.png", folder / "skin.1001.png"}});
  EXPECT_THAT(listed.mesh.textures, ElementsAre(0, 1, 0));
  EXPECT_EQ(listed.textures[1].path, folder / "skin.1012.png");
  std::filesystem::copy_file(folder / "skin.1012.png", folder / "skin.1003.png");
  const Model more = read_model(
      folder / "a.obj",
      {.textures = {folder / "skin.1001.png", folder / "skin.1003.png", folder / "skin.1012.png"}});
  EXPECT_EQ(more.textures.size(), 2u);
  EXPECT_THAT(more.notes, Contains(HasSubstr("skin.1003.png, which is not used")));
  std::filesystem::rename(folder / "skin.1001.png", folder / "skin_u1_v1.png");
  std::filesystem::rename(folder / "skin.1012.png", folder / "skin_u2_v2.png");
  const Model mari = read_model(folder / "a.obj", {.textures = {folder / "skin_<UVTILE>.png"}});
  EXPECT_THAT(mari.mesh.textures, ElementsAre(0, 1, 0));
  EXPECT_EQ(mari.textures[1].name, "skin_u2_v2.png");
}

TEST_F(TileFiles, ThatAreMissingAreRefusedByTheirNumber) {
  std::filesystem::remove(folder / "skin.1012.png");
  EXPECT_THAT(refusal(), HasSubstr("needs tile 1012 of \"skin.<UDIM>.png\" for 1 triangle"));
  EXPECT_THAT(refusal({.textures = {folder / "skin.1001.png"}}), HasSubstr("tile 1012"));
  put("a.mtl", "newmtl x\nmap_Kd skin.1001.png\n");
  EXPECT_THAT(refusal(), HasSubstr("rename it: its number says tiles"));
}

TEST_F(TileFiles, AreNoneOfAPictureThatRepeats) {
  write_texture(folder / "brick.png", ramp_texture("a", 8, 8));
  put("a.mtl", "newmtl x\nmap_Kd brick.png\n");
  EXPECT_EQ(read_model(folder / "a.obj").textures.size(), 1u);
  // A number on pictures with charts left of the first tile is no tile's either.
  put("a.mtl", "newmtl x\nmap_Kd skin.1001.png\n");
  put("a.obj", get("a.obj") + "vt -0.9 0\nvt -0.1 0\nvt -0.9 1\nf 1/8 2/9 3/10\n");
  EXPECT_EQ(read_model(folder / "a.obj").textures.size(), 1u);
  put("a.mtl", "newmtl x\nmap_Kd skin.<UDIM>.png\n");
  EXPECT_THAT(refusal(), HasSubstr("the tile from (-1, 0)"));
}

TEST_F(TileFiles, ComeBackByteForByteAndUnderOnePattern) {
  Model model = read_model(folder / "a.obj");
  std::filesystem::create_directories(folder / "out");
  EXPECT_THAT(write_model(folder / "out/a.obj", model), IsEmpty());
  for (const char* file : {"a.obj", "a.mtl", "skin.1001.png", "skin.1012.png"})
    EXPECT_EQ(get(std::string("out/") + file), get(file)) << file;
  put("c.obj", "mtllib c.mtl" + get("a.obj").substr(12));
  put("c.mtl", "newmtl x\nmap_Kd skin.1001.png\n");
  write_model(folder / "out/c.obj", read_model(folder / "c.obj"));
  EXPECT_EQ(get("out/c.mtl"), get("c.mtl"));
  for (Texture& texture : model.textures) texture.name = "new_" + texture.name;
  model.textures[1].pixels(0, 0) = 1;
  write_model(folder / "out/b.obj", model);
  EXPECT_EQ(get("out/b.mtl"), "newmtl x\nmap_Kd new_skin.<UDIM>.png\n");
  const Model now = read_model(folder / "out/b.obj");
  EXPECT_EQ(now.textures.at(1).pixels(0, 0), 1);
  EXPECT_TRUE(std::ranges::equal(now.textures.at(0).pixels.values(), model.textures[0].pixels.values()));
}

TEST_F(TileFiles, OfNoCommonPatternAreMaterialsOfANewFile) {
  Model model = read_model(folder / "a.obj");
  model.textures[0].name = "one.png";
  model.textures[1].name = "two.png";
  std::filesystem::create_directories(folder / "out");
  write_model(folder / "out/a.obj", model);
  const Model now = read_model(folder / "out/a.obj");
  EXPECT_EQ(now.textures.size(), 2u);
  EXPECT_THAT(now.mesh.textures, ElementsAre(0, 1, 0));
  write_model(folder / "out/a.glb", read_model(folder / "a.obj"));
  const Model glb = read_model(folder / "out/a.glb");
  EXPECT_EQ(glb.textures.size(), 2u);
  EXPECT_EQ(glb.textures[1].pixels.width(), 16);
}

TEST_F(TileFiles, OfGltfAreReadAsMaterialsOrByPattern) {
  const Model model = read_model(folder / "a.obj");
  std::filesystem::create_directories(folder / "out");
  write_model(folder / "out/a.gltf", model);
  EXPECT_EQ(read_model(folder / "out/a.gltf").textures.size(), 2u);
  // Both materials name the first tile; it and the second are found by where triangles lie.
  std::string text = get("out/a.gltf");
  text.replace(text.find("skin.1012.png"), 13, "skin.1001.png");
  put("out/b.gltf", text);
  const Model now = read_model(folder / "out/b.gltf");
  std::vector<std::string> names;
  for (const Texture& texture : now.textures) names.push_back(texture.name);
  EXPECT_THAT(names, Contains("skin.1012.png"));
  write_model(folder / "out/c.gltf", now);
  EXPECT_EQ(get("out/c.gltf"), text);
}

}  // namespace
}  // namespace mq
