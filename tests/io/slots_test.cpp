#include "mq/io/slots.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "io/folder.h"
#include "io/models.h"
#include "mq/base/error.h"
#include "mq/io/image_file.h"

namespace mq {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(Slots, GoByOneNameInAllFormats) {
  EXPECT_EQ(slot_of_gltf("baseColorTexture"), "base-colour");
  EXPECT_EQ(slot_of_gltf("clearcoatRoughnessTexture"), "clearcoat-roughness");
  EXPECT_EQ(slot_of_gltf("pbrMetallicRoughness"), "");
  EXPECT_EQ(slot_of_mtl("MAP_KD"), "base-colour");
  EXPECT_EQ(slot_of_mtl("map_bump"), "bump");
  EXPECT_EQ(slot_of_mtl("Kd"), "");
  for (const char* word : {"base-color", "map_Kd", "albedo", "baseColorTexture", "Base_Colour"})
    EXPECT_EQ(slot_from_text(word), "base-colour") << word;
  EXPECT_EQ(slot_from_text("ORM"), "metallic-roughness");
  EXPECT_EQ(slot_from_text("what"), "what");
}

TEST(Slots, OfPicturesWithoutMaterialsAreThoseThatFormatsKnow) {
  EXPECT_EQ(known_slot("albedo", "mesh"), "base-colour");
  EXPECT_EQ(known_slot("sheenColorTexture", "mesh"), "sheen-colour");
  EXPECT_EQ(known_slot("map_Ns", "mesh"), "shininess");
  try {
    known_slot("oclusion", "mesh");
    FAIL() << "no material has such a slot";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), testing::AllOf(HasSubstr("mesh: "), HasSubstr("did you mean 'occlusion'?")));
  }
}

TEST(Slots, SayWhatTheirValuesAre) {
  EXPECT_EQ(meaning_of_slot("base-colour"), TextureMeaning::colours);
  EXPECT_EQ(meaning_of_slot("specular-colour"), TextureMeaning::colours);
  EXPECT_EQ(meaning_of_slot("clearcoat-normal"), TextureMeaning::normals);
  EXPECT_EQ(meaning_of_slot("occlusion"), TextureMeaning::values);
  EXPECT_EQ(meaning_of_slot("metallic-roughness"), TextureMeaning::values);
}

TEST(Slots, AreChosenByWhatThereIs) {
  std::vector<MaterialSlot> slots;
  EXPECT_EQ(chosen_slot(slots, "", "a"), "base-colour");
  add_to_slots(slots, "bump", "b.png", 0);
  add_to_slots(slots, "bump", "b.png", 0);
  EXPECT_EQ(slots[0].pictures.size(), 1u);
  EXPECT_EQ(chosen_slot(slots, "", "a"), "bump");
  EXPECT_EQ(chosen_slot(slots, "normal", "a"), "bump");
  EXPECT_EQ(chosen_slot(slots, "base-color", "a"), "base-colour");
  add_to_slots(slots, "roughness", "r.png", 0);
  EXPECT_EQ(chosen_slot(slots, "", "a"), "base-colour");
  try {
    chosen_slot(slots, "roughnes", "a.obj");
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("roughness"));
    EXPECT_THAT(error.what(), HasSubstr("they have bump, roughness"));
  }
}

class SlotFiles : public FolderTest {
 protected:
  SlotFiles() {
    put("a.obj",
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n"
        "usemtl x\nf 1/1 2/2 3/3\n");
    put("a.mtl", mtl);
    for (const char* name : {"c.png", "n.png", "maps/r.png"}) {
      std::filesystem::create_directories((folder / name).parent_path());
      write_texture(folder / name, ramp_texture(name));
    }
  }
  const std::string mtl =
      "newmtl x\nmap_Ks c.png\nmap_Kd -s 1 1 c.png\nmap_Bump -bm 0.3 n.png\nmap_Pr maps\\r.png\n";
};

TEST_F(SlotFiles, ReadTheSlotThatIsAskedFor) {
  const Model base = read_model(folder / "a.obj");
  EXPECT_EQ(base.slot, "base-colour");
  EXPECT_EQ(base.textures.at(0).name, "c.png");
  std::vector<std::string> names;
  for (const Texture& texture : base.others) {
    names.push_back(texture.name);
    EXPECT_TRUE(texture.pixels.empty());
  }
  EXPECT_THAT(names, ElementsAre("c.png", "n.png", "maps/r.png"));
  const Model rough = read_model(folder / "a.obj", {.textures = {}, .slot = "map_Pr"});
  EXPECT_EQ(rough.textures.at(0).name, "maps/r.png");
  EXPECT_EQ(rough.textures.at(0).meaning, TextureMeaning::values);
  EXPECT_EQ(read_model(folder / "a.obj", {.textures = {}, .slot = "normal"}).textures.at(0).meaning,
            TextureMeaning::normals);
}

TEST_F(SlotFiles, ComeBackWithOnlyTheirsChanged) {
  Model model = read_model(folder / "a.obj", {.textures = {}, .slot = "roughness"});
  model.textures[0].pixels(0, 0) = 1;
  model.textures[0].name = "new.png";
  std::filesystem::create_directories(folder / "out");
  EXPECT_THAT(write_model(folder / "out/b.obj", model), IsEmpty());
  EXPECT_EQ(get("out/b.mtl"), std::string(mtl).replace(mtl.find("maps"), 10, "new.png"));
  for (const char* name : {"c.png", "n.png"})
    EXPECT_EQ(get(std::string("out/") + name), get(name)) << name;
  EXPECT_FALSE(there("out/maps/r.png"));
  EXPECT_EQ(read_model(folder / "out/b.obj", {.textures = {}, .slot = "roughness"}).textures[0].pixels(0, 0), 1);
}

TEST_F(SlotFiles, KeepTheFileThatTheySharedWithOneThatChanges) {
  Model model = read_model(folder / "a.obj", {.textures = {}, .slot = "specular-colour"});
  model.textures[0].pixels(0, 0) = 1;
  std::filesystem::create_directories(folder / "out");
  write_model(folder / "out/b.obj", model);
  const Model now = read_model(folder / "out/b.obj");
  EXPECT_NE(now.textures.at(0).pixels(0, 0), 1);
  EXPECT_EQ(get("out/" + now.textures.at(0).name), get("c.png"));
  EXPECT_EQ(read_model(folder / "out/b.obj", {.textures = {}, .slot = "specular"}).textures.at(0).pixels(0, 0), 1);
}

TEST_F(SlotFiles, SayWhatStaysBehindWhereTheFileIsMadeAnew) {
  const Model model = read_model(folder / "a.obj");
  EXPECT_THAT(write_model(folder / "b.gltf", model),
              ElementsAre(HasSubstr("not all pictures for specular-colour, bump, roughness are in it")));
  const Model rough = read_model(folder / "a.obj", {.textures = {}, .slot = "roughness"});
  EXPECT_THROW(write_model(folder / "c.gltf", rough), Unsupported);
  EXPECT_THROW(write_model(folder / "c.ply", rough), Unsupported);
}

TEST_F(SlotFiles, GiveAPictureToTheSlotWhoseFileItIs) {
  const Model rough = read_model(folder / "a.obj", {.textures = {folder / "maps/r.png"}});
  EXPECT_EQ(rough.slot, "roughness");
  EXPECT_THAT(rough.notes, ::testing::Contains(HasSubstr("r.png is its picture for roughness")));
  write_texture(folder / "other.png", ramp_texture("other.png"));
  EXPECT_EQ(read_model(folder / "a.obj", {.textures = {folder / "other.png"}}).slot, "base-colour");
  put("b.obj", get("a.obj").replace(7, 5, "b.mtl"));
  put("b.mtl", "newmtl x\nmap_Pr maps/r.png\n");
  EXPECT_EQ(read_model(folder / "b.obj").slot, "roughness");
  EXPECT_THROW(read_model(folder / "b.obj", {.textures = {folder / "other.png"}}), InvalidInput);
  EXPECT_EQ(read_model(folder / "b.obj", {.textures = {folder / "other.png"}, .slot = "base-colour"})
                .textures.at(0)
                .name,
            "other.png");
}

}  // namespace
}  // namespace mq
