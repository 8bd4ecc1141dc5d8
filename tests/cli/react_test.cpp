// marquetry react, run as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "cli/models.h"

namespace mq::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(React, GrowsAPatternThatTheSeedDecides) {
  const Folder folder;
  write_strip(folder);
  const auto grow = [&](const std::string& seed, const std::string& out) {
    const Result result = marquetry(folder, {"react", "strip.obj", "--scale", "8tx", "--time",
                                             "400", "--seed", seed, "-o", out, "--json"});
    EXPECT_EQ(result.status, 0) << result.error;
    EXPECT_GT(result.json()["result"]["stages"].back()["steps"], 100);
    return read_texture(folder / out).pixels;
  };
  const Image<float> first = grow("1", "a.exr"), again = grow("1", "b.exr"),
                     other = grow("2", "c.exr");
  EXPECT_EQ(first.channels(), 1);
  EXPECT_TRUE(first == again);
  EXPECT_FALSE(first == other);
  EXPECT_GT(*std::ranges::max_element(first.values()), 0.1F);
}

TEST(React, PaintsInTheColoursAskedFor) {
  const Folder folder;
  write_strip(folder);
  const Result result =
      marquetry(folder, {"react", "strip.obj", "--scale", "8tx", "--time", "200", "--ground",
                         "#000000", "--ink", "#ff0000", "-o", "p.png"});
  ASSERT_EQ(result.status, 0) << result.error;
  const Image<float> picture = read_texture(folder / "p.png").pixels;
  float red = 0, green = 0;
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) {
      red = std::max(red, picture(x, y, 0));
      green = std::max(green, picture(x, y, 1));
    }
  EXPECT_EQ(red, 1);
  EXPECT_EQ(green, 0);
}

/// Two sheets, one on the other and cut another way, with the same texels: these show the pattern of one sheet, unbroken.
TEST(React, ShowsOneOfThePlacesThatATexelStandsFor) {
  const Folder folder;
  write_texture(folder / "sheets.png", Texture{.pixels = Image<float>(128, 128, 3)});
  write_bytes(folder / "sheets.mtl", "newmtl sheets\nmap_Kd sheets.png\n");
  const std::string head = "mtllib sheets.mtl\nusemtl sheets\nv 0 0 0\nv .81 .37 .29\nv .4 1.14 .42\nv -.41 .77 .13\n"
                           "v 0 0 0\nv .81 .37 .29\nv .4 1.14 .42\nv -.41 .77 .13\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n";
  write_bytes(folder / "sheets.obj", head + "f 5/1 6/2 8/4\nf 6/2 7/3 8/4\n");
  const Result result =
      marquetry(folder, {"react", "sheets.obj", "--weld", "none", "--scale", "24tx", "--time", "400", "-o", "p.exr", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_LT(result.json()["result"]["stages"][0]["unknowns"], 10000);  // of sheets; texels are 16,384
  const Image<float> picture = read_texture(folder / "p.exr").pixels;
  float most = 0, least = 1, step = 0;
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 1; x < picture.width(); ++x) {
      most = std::max(most, picture(x, y));
      least = std::min(least, picture(x, y));
      step = std::max(step, std::abs(picture(x, y) - picture(x - 1, y)));
    }
  EXPECT_GT(most - least, 0.1F);
  EXPECT_LT(step, 0.35F * (most - least));
}

/// Nobody asked for waves that the mesh cannot show; one who does is told what can.
TEST(React, TakesWavesThatVerticesShowWhereNobodyAskedForOthers) {
  const Folder folder;
  ASSERT_EQ(marquetry(folder, {"sample", "torus", "--triangles", "3000", "-o", "torus.obj"}).status, 0);
  const Result usual = marquetry(folder, {"react", "torus.obj", "--vertices", "-t", "100", "-o", "u.ply", "--json"});
  ASSERT_EQ(usual.status, 0) << usual.error;
  EXPECT_THAT(usual.error, HasSubstr("vertices long, so --scale "));
  const Result asked =
      marquetry(folder, {"react", "torus.obj", "--vertices", "-t", "100", "--scale", "2%", "-o", "a.ply", "--json"});
  ASSERT_EQ(asked.status, 0) << asked.error;
  EXPECT_THAT(asked.error, HasSubstr("vertices long; below 6 the mesh shows in the pattern"));
  EXPECT_GT(double(usual.json()["result"]["wave_length"]), 3 * double(asked.json()["result"]["wave_length"]));
}

/// Two squares of the same size, one of which has an eighth of the texels in one direction.
TEST(React, SaysWhereTexelsAreTooCoarse) {
  const Folder folder;
  write_bytes(folder / "two.obj",
              "mtllib two.mtl\nusemtl two\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 1 -1\nv 1 1 -1\n"
              "vt .02 .02\nvt .48 .02\nvt .48 .48\nvt .02 .48\nvt .52 .52\nvt .98 .52\nvt .98 .58\nvt .52 .58\n"
              "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\nf 4/5 3/6 6/7\nf 4/5 6/7 5/8\n");
  write_bytes(folder / "two.mtl", "newmtl two\nmap_Kd two.png\n");
  write_image(folder / "two.png", busy_picture(256, 256), Depth::u8);
  const auto said = [&](const std::string& scale) {
    const Result result = marquetry(folder, {"react", "two.obj", "--scale", scale, "--time", "20", "-o", "o.png"});
    EXPECT_EQ(result.status, 0) << result.error;
    return result.error;
  };
  EXPECT_THAT(said("12tx"), HasSubstr("on 50 % of the surface texels are so long"));
  EXPECT_THAT(said("40tx"), Not(HasSubstr("so long")));
}

TEST(React, SaysWhyAPictureIsPlain) {
  const Folder folder;
  write_strip(folder);
  const auto errors = [&](std::vector<std::string> options) {
    options.insert(options.begin(), {"react", "strip.obj", "-o", "p.png"});
    const Result result = marquetry(folder, options);
    EXPECT_EQ(result.status, 0) << result.error;
    return result.error;
  };
  EXPECT_THAT(errors({"--scale", "8tx", "--time", "400"}), Not(HasSubstr("nothing")));
  EXPECT_THAT(errors({"--scale", "8tx", "--time", "200", "--feed", "0.01", "--kill", "0.2"}),
              HasSubstr("it died out"));
}

TEST(React, RefusesScalesAndColoursWithoutMeaning) {
  const Folder folder;
  write_strip(folder);
  EXPECT_EQ(marquetry(folder, {"react", "strip.obj", "--scale", "0", "-o", "p.png"}).status, 2);
  EXPECT_EQ(marquetry(folder, {"react", "strip.obj", "--ink", "leopard", "-o", "p.png"}).status, 2);
  // Both squares are shown by the same texels, on which all takes place then.
  write_bytes(folder / "twice.obj",
              "mtllib twice.mtl\nusemtl twice\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 3 0 0\nv 4 0 0\nv 4 1 0\nv 3 1 0\n"
              "vt .1 .1\nvt .9 .1\nvt .9 .9\nvt .1 .9\nf 1/1 2/2 3/3 4/4\nf 5/1 6/2 7/3 8/4\n");
  write_bytes(folder / "twice.mtl", "newmtl twice\nmap_Kd strip.png\n");
  const Result endless =
      marquetry(folder, {"react", "twice.obj", "--scale", "1e3", "--time", "1e7", "-o", "p.png"});
  EXPECT_EQ(endless.status, 2);
  EXPECT_THAT(endless.error, HasSubstr("wanted at most 1e+08 steps"));
  for (const std::string time : {"-1", "nan", "1e12", "inf"})
    EXPECT_EQ(marquetry(folder, {"react", "strip.obj", "--time", time, "-o", "p.png"}).status, 2);
  const Result coarse =
      marquetry(folder, {"react", "strip.obj", "--scale", "2tx", "--time", "5", "-o", "p.png"});
  EXPECT_EQ(coarse.status, 0);
  EXPECT_THAT(coarse.error, HasSubstr("the grid shows"));
}

}  // namespace
}  // namespace mq::test
