// seams, fill and mask.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/models.h"

namespace mq::test {
namespace {

using testing::HasSubstr;
using Json = nlohmann::json;
using Words = std::vector<std::string>;

Result run_seams(const Folder& folder, const std::string& verb, const std::string& output,
           const Words& more = {}) {
  Words words = {verb, "strip.obj", "-o", output, "--json"};
  words.insert(words.end(), more.begin(), more.end());
  return marquetry(folder, words);
}

/// Whether a texel's centre lies in a chart of the strip (64 × 48).
bool inside(int x, int y) {
  const double u = (x + 0.5) / 64, v = 1 - (y + 0.5) / 48;
  return v > 0.1 && v < 0.9 && ((u > 0.05 && u < 0.45) || (u > 0.55 && u < 0.95));
}

TEST(Seams, AreClosedByTexelsNextToThem) {
  const Folder folder;
  write_strip(folder, 64, 48, Depth::u16);
  const Result result = run_seams(folder, "seams", "out.png");
  ASSERT_EQ(result.status, 0) << result.error;
  const Json seams = result.json()["result"]["seams"];
  EXPECT_GT(seams["before"]["rms"].get<double>(), 0.1);
  EXPECT_LT(seams["after"]["rms"].get<double>(), 0.01);
  const Image<float> before = read_texture(folder / "strip.png").pixels;
  const Image<float> after = read_texture(folder / "out.png").pixels;
  // The seam is at u = 0.45 and 0.55: columns 28 to 29 and 34 to 35.
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x)
      if (x < 28 || x > 35) {
        EXPECT_TRUE(std::ranges::equal(before.pixel(x, y), after.pixel(x, y))) << x << ", " << y;
      }
  EXPECT_NE(before(28, 20), after(28, 20));
}

TEST(Fill, KeepsChartsAndFillsAllElse) {
  const Folder folder;
  write_strip(folder, 64, 48, Depth::u16);
  Image<float> picture = busy_picture(64, 48);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x)
      for (int c = 0; c < 3; ++c)
        picture(x, y, c) = inside(x, y) ? 0.5F + 0.5F * picture(x, y, c) : 0;
  write_image(folder / "strip.png", picture, Depth::u16);
  const Result result = run_seams(folder, "fill", "out.png");
  ASSERT_EQ(result.status, 0) << result.error;
  const Image<float> before = read_texture(folder / "strip.png").pixels;
  const Image<float> after = read_texture(folder / "out.png").pixels;
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x)
      for (int c = 0; c < 3; ++c) {
        if (inside(x, y))
          EXPECT_EQ(before(x, y, c), after(x, y, c)) << x << ", " << y;
        else
          EXPECT_GT(after(x, y, c), 0.3) << x << ", " << y;
      }
  const Json seams = result.json()["result"]["seams"];
  EXPECT_LT(seams["after"]["rms"].get<double>(), 0.35 * seams["before"]["rms"].get<double>());

  ASSERT_EQ(run_seams(folder, "fill", "near.png", {"--distance", "2"}).status, 0);
  const Image<float> near = read_texture(folder / "near.png").pixels;
  EXPECT_EQ(near(0, 24), after(0, 24));
  EXPECT_EQ(near(20, 0), 0);
  EXPECT_GT(after(20, 0), 0.3);
}

/// A bake of 64 × 48 floats, 0.25 but for one that is no number: a TIFF by hand, as no writer here
/// makes one.
std::string bake_without_number(int column, int row) {
  const auto word = [](int v) { return std::string({char(v & 255), char(v >> 8)}); };
  const auto entry = [&](int tag, int type, int value) {
    return word(tag) + word(type) + word(1) + word(0) + word(value) + word(0);
  };
  std::string tiff = std::string("II*\0\x08\0\0\0", 8) + word(9) + entry(256, 3, 64) +
                     entry(257, 3, 48) + entry(258, 3, 32) + entry(259, 3, 1) + entry(262, 3, 1) +
                     entry(273, 4, 8 + 2 + 9 * 12 + 4) + entry(277, 3, 1) +
                     entry(279, 4, 4 * 64 * 48) + entry(339, 3, 3) + std::string(4, 0);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x)
      tiff += x == column && y == row ? std::string({0, 0, char(0xc0), 0x7f})
                                      : std::string({0, 0, char(0x80), 0x3e});
  return tiff;
}

TEST(Fill, ReplacesWhatIsNoNumberOutsideChartsAndRefusesItInside) {
  const Folder folder;
  write_strip(folder);
  for (const char* verb : {"fill", "denoise"}) {
    write_bytes(folder / "bake.tif", bake_without_number(1, 20));
    const Result result = marquetry(folder, {verb, "strip.obj", "bake.tif", "-o", "out.tif"});
    ASSERT_EQ(result.status, 0) << result.error;
    EXPECT_THAT(result.error, HasSubstr("1 values outside all charts"));
    const Image<float> after = read_texture(folder / "out.tif").pixels;
    EXPECT_NEAR(after(1, 20), 0.25, 1e-6);
    // A texel next to a chart takes part in what the chart shows.
    for (const int column : {2, 10}) {
      write_bytes(folder / "bake.tif", bake_without_number(column, 20));
      const Result refused = marquetry(folder, {verb, "strip.obj", "bake.tif", "-o", "no.tif"});
      EXPECT_NE(refused.status, 0);
      EXPECT_THAT(refused.error, HasSubstr(std::to_string(column) + ", row 20) holds nan"));
      EXPECT_FALSE(std::filesystem::exists(folder / "no.tif"));
    }
  }
}

TEST(Mask, MarksWhatTheChartsUse) {
  const Folder folder;
  write_strip(folder);
  const auto picture = [&](const std::string& what) {
    const Result result = run_seams(folder, "mask", what + ".png", {"--what", what});
    EXPECT_EQ(result.status, 0) << result.error;
    return read_texture(folder / (what + ".png")).pixels;
  };
  const Image<float> active = picture("active"), boundary = picture("boundary"),
                     overlap = picture("depth"), chart = picture("chart"),
                     triangle = picture("triangle");
  int triangles[2][2] = {};
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) {
      EXPECT_EQ(overlap(x, y), inside(x, y) ? 1 / 255.0F : 0) << x << ", " << y;
      if (inside(x, y)) {
        EXPECT_EQ(active(x, y), 1);
      }
      EXPECT_LE(boundary(x, y), active(x, y));
      const bool black = chart(x, y, 0) + chart(x, y, 1) + chart(x, y, 2) == 0;
      EXPECT_EQ(black, active(x, y) == 0);
      triangles[0][0] += triangle(x, y, 0) > 0 && x < 32;
    }
  EXPECT_GT(triangles[0][0], 800);
  EXPECT_EQ(boundary(15, 24), 0);
  EXPECT_EQ(boundary(28, 24), 1);
  EXPECT_FALSE(std::ranges::equal(chart.pixel(15, 24), chart.pixel(50, 24)));
  // Of no use otherwise: as labels it is what stitch does without any.
  ASSERT_EQ(run_seams(folder, "stitch", "a.png").status, 0);
  ASSERT_EQ(run_seams(folder, "stitch", "b.png", {"--labels", "chart.png"}).status, 0);
  EXPECT_TRUE(file_bytes(folder / "a.png") == file_bytes(folder / "b.png"));

  EXPECT_THAT(run_seams(folder, "mask", "m.jpg").error, HasSubstr("choose .png"));
  EXPECT_THAT(run_seams(folder, "mask", "m.obj").error, HasSubstr("wanted a picture or a folder"));
  // Without a picture texels are counted as if it had 2048 × 2048.
  write_bytes(folder / "strip.mtl", "newmtl strip\n");
  ASSERT_EQ(run_seams(folder, "mask", "none.png").status, 0);
  EXPECT_EQ(read_texture(folder / "none.png").pixels.width(), 2048);
}

TEST(Seams, FillAndMaskNeedTextureCoordinates) {
  const Folder folder;
  write_bytes(folder / "fan.ply", coloured_ply);
  for (const char* verb : {"seams", "fill", "mask"}) {
    const Result result = marquetry(folder, {verb, "fan.ply", "-o", "out.png"});
    EXPECT_EQ(result.status, 2);
    EXPECT_THAT(result.error, HasSubstr("fan.ply: has no texture coordinates")) << verb;
  }
}

}  // namespace
}  // namespace mq::test
