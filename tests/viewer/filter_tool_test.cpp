// Painting with the filter: what is shown and saved is what the command line makes of the saved
// mask.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "viewer/sessions.h"

namespace mq::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// Values that are not the same, and the largest difference of any.
struct Difference {
  int values = 0;
  double largest = 0;
};

Difference difference(const Image<float>& a, const Image<float>& b) {
  EXPECT_EQ(a.values().size(), b.values().size());
  Difference found;
  for (std::size_t k = 0; k < a.values().size(); ++k) {
    found.values += a.values()[k] != b.values()[k];
    found.largest = std::max(found.largest, std::abs(double(a.values()[k]) - b.values()[k]));
  }
  return found;
}

/// Both solve to 1e-6 of the largest change: a value in the middle between two steps of 8 bits may
/// be rounded to either.
void expect_the_same(const Image<float>& a, const Image<float>& b) {
  const Difference found = difference(a, b);
  EXPECT_LE(found.largest, 1.001 / 255);
  EXPECT_LE(found.values, 1e-3 * double(a.values().size()));
}

/// "marquetry filter ..." as the words after the program's name.
std::vector<std::string> words_of(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  words.erase(words.begin());
  return words;
}

TEST(FilterTool, MakesTheTextureThatFilterMakesOfTheSavedMask) {
  const Folder folder;
  write_sphere(folder);
  const Result result =
      view(folder,
           "tool filter\n"
           "set length 2tx\nset beta 4\nsize 15%\nstrength 0.8\n"
           "stroke 1,0,0.2 0.6,0.2,0.8 0,0.3,1\n"
           "brush erase\nstrength 0.5\nstroke 0.6,0.3,0.8\n"
           "save-mask mask.png\nsave-texture painted.png\ncopy-command command.txt\n"
           "set beta 0.25\nset length 1%\n"
           "save-texture smoothed.png\n"
           "fill everywhere\nsave-texture all.png\ncopy-command all.txt\n",
           {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  const Image<float> painted = picture(folder, "painted.png");
  EXPECT_GT(difference(painted, picture(folder, "sphere.png")).values, 3000);

  const std::string line = file_bytes(folder / "command.txt");
  EXPECT_EQ(
      line,
      "marquetry filter --output=painted.png --beta=4 --mask=mask.png --length=2tx sphere.obj\n");
  std::filesystem::remove(folder / "painted.png");
  ASSERT_EQ(marquetry(folder, words_of(line)).status, 0);
  expect_the_same(painted, picture(folder, "painted.png"));

  ASSERT_EQ(marquetry(folder, {"filter", "sphere.obj", "-o", "cli.png", "--beta", "0.25",
                               "--length", "1%", "--mask", "mask.png"})
                .status,
            0);
  expect_the_same(picture(folder, "smoothed.png"), picture(folder, "cli.png"));

  const std::string everywhere = file_bytes(folder / "all.txt");
  EXPECT_THAT(everywhere, Not(HasSubstr("mask")));
  const Image<float> all = picture(folder, "all.png");
  std::filesystem::remove(folder / "all.png");
  ASSERT_EQ(marquetry(folder, words_of(everywhere)).status, 0);
  expect_the_same(all, picture(folder, "all.png"));
}

/// alpha is of the area that texels show.
TEST(FilterTool, MeasuresAsFilterDoesWhereSomeTrianglesHaveNoTexels) {
  const Folder folder;
  write_sphere(folder);
  std::string obj = file_bytes(folder / "sphere.obj");
  obj += "v 2 0 0\nv 9 0 0\nv 2 7 0\nf -3 -2 -1\n";
  write_bytes(folder / "more.obj", obj);
  const Result result = view(
      folder, "tool filter\nset alpha 2e-4\nfill everywhere\nsave-texture all.png\n", {"more.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  ASSERT_EQ(
      marquetry(folder, {"filter", "more.obj", "-o", "verb.png", "-b", "2", "-a", "2e-4"}).status,
      0);
  expect_the_same(picture(folder, "all.png"), picture(folder, "verb.png"));
  EXPECT_GT(difference(picture(folder, "all.png"), picture(folder, "sphere.png")).values, 3000);
}

TEST(FilterTool, KeepsMaskAndTextureApart) {
  const Folder folder;
  write_sphere(folder);
  const std::string painted = "tool filter\nsize 15%\nstroke 1,0,0.2\n";
  const Result over_mask =
      view(folder, painted + "save-mask same.png\nwait\nsave-texture same.png\n", {"sphere.obj"});
  EXPECT_EQ(over_mask.status, 2);
  EXPECT_THAT(over_mask.error, HasSubstr("same.png: mask and texture need files of their own"));
  EXPECT_EQ(picture(folder, "same.png").channels(), 1);  // it is the mask still
  const Result over_texture =
      view(folder, painted + "save-texture other.png\nsave-mask ./other.png\n", {"sphere.obj"});
  EXPECT_EQ(over_texture.status, 2);
  EXPECT_EQ(view(folder, "tool filter\nset beta 3 4\n", {"sphere.obj"}).status, 2);
}

TEST(FilterTool, KeepsTheMaskInTheCommandWhenALengthIsSetLater) {
  const Folder folder;
  write_sphere(folder);
  const Result result = view(folder,
                             "tool filter\nset alpha 1e-4\nbrush sharpen\nsize 15%\n"
                             "stroke 1,0,0.2 0.6,0.2,0.8\nsave-mask mask.png\n"
                             "set length 2tx\nsave-texture late.png\ncopy-command command.txt\n",
                             {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_THAT(file_bytes(folder / "command.txt"), HasSubstr("--output=late.png"));
  EXPECT_THAT(file_bytes(folder / "command.txt"), HasSubstr("--mask=mask.png"));
  const Result wrong = view(folder, "tool filter\nfill sometimes\n", {"sphere.obj"});
  EXPECT_EQ(wrong.status, 2);
  EXPECT_THAT(wrong.error, HasSubstr("wanted everywhere or nowhere"));
}

TEST(FilterTool, SharpensHereAndSmoothsThere) {
  const Folder folder;
  write_sphere(folder);
  const Result result =
      view(folder,
           "tool filter\nset length 2tx\nset beta 4\nsize 25%\nstrength 0.9\n"
           "stroke 1,0,0.2 0.6,0.2,0.8\nbrush smooth\nstroke 0.4,0.2,0.9 0,0.3,1 -0.5,0.3,0.8\n"
           "brush erase\nstrength 0.4\nstroke 0,0.3,1\n"
           "save-mask mask.exr\nsave-mask mask.tif\nsave-texture painted.png\n"
           "copy-command command.txt\n"
           "set beta 2\nsave-texture other.png\nset beta 4\nsave-texture again.png\n",
           {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  const Image<float> mask = picture(folder, "mask.exr");
  EXPECT_LT(*std::ranges::min_element(mask.values()), -0.8F);
  EXPECT_GT(*std::ranges::max_element(mask.values()), 0.8F);
  EXPECT_EQ(difference(mask, picture(folder, "mask.tif")).values, 0);
  const std::string line = file_bytes(folder / "command.txt");
  EXPECT_THAT(line, HasSubstr("--beta=4 --mask=mask.tif"));
  const Image<float> painted = picture(folder, "painted.png");
  std::filesystem::remove(folder / "painted.png");
  ASSERT_EQ(marquetry(folder, words_of(line)).status, 0);
  expect_the_same(painted, picture(folder, "painted.png"));
  expect_the_same(picture(folder, "again.png"), painted);
  ASSERT_EQ(marquetry(folder, {"filter", "sphere.obj", "-o", "cli.png", "--beta", "2", "--length",
                               "2tx", "--mask", "mask.exr"})
                .status,
            0);
  expect_the_same(picture(folder, "other.png"), picture(folder, "cli.png"));
}

/// Two sheets, one close behind the other.
TEST(FilterTool, DoesNotPaintThroughToWhatLiesBehind) {
  const Folder folder;
  write_bytes(folder / "sheets.obj",
              "mtllib sheets.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
              "v 0 0 -0.02\nv 1 0 -0.02\nv 1 1 -0.02\nv 0 1 -0.02\n"
              "vt 0.05 0.1\nvt 0.45 0.1\nvt 0.45 0.9\nvt 0.05 0.9\n"
              "vt 0.55 0.1\nvt 0.95 0.1\nvt 0.95 0.9\nvt 0.55 0.9\nusemtl paper\n"
              "f 1/1 2/2 3/3 4/4\nf 5/5 6/6 7/7 8/8\n");
  write_bytes(folder / "sheets.mtl", "newmtl paper\nmap_Kd paper.png\n");
  write_image(folder / "paper.png", Image<float>(64, 64, 3, 0.5F));
  const Result result =
      view(folder,
           "tool filter\nsize 30%\nstrength 1\nstroke 0.5,0.5,0\n"
           "save-mask front.png\nundo\nstroke 0.5,0.5,-0.02\nsave-mask back.png\n",
           {"sheets.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto painted = [&](const std::string& name) {
    const Image<float> mask = picture(folder, name);
    std::array<int, 2> count = {0, 0};
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 64; ++x) count[x < 32 ? 0 : 1] += mask(x, y) > 0;
    return count;
  };
  const auto front = painted("front.png"), back = painted("back.png");
  EXPECT_GT(front[0], 100);
  EXPECT_EQ(front[1], 0);
  EXPECT_EQ(back[0], 0);
  EXPECT_EQ(back[1], front[0]);
}

TEST(FilterTool, TakesStrokesBackAndDoesThemAgain) {
  const Folder folder;
  write_sphere(folder);
  const Result result = view(
      folder,
      "tool filter\nset length 2tx\nsize 20%\nstrength 0.3\n"
      "stroke 0,0,1 0.3,0,0.95 0,0.3,0.95\nwait\nsave-texture one.png\nsave-mask one_mask.png\n"
      "stroke 1,0,0 0.9,0.4,0\nundo\nsave-texture one_again.png\nsave-mask again_mask.png\n"
      "undo\nwait\nsave-texture none.png\nscreenshot none_shown.png atlas\n"
      "redo\nwait\nsave-texture redone.png\n"
      "undo\ntool none\nscreenshot untouched.png atlas\n",
      {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  const Image<float> original = picture(folder, "sphere.png");
  EXPECT_EQ(difference(picture(folder, "none.png"), original).values, 0);
  EXPECT_GT(difference(picture(folder, "one.png"), original).values, 3000);
  EXPECT_EQ(difference(picture(folder, "one_mask.png"), picture(folder, "again_mask.png")).values,
            0);
  expect_the_same(picture(folder, "one.png"), picture(folder, "one_again.png"));
  expect_the_same(picture(folder, "one.png"), picture(folder, "redone.png"));
  EXPECT_EQ(difference(picture(folder, "none_shown.png"), picture(folder, "untouched.png")).values,
            0);
}

TEST(FilterTool, PaintsWhereTheMouseGoesAndShowsBeforeAndAfter) {
  const Folder folder;
  write_sphere(folder);
  const Result result =
      view(folder,
           "view front\nlight off\nscreenshot before.png surface\n"
           "tool filter\nset length 2tx\nbrush smooth\nsize 20%\nstrength 1\nwait\n"
           "drag surface 120 200 150 200 180 210 210 220\nwait\nhover surface 1 1\n"
           "screenshot after.png surface\n"
           "wipe 0.5\nscreenshot wiped.png surface\n",
           {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_GT(result.json()["result"]["tool"]["painted"].get<int>(), 500);
  const Image<float> before = picture(folder, "before.png"), after = picture(folder, "after.png"),
                     wiped = picture(folder, "wiped.png");
  int changed_left = 0, changed_right = 0;
  for (int y = 30; y < before.height(); ++y)  // below the words "before" and "after"
    for (int x = 0; x < before.width(); ++x) {
      if (std::abs(x - surface_width / 2) < 3) continue;
      const Image<float>& wanted = x < surface_width / 2 ? before : after;
      for (int c = 0; c < 3; ++c) ASSERT_EQ(wiped(x, y, c), wanted(x, y, c)) << x << ", " << y;
      (x < surface_width / 2 ? changed_left : changed_right) += before(x, y) != after(x, y);
    }
  EXPECT_GT(changed_left, 500);
  EXPECT_GT(changed_right, 200);
}

TEST(FilterTool, LosesNothingThatWasSavedWhenItIsClosedInTheMiddle) {
  const Folder folder;
  write_sphere(folder, "640");
  const Result result = view(folder,
                             "tool filter\nset length 2tx\nsize 20%\nstroke 0,0,1\n"
                             "save-mask mask.png\nsave-texture painted.png\n"
                             "fill everywhere\nset alpha 0.01\nquit\n",
                             {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_FALSE(result.json()["result"]["tool"]["settled"].get<bool>());
  EXPECT_THAT(folder.names(), ElementsAre("mask.png", "painted.png", "session.txt", "sphere.mtl",
                                          "sphere.obj", "sphere.png"));
  ASSERT_EQ(marquetry(folder, {"filter", "sphere.obj", "-o", "cli.png", "--beta", "2", "--length",
                               "2tx", "--mask", "mask.png"})
                .status,
            0);
  expect_the_same(picture(folder, "painted.png"), picture(folder, "cli.png"));
}

TEST(FilterTool, RefusesWhatItCannotDo) {
  const Folder folder;
  write_strip(folder);
  write_bytes(folder / "shape.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const auto refused = [&](const std::string& script, const std::string& mesh = "strip.obj") {
    const Result result = view(folder, "tool filter\n" + script, {mesh});
    EXPECT_EQ(result.status, 2) << script;
    return result.error;
  };
  EXPECT_THAT(refused("", "shape.obj"),
              HasSubstr("session.txt, line 1: shape.obj: has neither texture coordinates"));
  EXPECT_THAT(refused("set beta 0.5\nfill everywhere\nbrush sharpen\n"),
              HasSubstr("line 4: what is painted smooths"));
  EXPECT_THAT(refused("brush smooth\nstroke 0.5,0.5,0\nset beta 0.5\n"),
              HasSubstr("line 4: beta: found 0.5"));
  EXPECT_THAT(refused("brush smooth\nstroke 0.5,0.5,0\nundo\nset beta 0.5\nredo\n"),
              HasSubstr("line 6: beta: found 0.5"));
  EXPECT_THAT(refused("brush smooth\nstroke 0.5,0.5,0\nsave-mask mask.png\n"),
              HasSubstr("line 4: mask.png: where it smooths the mask is below 0"));
  EXPECT_THAT(refused("stroke 0.5,0.5,0\ncopy-command\n"),
              HasSubstr("line 3: the command names the mask's file"));
  EXPECT_THAT(refused("save-mask mask.jpg\n"), HasSubstr("line 2: mask.jpg: a mask wants 16 bits"));
  EXPECT_THAT(refused("save-texture strip.png\n"),
              HasSubstr("line 2: strip.png: --output would replace it"));
  EXPECT_THAT(folder.names(),
              ElementsAre("session.txt", "shape.obj", "strip.mtl", "strip.obj", "strip.png"));
}

}  // namespace
}  // namespace mq::test
