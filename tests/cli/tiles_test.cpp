#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/models.h"
#include "cli/refusal.h"

namespace mq::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using Json = nlohmann::json;
using Words = std::vector<std::string>;

/// The strip over two tiles: bust.1001.png and bust.1002.png.
void write_tiles(const Folder& folder, const std::string& named = "bust.<UDIM>.png") {
  std::string text = strip_obj;
  text.replace(text.find("vt"), text.find("f 1") - text.find("vt"),
               "vt 0.1 0.1\nvt 0.9 0.1\nvt 0.9 0.9\nvt 0.1 0.9\n"
               "vt 1.1 0.1\nvt 1.9 0.1\nvt 1.9 0.9\nvt 1.1 0.9\n");
  write_bytes(folder / "strip.obj", text);
  write_bytes(folder / "strip.mtl", "newmtl strip\nmap_Kd " + named + "\n");
  write_image(folder / "bust.1001.png", busy_picture(64, 48));
  Image<float> other = busy_picture(64, 48);
  for (float& value : other.values()) value = 1 - value;
  write_image(folder / "bust.1002.png", other);
}

TEST(TilesOfPictures, AreListed) {
  const Folder folder;
  write_tiles(folder);
  const Json json = marquetry(folder, {"inspect", "strip.obj", "--json"}).json();
  EXPECT_THAT(json["result"]["tiles"], ElementsAre("bust.1001.png", "bust.1002.png"));
  EXPECT_EQ(json["input"]["textures"].size(), 2u);
  EXPECT_THAT(marquetry(folder, {"check", "strip.obj"}).output,
              HasSubstr("tiles: 2: bust.1001.png, bust.1002.png"));
}

TEST(TilesOfPictures, StayApart) {
  for (const char* named : {"bust.<UDIM>.png", "bust.1001.png"}) {
    const Folder folder;
    write_tiles(folder, named);
    ASSERT_EQ(marquetry(folder, {"filter", "strip.obj", "-o", "out/", "--beta", "1"}).status, 0);
    for (const char* tile : {"bust.1001.png", "bust.1002.png"})
      EXPECT_EQ(file_bytes(folder / "out" / tile), file_bytes(folder / tile)) << named;
    ASSERT_EQ(marquetry(folder, {"filter", "strip.obj", "-o", "soft.obj", "--beta", "0"}).status, 0);
    EXPECT_EQ(file_bytes(folder / "soft.mtl"), std::string("newmtl strip\nmap_Kd soft_") + named + "\n");
    EXPECT_NE(file_bytes(folder / "soft_bust.1001.png"), file_bytes(folder / "soft_bust.1002.png"));
    EXPECT_EQ(marquetry(folder, {"inspect", "soft.obj", "--json"}).json()["result"]["tiles"].size(), 2u);
  }
}

TEST(TilesOfPictures, GoToAPatternOfNames) {
  const Folder folder;
  write_tiles(folder);
  ASSERT_EQ(
      marquetry(folder, {"filter", "strip.obj", "-o", "soft_<UVTILE>.png", "--beta", "0"}).status, 0);
  ASSERT_EQ(marquetry(folder, {"filter", "strip.obj", "bust.1001.png", "bust.1002.png", "-o",
                               "soft.<UDIM>.png", "--beta", "0"})
                .status,
            0);
  EXPECT_EQ(file_bytes(folder / "soft_u1_v1.png"), file_bytes(folder / "soft.1001.png"));
  EXPECT_EQ(file_bytes(folder / "soft_u2_v1.png"), file_bytes(folder / "soft.1002.png"));
  EXPECT_NE(file_bytes(folder / "soft.1001.png"), file_bytes(folder / "bust.1001.png"));
}

TEST(TilesOfPictures, ThatAreMissingOrCannotBeNamedAreRefused) {
  const Folder folder;
  write_tiles(folder);
  EXPECT_THAT(refusal(folder, {"filter", "strip.obj", "-o", "out.png", "--beta", "0"}, "out.png"),
              HasSubstr("has 2 textures"));
  std::filesystem::remove(folder / "bust.1002.png");
  EXPECT_THAT(refusal(folder, {"filter", "strip.obj", "-o", "out.obj", "--beta", "0"}, "out.obj"),
              HasSubstr("tile 1002"));
  write_strip(folder);
  EXPECT_THAT(refusal(folder, {"filter", "strip.obj", "-o", "o.<UDIM>.png", "--beta", "0"}, "o.1001.png"),
              HasSubstr("a name for tiles"));
}

}  // namespace
}  // namespace mq::test
