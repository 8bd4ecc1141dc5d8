// What the program makes of files that options name, before it works and in dry runs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/models.h"
#include "cli/refusal.h"

namespace mq::test {
namespace {

using ::testing::HasSubstr;
using Words = std::vector<std::string>;

/// Verbs with an option for files each, of the strip.
const Words with_files[] = {
    {"filter", "strip.obj", "--beta", "2", "--mask", "missing.png"},
    {"filter", "strip.obj", "--beta", "2", "--mask", "missing.ply"},
    {"denoise", "strip.obj", "--guide", "missing.png"},
    {"stitch", "strip.obj", "--labels", "missing.png"},
    {"stitch", "strip.obj", "--partial", "missing.png"},
    {"stitch", "strip.obj", "--partial", "strip.png", "--confidence", "missing.png"},
    {"texture", "strip.obj", "--cameras", "missing.json"},
    {"geodesic", "strip.obj", "--from-mask", "missing.png"},
    {"lic", "strip.obj", "--field", "missing.vf"},
    {"render", "strip.obj", "--compare", "missing.png"}};

TEST(Inputs, ThatAreMissingAreMissedInDryRunsToo) {
  const Folder folder;
  write_strip(folder);
  for (Words words : with_files) {
    words.insert(words.end(), {"-o", "out.png", "--dry-run"});
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 2) << words[0];
    EXPECT_THAT(result.error, HasSubstr("missing.")) << words[0];
  }
}

TEST(Inputs, OfAnotherSizeOrNumberAreRefusedInDryRunsToo) {
  const Folder folder;
  write_strip(folder);
  write_image(folder / "small.png", Image<float>(8, 8, 4));
  const auto error = [&](Words words) {
    words.insert(words.end(), {"-o", "out.png", "--dry-run"});
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 2);
    return result.error;
  };
  for (const Words& words : {Words{"denoise", "strip.obj", "--guide", "small.png"},
                             Words{"geodesic", "strip.obj", "--from-mask", "small.png"},
                             Words{"stitch", "strip.obj", "--partial", "small.png"}})
    EXPECT_THAT(error(words), HasSubstr("small.png: is 8 x 8, and the texture 64 x 48"));
  EXPECT_THAT(error({"stitch", "strip.obj", "--labels", "small.png", "--labels", "small.png"}),
              HasSubstr("strip.obj has 1 texture, and 2 are given"));
}

TEST(Inputs, AreFoundUnderNamesInOtherCapitals) {
  const Folder folder;
  write_strip(folder);
  std::filesystem::rename(folder / "strip.png", folder / "Strip.PNG");
  const Result found = marquetry(folder, {"inspect", "strip.obj"});
  EXPECT_EQ(found.status, 0) << found.error;
  EXPECT_THAT(found.error, HasSubstr("the picture \"strip.png\" was found as \"Strip.PNG\""));
  std::filesystem::copy(folder / "Strip.PNG", folder / "STRIP.png");  // which of them is meant?
  EXPECT_EQ(marquetry(folder, {"fill", "strip.obj", "-o", "o.png"}).status, 2);
  const Result looked = marquetry(folder, {"inspect", "strip.obj"});
  EXPECT_EQ(looked.status, 0) << looked.error;
  EXPECT_THAT(looked.error, HasSubstr("names the picture \"strip.png\", which is not in"));
}

TEST(Report, IsRefusedBeforeAnyWorkWhereItCannotBeWritten) {
  const Folder folder;
  write_strip(folder);
  for (const std::string report : {"no/where/r.json", "."}) {
    const Result result = marquetry(
        folder, {"filter", "strip.obj", "--beta", "2", "-o", "out.png", "--report", report});
    EXPECT_EQ(result.status, 2);
    EXPECT_THAT(result.error, HasSubstr(report));
    EXPECT_FALSE(std::filesystem::exists(folder / "out.png"));
  }
}

/// Light goes into a PNG that says so, and is read as light again.
TEST(Light, SurvivesAWayThroughPng) {
  const Folder folder;
  write_strip(folder);
  Image<float> light = busy_picture(64, 48);
  for (float& value : light.values()) value *= value;
  write_image(folder / "light.exr", light, Depth::f32);
  const auto filtered = [&](const std::string& from, const std::string& to) {
    const Result result = marquetry(folder, {"filter", "strip.obj", from, "--beta", "0", "--length",
                                             "2tx", "--space", "log", "-o", to});
    EXPECT_EQ(result.status, 0) << result.error;
    return result.error;
  };
  EXPECT_THAT(filtered("light.exr", "once.png"), HasSubstr("once.png: holds light"));
  filtered("light.exr", "once.exr");
  const Texture once = read_texture(folder / "once.png");
  EXPECT_EQ(once.format.depth, Depth::u16);
  EXPECT_TRUE(holds_light(once.format));
  EXPECT_FALSE(holds_light(read_texture(folder / "strip.png").format));
  filtered("once.png", "twice.png");
  filtered("once.exr", "twice.exr");
  const Image<float> a = read_texture(folder / "twice.png").pixels,
                     b = read_texture(folder / "twice.exr").pixels;
  for (int y = 10; y < 38; ++y)
    for (int x = 6; x < 26; ++x) EXPECT_NEAR(a(x, y), b(x, y), 3.0 / 65535);
  EXPECT_THAT(filtered("light.exr", "dark.jpg"), HasSubstr("which its format cannot say"));
}

/// Who needs the shape alone says what is missing, and goes on.
TEST(Inputs, MissingLibrariesAndPicturesStopOnlyWhoNeedsThem) {
  const Folder folder;
  write_strip(folder);
  std::filesystem::remove(folder / "strip.png");
  const Result without_picture = marquetry(folder, {"unwrap", "strip.obj", "-o", "new.obj", "--size", "64"});
  EXPECT_EQ(without_picture.status, 0) << without_picture.error;
  EXPECT_THAT(without_picture.error, HasSubstr("strip.png"));
  EXPECT_THAT(refusal(folder, {"filter", "strip.obj", "--beta", "2", "-o", "out.png"}, "out.png"),
              HasSubstr("strip.png"));

  std::filesystem::remove(folder / "strip.mtl");
  const Result without_library = marquetry(folder, {"unwrap", "strip.obj", "-o", "newer.obj", "--size", "64"});
  EXPECT_EQ(without_library.status, 0) << without_library.error;
  EXPECT_THAT(without_library.error, HasSubstr("strip.mtl"));
  EXPECT_THAT(refusal(folder, {"filter", "strip.obj", "--beta", "2", "-o", "out.png"}, "out.png"),
              HasSubstr("strip.mtl"));
}

}  // namespace
}  // namespace mq::test
