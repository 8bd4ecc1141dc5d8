// marquetry geodesic, run as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cli/models.h"
#include "cli/refusal.h"

namespace mq::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(Geodesic, WritesDistancesInModelUnits) {
  const Folder folder;
  write_strip(folder);
  const Result result =
      marquetry(folder, {"geodesic", "strip.obj", "--from", "0,0.5,0", "-o", "d.exr", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  // At a corner of the surface, though texels reach up to one beyond the edge, 0.04.
  EXPECT_NEAR(result.json()["result"]["max"], std::hypot(2, 0.5), 0.02);
  EXPECT_EQ(result.json()["result"]["unreached"], 0);
  const Texture d = read_texture(folder / "d.exr");
  ASSERT_EQ(d.pixels.channels(), 1);
  // The texel at the far end of the strip's middle, u = 0.95, v = 0.5.
  EXPECT_NEAR(d.pixels(60, 24), 2, 0.05);
}

TEST(Geodesic, TakesAVertexForItsPlace) {
  const Folder folder;
  write_strip(folder);
  for (const std::string from : {"vertex,4", "1,1,0"})  // on the seam
    ASSERT_EQ(marquetry(folder,
                        {"geodesic", "strip.obj", "--from", from, "-o", from.substr(0, 1) + ".exr"})
                  .status,
              0);
  EXPECT_EQ(read_texture(folder / "v.exr").pixels, read_texture(folder / "1.exr").pixels);
}

TEST(Geodesic, WritesColoursElsewhere) {
  const Folder folder;
  write_strip(folder);
  ASSERT_EQ(
      marquetry(folder, {"geodesic", "strip.obj", "--from", "texel,20,20", "-o", "d.png"}).status,
      0);
  const Texture colours = read_texture(folder / "d.png");
  EXPECT_EQ(colours.pixels.channels(), 3);
  EXPECT_EQ(colours.format.depth, Depth::u8);
}

TEST(Geodesic, SaysWhereItsCyclesEndTooEarly) {
  const Folder folder;
  write_strip(folder);
  std::vector<std::string> words = {"geodesic", "strip.obj", "--from",   "0,0.5,0",  "-o",       "d.exr",
                                    "--solver", "multigrid", "--cycles", "1",        "--tolerance", "1e-9",
                                    "--json",   "--overwrite"};
  const Result early = marquetry(folder, words);
  ASSERT_EQ(early.status, 0) << early.error;
  EXPECT_FALSE(early.json()["solve"]["converged"].get<bool>());
  EXPECT_THAT(early.error, HasSubstr("multigrid stopped after 1 cycle at a relative residual of"));
  EXPECT_THAT(early.error, HasSubstr("more --cycles come nearer"));
  words[9] = "30", words[11] = "1e-6";
  const Result enough = marquetry(folder, words);
  ASSERT_EQ(enough.status, 0) << enough.error;
  EXPECT_THAT(enough.error, Not(HasSubstr("more --cycles")));
}

TEST(Geodesic, TakesSourcesFromAPicture) {
  const Folder folder;
  write_strip(folder);
  Image<float> mask(64, 48, 1);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 6; ++x) mask(x, y) = 1;
  write_image(folder / "mask.png", mask);
  const Result result = marquetry(
      folder, {"geodesic", "strip.obj", "--from-mask", "mask.png", "-o", "d.exr", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_NEAR(result.json()["result"]["max"], 2 - 0.05, 0.07);
  const Result dark =
      marquetry(folder, {"geodesic", "strip.obj", "--from-mask", "strip.png", "-o", "d.exr"});
  EXPECT_EQ(dark.status, 0);
  write_image(folder / "black.png", Image<float>(64, 48, 1));
  const Result none =
      marquetry(folder, {"geodesic", "strip.obj", "--from-mask", "black.png", "-o", "e.exr"});
  EXPECT_EQ(none.status, 2);
  EXPECT_THAT(none.error, HasSubstr("no texel of a chart is brighter than half"));
}

/// A strip whose right half is half as wide in the texture: 25.6 and 12.8 by 38.4 texels, as much area as two squares. By these
/// it is √2 long.
TEST(Geodesic, MeasuresInTheTextureWhenAskedTo) {
  const Folder folder;
  write_strip(folder);
  std::string text = strip_obj;
  for (const char* corner : {"vt 0.95 0.1", "vt 0.95 0.9"}) text.replace(text.find(corner), 7, "vt 0.75");
  write_bytes(folder / "strip.obj", text);
  Image<float> mask(64, 48, 1);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 4; ++x) mask(x, y) = 1;
  write_image(folder / "mask.png", mask);
  const auto most = [&](const char* metric) {
    const Result result =
        marquetry(folder, {"geodesic", "strip.obj", "--from-mask", "mask.png", "-o", "d.exr", "--overwrite", "--json", "--metric", metric});
    EXPECT_EQ(result.status, 0) << result.error;
    return result.json()["result"]["max"].get<double>();
  };
  EXPECT_NEAR(most("texture"), std::sqrt(2), 0.05);
  EXPECT_NEAR(most("surface"), 2, 0.06);
  write_bytes(folder / "fan.ply", coloured_ply);
  const Result refused = marquetry(folder, {"geodesic", "fan.ply", "--from", "0,0,0", "-o", "d.ply", "--metric", "texture"});
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.error, HasSubstr("--metric texture is of texels"));
}

/// A strip of 2 × 1/4 whose halves lie half a texel apart in the texture, one above the other.
void write_halves(const Folder& folder) {
  write_bytes(folder / "halves.obj",
              "mtllib halves.mtl\nusemtl halves\n"
              "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 0.25 0\nv 1 0.25 0\nv 2 0.25 0\n"
              "vt 0.0734375 0.675\nvt 0.6984375 0.675\n"
              "vt 0.6984375 0.83125\nvt 0.0734375 0.83125\n"
              "vt 0.0734375 0.5109375\nvt 0.6984375 0.5109375\n"
              "vt 0.6984375 0.6671875\nvt 0.0734375 0.6671875\n"
              "f 1/1 2/2 5/3 4/4\nf 2/5 3/6 6/7 5/8\n");
  write_bytes(folder / "halves.mtl", "newmtl halves\nmap_Kd halves.png\n");
  write_image(folder / "halves.png", Image<float>(64, 64, 1));
}

TEST(Geodesic, IsNotFooledByTexelsThatChartsShare) {
  const Folder folder;
  write_halves(folder);
  const Result result =
      marquetry(folder, {"geodesic", "halves.obj", "--from", "0,0,0", "-o", "d.exr", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_NEAR(result.json()["result"]["max"], std::hypot(2, 0.25), 0.02);
  EXPECT_THAT(result.error, HasSubstr("texels that stand for several places"));
  // Rows 20 and 21 are read by both; their centres lie in the first half and in the second.
  const Texture d = read_texture(folder / "d.exr");
  EXPECT_NEAR(d.pixels(24, 20), 0.5, 0.03);
  EXPECT_NEAR(d.pixels(24, 21), 1.5, 0.03);
}

TEST(Geodesic, BeginsWhereTheCentresOfSharedTexelsLie) {
  const Folder folder;
  write_halves(folder);
  Image<float> mask(64, 64, 1);
  for (int x = 0; x < 64; ++x) mask(x, 20) = x < 20;
  write_image(folder / "mask.png", mask);
  for (const std::vector<std::string>& from :
       {std::vector<std::string>{"--from-mask", "mask.png"}, {"--from", "texel,19,20"}}) {
    std::vector<std::string> words = {"geodesic", "halves.obj", "-o", "d.exr", "--json"};
    words.insert(words.end(), from.begin(), from.end());
    const Result result = marquetry(folder, words);
    ASSERT_EQ(result.status, 0) << result.error;
    EXPECT_NEAR(result.json()["result"]["max"], 2 - (19 - 4.2) / 40, 0.04) << from[0];
  }
}

TEST(Geodesic, MeasuresAtVerticesWhereThereAreNoTextures) {
  const Folder folder;
  write_bytes(folder / "fan.ply", coloured_ply);
  const Result result = marquetry(folder, {"geodesic", "fan.ply", "--from", "vertex,0", "-o",
                                           "d.ply", "--show", "numbers", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  const Model model = read_model(folder / "d.ply");
  ASSERT_EQ(model.colors.channels, 3);
  EXPECT_EQ(model.colors.values[0], 0);
  for (int v = 1; v < 5; ++v) EXPECT_NEAR(model.colors.values[std::size_t(3 * v)], 1, 0.3);
}

TEST(Geodesic, RefusesSourcesThatAreNotThere) {
  const Folder folder;
  write_strip(folder);
  const auto refused = [&](const std::vector<std::string>& from) {
    std::vector<std::string> words = {"geodesic", "strip.obj", "-o", "d.png"};
    words.insert(words.end(), from.begin(), from.end());
    return refusal(folder, words, "d.png");
  };
  EXPECT_THAT(refused({}), HasSubstr("say where distances begin"));
  EXPECT_THAT(refused({"--from", "texel,0,0"}),
              HasSubstr("no chart of strip.obj uses such a texel"));
  EXPECT_THAT(refused({"--from", "vertex,6"}), HasSubstr("has the vertices 0, 1, ... 5"));
  EXPECT_THAT(refused({"--from", "1,2"}), HasSubstr("x,y,z or texel,column,row or vertex,number"));
  EXPECT_THAT(refused({"--from", "nan,0,0"}), HasSubstr("--from"));
  EXPECT_THAT(refused({"--vertices", "--from", "vertex,17"}), HasSubstr("output: found"));
}

TEST(Geodesic, ChecksSourcesBeforeAnyWork) {
  const Folder folder;
  write_strip(folder);
  const auto refused = [&](const std::string& from) {
    return marquetry(folder, {"geodesic", "strip.obj", "-o", "d.png", "--from", from, "--dry-run"})
        .error;
  };
  EXPECT_THAT(refused("vertex,6"), HasSubstr("has the vertices 0, 1, ... 5"));
  EXPECT_THAT(refused("texel,64,0"), HasSubstr("no chart of strip.obj uses such a texel"));
  EXPECT_THAT(refused("texel1,3,3"), HasSubstr("strip.obj has 1 texture, counted from 0"));
  EXPECT_THAT(refused("0,0.5,3"), HasSubstr("away from the surface"));
  const Result good = marquetry(
      folder, {"geodesic", "strip.obj", "-o", "d.png", "--from", "texel,20,20", "--dry-run"});
  EXPECT_EQ(good.status, 0) << good.error;
}

/// A model that names no pictures gets some, named after it.
TEST(Geodesic, WritesPicturesOfModelsThatHaveNone) {
  const Folder folder;
  write_bytes(folder / "bare.obj", bare_obj);
  for (const char* output : {"one.png", "%s_d.png", "folder/", "model.ply"}) {
    const Result result =
        marquetry(folder, {"geodesic", "bare.obj", "--from", "0,0,0", "-o", output, "--json"});
    ASSERT_EQ(result.status, 0) << output << result.error;
    const auto files = result.json()["result"]["outputs"];
    ASSERT_FALSE(files.empty()) << output;
    for (const auto& file : files)
      EXPECT_TRUE(std::filesystem::exists(folder / file.get<std::string>())) << file;
  }
  for (const char* file : {"bare_d.png", "folder/bare.png", "model_bare.png"})
    EXPECT_TRUE(file_bytes(folder / file) == file_bytes(folder / "one.png")) << file;
}

TEST(Geodesic, WarnsOfASourceFarFromTheSurface) {
  const Folder folder;
  write_strip(folder);
  const Result result =
      marquetry(folder, {"geodesic", "strip.obj", "--from", "0,0.5,3", "-o", "d.exr"});
  EXPECT_EQ(result.status, 0);
  EXPECT_THAT(result.error, HasSubstr("away from the surface"));
}

}  // namespace
}  // namespace mq::test
