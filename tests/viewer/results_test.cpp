// What tools made: asked for before it is lost, and kept for the next one to begin with. And what is shown of a model
// that is opened.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "viewer/sessions.h"

namespace mq::test {
namespace {

using testing::HasSubstr;

float farthest(const Image<float>& a, const Image<float>& b) {
  EXPECT_EQ(a.values().size(), b.values().size());
  float most = 0;
  for (std::size_t k = 0; k < std::min(a.values().size(), b.values().size()); ++k)
    most = std::max(most, std::abs(a.values()[k] - b.values()[k]));
  return most;
}

TEST(Results, AreAskedForBeforeTheyAreLost) {
  const Folder folder;
  write_sphere(folder, "64");
  const std::string made = "ask\ntool seams\nrun\nwait\n";
  const Result stays = view(folder, made + "tool denoise\nanswer no\n", {"sphere.obj"});
  ASSERT_EQ(stays.status, 0) << stays.error;
  EXPECT_EQ(stays.json()["result"]["tool"]["name"], "seams");
  EXPECT_EQ(stays.json()["result"]["title"], "* sphere.obj - marquetry");
  const Result goes = view(folder, made + "task measure\nanswer yes\n", {"sphere.obj"});
  ASSERT_EQ(goes.status, 0) << goes.error;
  EXPECT_EQ(goes.json()["result"]["tool"]["name"], "geodesic");
  EXPECT_EQ(goes.json()["result"]["title"], "sphere.obj - marquetry");
  const Result saves = view(folder, made + "close-model\nanswer save\n", {"sphere.obj"});
  ASSERT_EQ(saves.status, 0) << saves.error;
  ASSERT_EQ(marquetry(folder, {"seams", "sphere.obj", "-o", "verb.png"}).status, 0);
  EXPECT_EQ(farthest(picture(folder, "out.png"), picture(folder, "verb.png")), 0);
  const Result asks = view(folder, made + "close\n", {"sphere.obj"});
  EXPECT_EQ(asks.status, 2);
  EXPECT_THAT(asks.error, HasSubstr("You have not saved what 'close seams' made. It is lost if you close the window."));
}

/// As the verbs make of each other's files.
TEST(Results, BecomeTheTextureThatTheNextToolBeginsWith) {
  const Folder folder;
  write_sphere(folder, "64");
  const Result chained = view(folder,
                              "ask\ntool seams\nrun\nwait\ntool shock\nanswer keep\nrun\nwait\n"
                              "save-texture both.png\n",
                              {"sphere.obj"});
  ASSERT_EQ(chained.status, 0) << chained.error;
  EXPECT_EQ(chained.json()["result"]["title"], "sphere.obj - marquetry");  // both are in the file
  ASSERT_EQ(marquetry(folder, {"seams", "sphere.obj", "-o", "first.png"}).status, 0);
  ASSERT_EQ(marquetry(folder, {"shock", "sphere.obj", "first.png", "-o", "second.png"}).status, 0);
  EXPECT_EQ(farthest(picture(folder, "both.png"), picture(folder, "second.png")), 0);
}

TEST(Results, ThatAreKeptAreSavedLater) {
  const Folder folder;
  write_sphere(folder, "64");
  const std::string kept = "tool seams\nrun\nwait\nkeep\n";
  const Result unsaved = view(folder, kept, {"sphere.obj"});
  ASSERT_EQ(unsaved.status, 0) << unsaved.error;
  EXPECT_EQ(unsaved.json()["result"]["title"], "* sphere.obj - marquetry");
  EXPECT_EQ(unsaved.json()["result"]["tool"]["name"], "seams");
  EXPECT_TRUE(unsaved.json()["result"]["tool"]["stages"].empty());
  const Result saved = view(folder, kept + "key ctrl+s\nclose\n", {"sphere.obj"});
  ASSERT_EQ(saved.status, 0) << saved.error;
  ASSERT_EQ(marquetry(folder, {"seams", "sphere.obj", "-o", "verb.png"}).status, 0);
  EXPECT_EQ(farthest(picture(folder, "out.png"), picture(folder, "verb.png")), 0);
  const Result asked = view(folder, kept + "close\nanswer save\n", {"sphere.obj"});
  ASSERT_EQ(asked.status, 0) << asked.error;
  EXPECT_TRUE(std::filesystem::exists(folder / "out_2.png"));
  const Result nothing = view(folder, "keep\n", {"sphere.obj"});
  EXPECT_EQ(nothing.status, 2);
  EXPECT_THAT(nothing.error, HasSubstr("there is nothing to keep"));
}

TEST(Changing, SmoothsOrSharpensEverything) {
  const Folder folder;
  write_sphere(folder, "64");
  const Result result =
      view(folder, "tool detail\nset beta 2\nset length 3tx\nrun\nwait\nsave-texture window.png\n", {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["tool"]["name"], "detail");
  ASSERT_EQ(marquetry(folder, {"filter", "sphere.obj", "-o", "verb.png", "--beta", "2", "--length", "3tx"}).status, 0);
  EXPECT_LE(farthest(picture(folder, "window.png"), picture(folder, "verb.png")), 1.01F / 255);
  EXPECT_GT(farthest(picture(folder, "window.png"), picture(folder, "sphere.png")), 0.02F);
  const Result chosen = view(folder, "tool detail\nwait\n", {"sphere.obj"});
  EXPECT_EQ(chosen.json()["result"]["tool"]["painted"], 0);
}

TEST(Comparing, SaysThatNothingWasChangedYet) {
  const Folder folder;
  write_sphere(folder, "64");
  const Result result = view(folder,
                             "screenshot plain.png surface\ntask compare\nscreenshot compared.png surface\n"
                             "task paint\nwait\ntask compare\nscreenshot visited.png surface\nkey n\n",
                             {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(farthest(picture(folder, "plain.png"), picture(folder, "compared.png")), 0);  // without a wipe
  EXPECT_EQ(farthest(picture(folder, "plain.png"), picture(folder, "visited.png")), 0);
  EXPECT_THAT(result.error, HasSubstr("nothing was changed yet"));
}

TEST(Opening, ShowsWhatTheModelHas) {
  const Folder folder;
  write_sphere(folder, "64");
  std::filesystem::copy(folder / "sphere.obj", folder / "other.obj");
  const Result result =
      view(folder, "show clay\nopen other.obj\nscreenshot opened.png surface\n", {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  ASSERT_EQ(view(folder, "screenshot named.png surface\n", {"other.obj"}).status, 0);
  EXPECT_EQ(farthest(picture(folder, "opened.png"), picture(folder, "named.png")), 0);
}

TEST(Photographs, StayAsTheyWereGiven) {
  const Folder folder;
  write_sphere(folder, "64");
  const Result result = view(folder, "tool stitch\ntask measure\ntask photographs\n", {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["tool"]["name"], "stitch");
}

TEST(Photographs, HaveASample) {
  const Folder folder;
  const Result result = view(folder, "sample photographs\n", {}, own_places);
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["tool"]["name"], "texture");
  const Result cameras = marquetry(folder, {"cameras", "cache/marquetry/samples/photographs/cameras.json", "--json"});
  ASSERT_EQ(cameras.status, 0) << cameras.error;
  EXPECT_TRUE(std::filesystem::exists(folder / "cache/marquetry/samples/photographs/photograph_5.png"));
}

}  // namespace
}  // namespace mq::test
