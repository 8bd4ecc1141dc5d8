// Filters that work here and not there.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/models.h"

namespace mq::test {
namespace {

using testing::HasSubstr;
using Words = std::vector<std::string>;

/// The equation is linear in β − 1: a mask that sharpens here and smooths there is both together.
TEST(Filter, SmoothsWhereTheMaskIsBelowZero) {
  const Folder folder;
  write_strip(folder);
  Image<float> both(64, 48, 1), sharpens(64, 48, 1), smooths(64, 48, 1);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) {
      both(x, y) = std::sin(0.2F * float(x) + 0.1F * float(y));
      sharpens(x, y) = std::max(0.0F, both(x, y));
      smooths(x, y) = std::max(0.0F, -both(x, y));
    }
  write_image(folder / "both.exr", both, Depth::f32);
  write_image(folder / "sharpens.tif", sharpens, Depth::f32);
  write_image(folder / "smooths.exr", smooths, Depth::f32);
  const auto filtered = [&](const std::string& mask, const std::string& beta) {
    const Result result =
        marquetry(folder, {"filter", "strip.obj", "-o", "out.exr", "--depth", "float", "--beta", beta,
                           "--mask", mask, "--solver", "direct", "--json"});
    EXPECT_EQ(result.status, 0) << result.error;
    EXPECT_EQ(result.json()["result"]["mask"]["below_0"].get<double>() > 0, mask == "both.exr");
    return read_texture(folder / "out.exr").pixels;
  };
  const Image<float> before = read_texture(folder / "strip.png").pixels,
                     a = filtered("sharpens.tif", "3"), b = filtered("smooths.exr", "0"),
                     c = filtered("both.exr", "3");
  for (std::size_t k = 0; k < before.values().size(); ++k)
    EXPECT_NEAR(c.values()[k] - before.values()[k],
                a.values()[k] + b.values()[k] - 2 * before.values()[k], 2e-6);

  Image<float> far(64, 48, 1, 0.5F);
  far(3, 4) = -1.5F, far(5, 6) = 2;
  write_image(folder / "far.exr", far, Depth::f32);
  const Result result =
      marquetry(folder, {"filter", "strip.obj", "-o", "out.png", "--beta", "3", "--mask", "far.exr"});
  EXPECT_EQ(result.status, 0);
  EXPECT_THAT(result.error, HasSubstr("far.exr: 2 of its 3072 pixels have values beyond -1 to 1"));
}

/// Half grey on the left, white on the right.
Image<float> half_mask(int width, int height) {
  Image<float> mask(width, height, 1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) mask(x, y) = x < width / 2 ? 0.0F : 1.0F;
  return mask;
}

TEST(Filter, WorksWhereTheMaskIsWhite) {
  const Folder folder;
  write_strip(folder);
  write_image(folder / "mask.png", half_mask(64, 48));
  write_image(folder / "white.png", Image<float>(5, 7, 3, 1.0F));
  write_image(folder / "black.png", Image<float>(64, 48, 1, 0.0F));
  const auto filter = [&](const std::string& output, const Words& more) {
    Words words = {"filter", "strip.obj", "-o", output, "--beta", "0", "--length", "1tx", "--json"};
    words.insert(words.end(), more.begin(), more.end());
    return marquetry(folder, words);
  };
  ASSERT_EQ(filter("plain.png", {}).status, 0);
  EXPECT_THAT(filter("white_out.png", {"--mask", "white.png"}).error, HasSubstr("5 × 7"));
  EXPECT_TRUE(file_bytes(folder / "plain.png") == file_bytes(folder / "white_out.png"));
  ASSERT_EQ(filter("black_out.png", {"--mask", "black.png"}).status, 0);
  EXPECT_TRUE(file_bytes(folder / "strip.png") == file_bytes(folder / "black_out.png"));

  const Result half = filter("half.png", {"--mask", "mask.png"});
  ASSERT_EQ(half.status, 0) << half.error;
  EXPECT_NEAR(half.json()["result"]["mask"]["share"].get<double>(), 0.5, 0.1);
  const Image<float> before = read_texture(folder / "strip.png").pixels;
  const Image<float> after = read_texture(folder / "half.png").pixels;
  const Image<float> plain = read_texture(folder / "plain.png").pixels;
  for (int y = 10; y < 40; ++y) {
    EXPECT_EQ(before(8, y), after(8, y));
    EXPECT_EQ(plain(55, y), after(55, y));
  }
  EXPECT_NE(before(55, 20), after(55, 20));
}

TEST(Filter, WorksInSpots) {
  const Folder folder;
  write_strip(folder);
  const auto filter = [&](const std::string& output, const Words& more) {
    Words words = {"filter", "strip.obj", "-o", output, "--beta", "3", "--length", "1tx", "--json"};
    words.insert(words.end(), more.begin(), more.end());
    return marquetry(folder, words);
  };
  // Texel (15, 23) is the middle of the first square, u = 0.242.
  ASSERT_EQ(filter("a.png", {"--spot", "0.4804688,0.5130208,0,0.2"}).status, 0);
  ASSERT_EQ(filter("b.png", {"--spot", "texel,15,23,0.2"}).status, 0);
  EXPECT_TRUE(file_bytes(folder / "a.png") == file_bytes(folder / "b.png"));
  const Image<float> before = read_texture(folder / "strip.png").pixels;
  const Image<float> after = read_texture(folder / "a.png").pixels;
  EXPECT_NE(before(15, 23), after(15, 23));
  EXPECT_EQ(before(40, 23), after(40, 23));
  EXPECT_EQ(before(4, 8), after(4, 8));
  ASSERT_EQ(filter("c.png", {"--spot", "texel,15,23,0.2", "--spot", "texel,15,23,0.2,-1"}).status,
            0);
  EXPECT_TRUE(file_bytes(folder / "c.png") == file_bytes(folder / "strip.png"));

  EXPECT_THAT(filter("d.png", {"--spot", "texel,32,23,0.2"}).error,
              HasSubstr("texel0,32,23: no chart of strip.obj uses such a texel"));
  for (const char* spot :
       {"1,2,3", "1,2,3,0", "1,2,3,x", "texel,1,2,3tx,2", "a,b,c,d", "texels,1,2,3"})
    EXPECT_THAT(filter("d.png", {"--spot", spot}).error, HasSubstr("--spot: found '")) << spot;
}

TEST(Filter, TakesAMaskFromColoursAtVertices) {
  const Folder folder;
  write_bytes(folder / "fan.ply", coloured_ply);
  std::string mask = coloured_ply;
  for (std::size_t at; (at = mask.find(" 100 100 100")) != std::string::npos;)
    mask.replace(at, 12, " 0 0 0");
  for (std::size_t at; (at = mask.find(" 200 200 200")) != std::string::npos;)
    mask.replace(at, 12, " 255 255 255");
  write_bytes(folder / "mask.ply", mask);
  const auto filter = [&](const Words& more) {
    Words words = {"filter", "fan.ply", "-o", "out.ply", "--beta", "0", "--alpha", "1", "--json"};
    words.insert(words.end(), more.begin(), more.end());
    return marquetry(folder, words);
  };
  const Result result = filter({"--mask", "mask.ply"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_NEAR(result.json()["result"]["mask"]["mean"].get<double>(), 0.2, 1e-12);
  EXPECT_LT(read_model(folder / "out.ply").colors.values[0], 180 / 255.0F);

  write_strip(folder);
  EXPECT_THAT(filter({"--mask", "strip.png"}).error, HasSubstr("have no texels; give a model"));
  EXPECT_THAT(filter({"--mask", "strip.obj"}).error, HasSubstr("no colours at its vertices"));
  EXPECT_THAT(filter({"--spot", "texel,1,1,0.2"}).error, HasSubstr("give a place in space"));
}

TEST(Filter, RefusesMasksThatDoNotFit) {
  const Folder folder;
  write_strip(folder);
  const auto error = [&](const Words& more) {
    Words words = {"filter", "strip.obj", "-o", "out.png", "--beta", "0"};
    words.insert(words.end(), more.begin(), more.end());
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 2);
    return result.error;
  };
  EXPECT_THAT(error({"--mask", "gone.png"}), HasSubstr("gone.png"));
  EXPECT_THAT(error({"--mask", "strip.png", "--mask", "strip.png"}),
              HasSubstr("has 1 texture, and 2 are given"));
  write_image(folder / "m.png", Image<float>(64, 48, 1, 1.0F));
  EXPECT_THAT(
      marquetry(folder, {"filter", "strip.obj", "-o", "m.png", "--beta", "0", "--mask", "m.png"})
          .error,
      HasSubstr("m.png"));
}

}  // namespace
}  // namespace mq::test
