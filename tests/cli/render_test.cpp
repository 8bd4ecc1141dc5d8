#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/models.h"
#include "mq/io/image_file.h"

namespace mq::test {
namespace {

using testing::HasSubstr;

/// marquetry render strip.obj -o out.png WORDS...; the picture, which must be there.
Image<float> rendered(const Folder& folder, std::vector<std::string> words) {
  words.insert(words.begin(), {"render", "strip.obj", "-o", "out.png"});
  const Result result = marquetry(folder, words);
  EXPECT_EQ(result.status, 0) << result.error;
  return read_texture(folder / "out.png").pixels;
}

TEST(Render, DrawsAModelInTheSizeAskedFor) {
  const Folder folder;
  write_strip(folder);
  const Image<float> picture = rendered(folder, {"--size", "80x60"});
  EXPECT_EQ(picture.width(), 80);
  EXPECT_EQ(picture.height(), 60);
  EXPECT_EQ(picture.channels(), 3);
}

TEST(Render, LeavesTheBackgroundOutWhenAsked) {
  const Folder folder;
  write_strip(folder);
  const Image<float> picture =
      rendered(folder, {"--size", "64", "--background", "transparent", "--view", "front"});
  ASSERT_EQ(picture.channels(), 4);
  EXPECT_EQ(picture(0, 0, 3), 0);
  EXPECT_EQ(picture(32, 32, 3), 1);
}

TEST(Render, GivesEqualBytesForAnyNumberOfThreads) {
  const Folder folder;
  write_strip(folder);
  rendered(folder, {"--size", "100", "--seams", "--wires", "--threads", "1"});
  const std::string first = file_bytes(folder / "out.png");
  rendered(folder, {"--size", "100", "--seams", "--wires", "--threads", "3"});
  EXPECT_EQ(file_bytes(folder / "out.png"), first);
}

TEST(Render, PutsViewsComparisonsAndOverviewsOnAPage) {
  const Folder folder;
  write_strip(folder);
  write_image(folder / "other.png", Image<float>(64, 48, 3, 0.5F));
  EXPECT_GT(rendered(folder, {"-s", "50", "-v", "front", "-v", "10,-20"}).width(), 100);
  const Image<float> pair = rendered(folder, {"-s", "50", "--compare", "other.png"});
  EXPECT_GT(pair.width(), 100);
  EXPECT_LT(pair.height(), 110);
  const Image<float> three = rendered(folder, {"-s", "50", "--compare", "other.png", "--compare", "strip.png"});
  EXPECT_GT(three.width(), 150);
  EXPECT_EQ(three.height(), pair.height());
  EXPECT_GT(rendered(folder, {"-s", "50", "--overview"}).width(), 150);
}

TEST(Render, LooksThroughTheCameraThatItWrote) {
  const Folder folder;
  write_strip(folder);
  const Image<float> picture = rendered(folder, {"-s", "90x60", "-v", "20,35", "--seams", "--cameras", "seen.json"});
  EXPECT_TRUE(rendered(folder, {"-s", "90", "--seams", "--through", "seen.json"}) == picture);
  EXPECT_TRUE(rendered(folder, {"-s", "90", "--seams", "--through", "seen.json", "--photograph", "out.png"}) == picture);
  // A wider picture shows more to both sides.
  const Image<float> wide = rendered(folder, {"-s", "120x60", "--seams", "--through", "seen.json", "--background", "black"});
  EXPECT_EQ(wide.width(), 120);
  EXPECT_EQ(rendered(folder, {"-s", "45", "--through", "seen.json"}).height(), 30);
  EXPECT_THAT(marquetry(folder, {"render", "strip.obj", "-o", "x.png", "--through", "seen.json", "--photograph", "b"}).error,
              HasSubstr("no camera of b"));
  EXPECT_THAT(marquetry(folder, {"render", "strip.obj", "-o", "x.png", "--through", "seen.json", "--at", "seam"}).error,
              HasSubstr("--at: --through says from where"));
  EXPECT_THAT(marquetry(folder, {"render", "strip.obj", "-o", "x.png", "--photograph", "b"}).error,
              HasSubstr("give it too"));
}

TEST(Render, SaysWhereItLooksAtASeam) {
  const Folder folder;
  write_strip(folder);
  const Result result = marquetry(
      folder, {"render", "strip.obj", "-o", "out.png", "--at", "seam", "-s", "50", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto seam = result.json()["result"]["seam"];
  EXPECT_GT(seam["rms"].get<double>(), 0);
  EXPECT_NEAR(seam["at"][0].get<double>(), 1, 1e-9);  // the border between the two squares
}

TEST(Render, LooksWhereTwoTexturesDifferMost) {
  const Folder folder;
  write_strip(folder);
  Image<float> other = read_texture(folder / "strip.png").pixels;
  for (int y = 20; y < 26; ++y)
    for (int x = 44; x < 50; ++x) other(x, y, 1) = other(x, y, 1) > 0.5F ? 0.F : 1.F;
  write_image(folder / "other.png", other);
  const Result result = marquetry(folder, {"render", "strip.obj", "-o", "out.png", "--compare", "other.png", "--at",
                                           "difference", "--extent", "12tx", "-s", "50", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto found = result.json()["result"]["difference"];
  EXPECT_GT(found["largest"].get<double>(), 2 * found["rms"].get<double>());
  EXPECT_NEAR(found["at"][0].get<double>(), 1.46, 0.15);
  EXPECT_NEAR(found["at"][1].get<double>(), 0.53, 0.15);
  const auto error = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"render", "strip.obj", "-o", "x.png", "--at", "difference"});
    const Result refused = marquetry(folder, words);
    EXPECT_EQ(refused.status, 2);
    return refused.error;
  };
  EXPECT_THAT(error({}), HasSubstr("name other textures with --compare"));
  EXPECT_THAT(error({"--compare", "strip.png"}), HasSubstr("do not differ anywhere"));
}

TEST(Render, MeasuresTheSeamsOfWhatItCompares) {
  const Folder folder;
  write_strip(folder);
  write_image(folder / "flat.png", Image<float>(64, 48, 3, 0.5F));
  const Result result = marquetry(
      folder, {"render", "strip.obj", "-o", "out.png", "-c", "flat.png", "-s", "50", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto seams = result.json()["result"]["seams"];
  EXPECT_GT(seams["before"]["rms"].get<double>(), 0);
  EXPECT_EQ(seams["after"]["rms"].get<double>(), 0);
}

TEST(Render, DrawsTheLayoutOfATexture) {
  const Folder folder;
  write_strip(folder);
  const Image<float> layout = rendered(folder, {"--layout", "--size", "128"});
  EXPECT_EQ(layout.width(), 128);
  EXPECT_EQ(layout.height(), 96);
  EXPECT_EQ(rendered(folder,
                     {"--layout", "--size", "128", "--zoom", "4", "--center", "0.2,0.3", "--wires"})
                .width(),
            128);
}

TEST(Render, DrawsWhatThereIs) {
  const Folder folder;
  write_bytes(folder / "bare.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  write_bytes(folder / "folded.obj", folded_obj);
  write_bytes(folder / "fan.ply", coloured_ply);
  for (const char* model : {"bare.obj", "folded.obj", "fan.ply"})
    EXPECT_EQ(marquetry(folder, {"render", model, "-o", "out.png", "-s", "40"}).status, 0) << model;
  const Result result = marquetry(
      folder, {"render", "fan.ply", "-o", "out.png", "-s", "41", "-v", "front", "--unlit"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_NEAR(read_texture(folder / "out.png").pixels(20, 20, 0), 200 / 255.0, 0.1);
}

TEST(Render, RefusesWhatItCannotDraw) {
  const Folder folder;
  write_strip(folder);
  write_bytes(folder / "bare.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  write_image(folder / "small.png", Image<float>(8, 8, 3, 0.5F));
  const auto error = [&](const std::string& model, std::vector<std::string> words) {
    words.insert(words.begin(), {"render", model, "-o", "out.png", "-s", "40"});
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 2);
    EXPECT_FALSE(std::filesystem::exists(folder / "out.png"));
    return result.error;
  };
  EXPECT_THAT(error("bare.obj", {"--paint", "charts"}), HasSubstr("no texture coordinates"));
  EXPECT_THAT(error("bare.obj", {"--layout"}), HasSubstr("no texture coordinates"));
  EXPECT_THAT(error("bare.obj", {"--at", "seam"}), HasSubstr("no textures"));
  EXPECT_THAT(error("strip.obj", {"--paint", "vertices"}), HasSubstr("no colours at its vertices"));
  EXPECT_THAT(error("strip.obj", {"--compare", "small.png"}), HasSubstr("is 8 x 8, and the texture"));
  EXPECT_THAT(error("strip.obj", {"--paint", "numbers", "--channel", "5"}), HasSubstr("channel 5"));
  EXPECT_THAT(error("strip.obj", {"--view", "side"}), HasSubstr("AZIMUTH"));
  EXPECT_THAT(error("strip.obj", {"--size", "0"}), HasSubstr("1920x1080"));
  EXPECT_THAT(error("strip.obj", {"--background", "#12345"}), HasSubstr("#rrggbb"));
  EXPECT_THAT(error("strip.obj", {"--layout", "--layout-texture", "2"}), HasSubstr("no texture 2"));
}

}  // namespace
}  // namespace mq::test
