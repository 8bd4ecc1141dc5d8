// What the window asks for before it begins, what it keeps, where its files go, and the ways out of it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "viewer/sessions.h"

namespace mq::test {
namespace {

using testing::HasSubstr;

bool same_values(const Image<float>& a, const Image<float>& b) {
  return std::ranges::equal(a.values(), b.values());
}

/// The sphere's texture as two photographs that show all of it.
void write_two_photographs(const Folder& folder) {
  const Image<float> colours = picture(folder, "sphere.png");
  Image<float> one(colours.width(), colours.height(), 4, 1.0F), two = one;
  for (int y = 0; y < colours.height(); ++y)
    for (int x = 0; x < colours.width(); ++x)
      for (int c = 0; c < 3; ++c) {
        one(x, y, c) = 0.9F * colours(x, y, c);
        two(x, y, c) = 0.7F * colours(x, y, c);
      }
  write_image(folder / "one.png", one);
  write_image(folder / "two.png", two);
}

TEST(Photographs, AreAskedForBeforeAnythingBegins) {
  const Folder folder;
  write_sphere(folder, "64");
  const auto refused = [&](const std::string& script) {
    const Result result = view(folder, script, {"sphere.obj"});
    EXPECT_EQ(result.status, 2) << script;
    return result.error;
  };
  EXPECT_THAT(refused("task photographs\nrun\n"), HasSubstr("Photographs are missing: choose the file of cameras"));
  EXPECT_THAT(refused("tool stitch\nrun\n"), HasSubstr("Photographs are missing: choose some that are textures"));
  EXPECT_THAT(refused("tool interpolate\nrun\n"), HasSubstr("Another texture is missing"));
  const Result set = view(folder,
                          "screenshot before.png atlas\ntool stitch\nset length 5%\nwait\nscreenshot after.png atlas\n",
                          {"sphere.obj"});
  ASSERT_EQ(set.status, 0) << set.error;
  EXPECT_TRUE(same_values(picture(folder, "before.png"), picture(folder, "after.png")));
  EXPECT_TRUE(set.json()["result"]["tool"]["stages"].empty());
}

/// Charts are not taken for photographs unless a person says so.
TEST(Photographs, AreTheChartsByName) {
  const Folder folder;
  write_sphere(folder, "64");
  const Result result = view(folder,
                             "tool charts\nwait\nscreenshot none.png atlas\nrun\nwait\nsave-texture charts.png\n"
                             "copy-command command.txt\n",
                             {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["tool"]["name"], "charts");
  EXPECT_EQ(file_bytes(folder / "command.txt"), "marquetry stitch --output=charts.png sphere.obj\n");
  ASSERT_EQ(marquetry(folder, {"stitch", "sphere.obj", "-o", "verb.png"}).status, 0);
  EXPECT_TRUE(file_bytes(folder / "charts.png") == file_bytes(folder / "verb.png"));
  const Result partial = view(folder, "tool charts\nset partial charts.png\n", {"sphere.obj"});
  EXPECT_EQ(partial.status, 2);
  EXPECT_THAT(partial.error, HasSubstr("take the tool stitch"));
}

TEST(Photographs, ThatWereChosenAreKeptFromOneWayToTheOther) {
  const Folder folder;
  write_sphere(folder, "64");
  write_two_photographs(folder);
  const std::string there_and_back =
      "tool stitch\nset partial one.png two.png\nwait\nscreenshot first.png atlas\n"
      "tool texture\nwait\nscreenshot with_cameras.png\ntask measure\ntask photographs\ntool stitch\nwait\n";
  const Result kept = view(folder, there_and_back, {"sphere.obj"});
  ASSERT_EQ(kept.status, 0) << kept.error;
  EXPECT_TRUE(kept.json()["result"]["tool"]["stages"].empty());  // nothing begins by itself
  const Result begun =
      view(folder, there_and_back + "run\nwait\nscreenshot again.png atlas\ncopy-command command.txt\n",
           {"sphere.obj"});
  ASSERT_EQ(begun.status, 0) << begun.error;
  EXPECT_EQ(begun.json()["result"]["tool"]["prepared"], 1);
  EXPECT_THAT(file_bytes(folder / "command.txt"), HasSubstr("--partial=one.png --partial=two.png"));
  EXPECT_TRUE(same_values(picture(folder, "first.png"), picture(folder, "again.png")));
  // The panel says what was kept and why it does not fit.
  const Result bare = view(folder, "tool texture\nwait\nscreenshot bare.png\n", {"sphere.obj"});
  ASSERT_EQ(bare.status, 0) << bare.error;
  EXPECT_FALSE(same_values(picture(folder, "with_cameras.png"), picture(folder, "bare.png")));
  // Of another model they are none.
  const Result other = view(folder, there_and_back + "open sphere.obj\ntool stitch\nrun\n", {"sphere.obj"});
  EXPECT_EQ(other.status, 2);
  EXPECT_THAT(other.error, HasSubstr("Photographs are missing"));
}

TEST(Photographs, AreTakenWhereTheyAreDropped) {
  const Folder folder;
  write_sphere(folder, "64");
  write_two_photographs(folder);
  const Result result = view(folder, "tool stitch\ndrop one.png\ndrop two.png\nwait\ncopy-command command.txt\n",
                             {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_THAT(file_bytes(folder / "command.txt"), HasSubstr("--partial=one.png --partial=two.png"));
  const Result alone = view(folder, "task photographs\ndrop one.png\n", {"sphere.obj"});
  EXPECT_EQ(alone.status, 2);
  EXPECT_THAT(alone.error, HasSubstr("photographs alone do not say from where they were taken"));
}

/// What none shows is filled as the verb fills it, the gutter around it too.
TEST(Photographs, ThatShowNotAllAreFilledAsTheVerbDoes) {
  const Folder folder;
  write_sphere(folder, "128");
  write_two_photographs(folder);
  for (const char* name : {"one.png", "two.png"}) {
    Image<float> holed = picture(folder, name);
    for (int y = 30; y < 50; ++y)
      for (int x = 0; x < 20; ++x) holed(x, y, 3) = 0;
    write_image(folder / name, holed);
  }
  const Result result = view(folder, "tool stitch\nset partial one.png two.png\nwait\nscreenshot shown.png atlas\n",
                             {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  const Result verb = marquetry(folder, {"stitch", "sphere.obj", "-o", "out.png", "--partial", "one.png", "--partial",
                                         "two.png", "--json"});
  ASSERT_EQ(verb.status, 0) << verb.error;
  EXPECT_GT(verb.json()["result"]["unseen"].get<int>(), 200);
  ASSERT_EQ(view(folder, "screenshot verb.png atlas\n", {"sphere.obj", "out.png"}).status, 0);
  EXPECT_TRUE(same_values(picture(folder, "shown.png"), picture(folder, "verb.png")));
}

TEST(Photographs, ThatAreTakenBackLeaveTheTextureAsItWas) {
  const Folder folder;
  write_sphere(folder, "64");
  write_two_photographs(folder);
  const Result result = view(folder,
                             "screenshot before.png atlas\ntool stitch\nset partial one.png two.png\nwait\n"
                             "set partial \"\"\nwait\nscreenshot after.png atlas\n",
                             {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_TRUE(same_values(picture(folder, "before.png"), picture(folder, "after.png")));
}

/// What was stopped shows no distance from an earlier place, and can go on.
TEST(Measuring, ShowsNoDistanceThatIsNotOfThePlacePressed) {
  const Folder folder;
  write_sphere(folder, "256");
  const std::string stopped =
      "task measure\nview front\nset isolines 0\nsource 0,0,1\nwait\nset time 3\nstop\nhover surface 250 218\n";
  const Result none = view(folder, stopped, {"sphere.obj"});
  ASSERT_EQ(none.status, 0) << none.error;
  EXPECT_FALSE(none.json()["result"]["tool"].contains("reading"));
  const Result again = view(folder, stopped + "run\nwait\nhover surface 250 218\n", {"sphere.obj"});
  ASSERT_EQ(again.status, 0) << again.error;
  EXPECT_TRUE(again.json()["result"]["tool"].contains("reading"));
}

TEST(Saving, GoesBesideTheModel) {
  const Folder folder;
  std::filesystem::create_directory(folder / "models");
  ASSERT_EQ(marquetry(folder, {"sample", "sphere", "-o", "models/sphere.obj", "--size", "64"}).status, 0);
  const std::string paint = "task paint\nsize 30%\nstroke 0,0,1\nwait\nkey ctrl+s\nwait\n";
  const Result result = view(folder, paint + "screenshot saved.png\ncopy-command\n", {"models/sphere.obj"});
  // The mask is not saved, which the command needs.
  EXPECT_EQ(result.status, 2);
  EXPECT_TRUE(std::filesystem::exists(folder / "models/filtered.png"));
  EXPECT_FALSE(std::filesystem::exists(folder / "filtered.png"));
  ASSERT_EQ(view(folder, "tool seams\nrun\nwait\nkey ctrl+s\nwait\ncopy-command command.txt\n", {"models/sphere.obj"})
                .status,
            0);
  EXPECT_TRUE(std::filesystem::exists(folder / "models/out.png"));
  EXPECT_EQ(file_bytes(folder / "command.txt"), "marquetry seams --output=models/out.png models/sphere.obj\n");
  ASSERT_EQ(view(folder, "tool seams\nrun\nwait\nkey ctrl+s\nwait\n", {"models/sphere.obj"}).status, 0);
  EXPECT_TRUE(std::filesystem::exists(folder / "models/out_2.png"));
}

/// Samples lie in a cache, where nobody looks for results.
TEST(Saving, OfASampleGoesHome) {
  const Folder folder;
  std::filesystem::create_directory(folder / "home");
  const RunOptions at_home = {
      .environment = {{"XDG_CACHE_HOME", "cache"}, {"XDG_STATE_HOME", "state"}, {"HOME", (folder / "home").string()}}};
  const Result result = view(folder, "sample sphere\ntool seams\nrun\nwait\nkey ctrl+s\nwait\n", {}, at_home);
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_TRUE(std::filesystem::exists(folder / "home/out.png"));
  EXPECT_THAT(result.error, HasSubstr((folder / "home/out.png").string()));
}

/// Two spots, the larger one first, and round again.
TEST(Comparing, GoesWhereTexturesDifferMost) {
  const Folder folder;
  write_sphere(folder, "512");
  Image<float> other = picture(folder, "sphere.png");
  const auto spot = [&](int x, int y, int side) {
    for (int j = 0; j < side; ++j)
      for (int i = 0; i < side; ++i)
        for (int c = 0; c < 3; ++c) other(x + i, y + j, c) = other(x + i, y + j, c) > 0.5F ? 0.F : 1.F;
  };
  spot(40, 60, 4);
  spot(220, 360, 10);
  write_image(folder / "other.png", other);
  const std::string middle = "hover surface 179 218\n";
  const Result result = view(folder,
                             "task compare\nwith other.png\nwait\nnext-difference\n" + middle + "next-difference\n" +
                                 middle + "key n\nwait\nnext-difference\n" + middle + "screenshot there.png\n",
                             {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto picks = result.json()["result"]["picks"];
  const auto near = [&](std::size_t i, int x, int y) {
    const auto texel = picks[i]["pick"]["texel"];
    EXPECT_NEAR(texel[0].get<int>(), x, 8) << i;
    EXPECT_NEAR(texel[1].get<int>(), y, 8) << i;
  };
  ASSERT_EQ(picks.size(), 3U);
  near(0, 225, 365);
  near(1, 42, 62);
  near(2, 42, 62);  // the first again, by its key, and the second

  const Result none = view(folder, "task compare\nwith sphere.png\nwait\nnext-difference\n", {"sphere.obj"});
  EXPECT_EQ(none.status, 2);
  EXPECT_THAT(none.error, HasSubstr("the textures do not differ anywhere on the model"));
}

TEST(Comparing, GoesWhereWasPainted) {
  const Folder folder;
  write_sphere(folder, "128");
  const Result result = view(folder,
                             "task paint\nset strength 300\nsize 15%\nstroke -1,0,0\nwait\ntask compare\n"
                             "next-difference\nhover surface 179 218\n",
                             {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_LT(result.json()["result"]["picks"][0]["pick"]["point"][0].get<double>(), -0.7);
  EXPECT_EQ(result.json()["result"]["title"], "* sphere.obj - marquetry");
}

TEST(Closing, OfAModelLeadsToTheEmptyWindow) {
  const Folder folder;
  write_sphere(folder, "64");
  const Result closed = view(folder, "task measure\nclose-model\nscreenshot empty.png\n", {"sphere.obj"});
  ASSERT_EQ(closed.status, 0) << closed.error;
  EXPECT_EQ(closed.json()["result"]["title"], "marquetry");
  const Result working = view(folder, "key ctrl+w\ntask paint\n", {"sphere.obj"});
  EXPECT_EQ(working.status, 2);
  EXPECT_THAT(working.error, HasSubstr("there is no model yet"));
  // Opened anew it is as it was at first.
  const Result again = view(folder,
                            "hover surface 1 1\nscreenshot first.png surface\nview back\nshow charts\nclose-model\n"
                            "open sphere.obj\nhover surface 1 1\nscreenshot again.png surface\n",
                            {"sphere.obj"});
  ASSERT_EQ(again.status, 0) << again.error;
  EXPECT_TRUE(same_values(picture(folder, "first.png"), picture(folder, "again.png")));
}

TEST(Closing, OfAModelAsksForWhatIsNotSaved) {
  const Folder folder;
  write_sphere(folder, "64");
  const std::string paint = "task paint\nsize 30%\nstroke 0,0,1\nwait\nclose-model\n";
  const Result asked = view(folder, paint, {"sphere.obj"});
  EXPECT_EQ(asked.status, 2);
  EXPECT_THAT(asked.error, HasSubstr("It is lost if you close the model"));
  const Result stays = view(folder, paint + "answer no\n", {"sphere.obj"});
  ASSERT_EQ(stays.status, 0) << stays.error;
  EXPECT_EQ(stays.json()["result"]["title"], "* sphere.obj - marquetry");
  const Result saved = view(folder, paint + "answer save\n", {"sphere.obj"});
  ASSERT_EQ(saved.status, 0) << saved.error;
  EXPECT_EQ(saved.json()["result"]["title"], "marquetry");
  EXPECT_TRUE(std::filesystem::exists(folder / "filtered.png"));
}

}  // namespace
}  // namespace mq::test
