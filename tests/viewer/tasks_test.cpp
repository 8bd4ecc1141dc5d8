// What a person meets from the empty window on: opening, tasks, strokes and their list, saving.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "viewer/sessions.h"

namespace mq::test {
namespace {

using testing::HasSubstr;

int differing(const Image<float>& a, const Image<float>& b) {
  EXPECT_EQ(a.values().size(), b.values().size());
  int count = 0;
  for (std::size_t k = 0; k < std::min(a.values().size(), b.values().size()); ++k)
    count += a.values()[k] != b.values()[k];
  return count;
}

TEST(EmptyWindow, MakesASampleAndOpensIt) {
  const Folder folder;
  const Result result =
      view(folder, "screenshot empty.png\nsample sphere\nscreenshot opened.png surface\n", {}, own_places);
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["title"], "sphere.obj - marquetry");
  EXPECT_TRUE(std::filesystem::exists(folder / "cache/marquetry/samples/sphere/sphere.png"));
  EXPECT_EQ(picture(folder, "empty.png").width(), 900);
  ASSERT_EQ(view(folder, "screenshot named.png surface\n", {"cache/marquetry/samples/sphere/sphere.obj"}).status, 0);
  EXPECT_EQ(differing(picture(folder, "opened.png"), picture(folder, "named.png")), 0);
}

/// What is there of it meanwhile leaves no trace.
TEST(EmptyWindow, ShowsAModelAsIfItHadBeenThereFromTheBeginning) {
  const Folder folder;
  write_sphere(folder, "256");
  const Result result = view(folder, "open sphere.obj\nframes 2\nscreenshot opened.png\n", {});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto first = result.json()["result"]["first_pictures"];
  EXPECT_GT(first["window"], 0);
  EXPECT_GT(first["shape"], 0);
  EXPECT_LE(first["shape"], first["coarse"]);
  EXPECT_LE(first["coarse"], first["all"]);
  ASSERT_EQ(view(folder, "frames 2\nscreenshot named.png\n", {"sphere.obj"}).status, 0);
  const Image<float> opened = picture(folder, "opened.png"), named = picture(folder, "named.png");
  const int top = opened.height() - 60;  // below is what was said
  EXPECT_EQ(differing(cropped(opened, 0, 0, opened.width(), top), cropped(named, 0, 0, named.width(), top)), 0);
}

TEST(EmptyWindow, OpensAPictureAsTheVerbDoes) {
  const Folder folder;
  write_image(folder / "wall.png", Image<float>(32, 16, 3, 0.5F));
  const Result result = view(folder, "open wall.png\nhover surface 300 200\n", {});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["title"], "wall.png - marquetry");
}

TEST(EmptyWindow, SaysWhatItWants) {
  const Folder folder;
  write_bytes(folder / "notes.txt", "no model");
  const auto refused = [&](const std::string& script) {
    const Result result = view(folder, script, {}, own_places);
    EXPECT_EQ(result.status, 2) << script;
    return result.error;
  };
  EXPECT_THAT(refused("task paint\n"), HasSubstr("line 1: 'task': there is no model yet"));
  EXPECT_THAT(refused("stroke 0,0,1\n"), HasSubstr("there is no model yet: open one first"));
  EXPECT_THAT(refused("sample owl\n"), HasSubstr("found 'owl', wanted bust"));
  EXPECT_THAT(refused("recent 1\n"), HasSubstr("recent: found 1, and 0 models were opened before"));
  const Result verb = marquetry(folder, {"inspect", "notes.txt"});
  const std::string said = verb.error.substr(verb.error.find("notes.txt"));
  EXPECT_THAT(refused("drop notes.txt\nwait\n"), HasSubstr(said.substr(0, said.find('\n'))));
}

TEST(EmptyWindow, OpensWhatWasOpenedBefore) {
  const Folder folder;
  write_sphere(folder, "64");
  std::filesystem::create_directories(folder / "state/marquetry");
  write_bytes(folder / "state/marquetry/recent",
              "/nowhere/gone.obj\n" + (folder / "sphere.obj").string() + "\n");
  const Result result = view(folder, "screenshot start.png\nrecent 1\n", {}, own_places);
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["title"], "sphere.obj - marquetry");
}

TEST(Tasks, RunNothingUntilTheyAreAskedTo) {
  const Folder folder;
  write_sphere(folder, "128");
  const Result result = view(folder,
                             "screenshot before.png atlas\ntask change\ntool denoise\nwait\n"
                             "screenshot chosen.png atlas\n",
                             {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(differing(picture(folder, "before.png"), picture(folder, "chosen.png")), 0);
  EXPECT_TRUE(result.json()["result"]["tool"]["stages"].empty());
  const Result run = view(folder, "tool seams\nrun\nwait\nscreenshot run.png atlas\n", {"sphere.obj"});
  ASSERT_EQ(run.status, 0) << run.error;
  EXPECT_EQ(run.json()["result"]["tool"]["stages"], nlohmann::json({"result"}));
  ASSERT_EQ(marquetry(folder, {"seams", "sphere.obj", "-o", "verb.png"}).status, 0);
  ASSERT_EQ(view(folder, "screenshot verb_shown.png atlas\n", {"sphere.obj", "verb.png"}).status, 0);
  EXPECT_EQ(differing(picture(folder, "run.png"), picture(folder, "verb_shown.png")), 0);
}

TEST(Tasks, ThatOnlyLookLeaveTheToolInHand) {
  const Folder folder;
  write_sphere(folder, "64");
  const std::string paint = "task paint\nset strength 300\nset radius 2tx\nsize 30%\nstroke 0,0,1\nwait\n";
  const Result result = view(folder,
                             paint + "screenshot painted.png atlas\ntask look\nview back\ntask picture\n"
                                     "picture big.png atlas 2\ntask compare\ntask paint\nwipe off\nwait\n"
                                     "screenshot again.png atlas\n",
                             {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["title"], "* sphere.obj - marquetry");
  EXPECT_EQ(differing(picture(folder, "painted.png"), picture(folder, "again.png")), 0);
  EXPECT_EQ(picture(folder, "big.png").width(), 2 * atlas_width);
  EXPECT_EQ(picture(folder, "big.png").height(), 2 * atlas_height);
}

TEST(Tasks, CompareWithAnotherTexture) {
  const Folder folder;
  write_sphere(folder, "64");
  Image<float> other = picture(folder, "sphere.png");
  const float was = other(20, 10, 1);
  other(20, 10, 1) = was > 0.5F ? 0.F : 1.F;
  write_image(folder / "other.png", other);
  const Result result = view(folder,
                             "tool compare\nwith other.png\nwait\nscreenshot after.png atlas\n"
                             "tool none\nscreenshot own.png atlas\ntool compare\nwith other.png\nwait\n",
                             {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto found = result.json()["result"]["tool"]["found"][0];
  EXPECT_EQ(found["texel"], nlohmann::json({20, 10}));
  EXPECT_NEAR(found["largest"].get<double>(), std::abs(other(20, 10, 1) - was), 1e-6);
  EXPECT_GT(differing(picture(folder, "after.png"), picture(folder, "own.png")), 0);
  EXPECT_EQ(view(folder, "tool compare\nwith a.png b.png\n", {"sphere.obj"}).status, 2);
}

TEST(Tasks, CompareWithAnotherTextureWithoutATool) {
  const Folder folder;
  write_sphere(folder, "64");
  Image<float> other = picture(folder, "sphere.png");
  for (float& value : other.values()) value = 1 - value;
  write_image(folder / "other.png", other);
  const Result result =
      view(folder, "task compare\nwith other.png\nwait\nscreenshot seen.png\n", {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto tool = result.json()["result"]["tool"];
  EXPECT_EQ(tool["name"], "compare");
  EXPECT_EQ(tool["with"], nlohmann::json({"other.png"}));
  EXPECT_GT(tool["found"][0]["rms"], 0.01);
  const Result without = view(folder, "with other.png\n", {"sphere.obj"});
  EXPECT_EQ(without.status, 2);
  EXPECT_THAT(without.error, HasSubstr("'with' is something that a tool does"));
}

TEST(Tasks, SayThatAStrokeDoesNothing) {
  const Folder folder;
  write_sphere(folder, "64");
  const Result away = view(folder, "task paint\nsize 5%\nstroke 9,9,9\n", {"sphere.obj"});
  ASSERT_EQ(away.status, 0) << away.error;
  EXPECT_THAT(away.error, HasSubstr("the stroke touches nothing of the model: no texel is within the brush"));
  const Result again = view(folder, "task paint\nsize 20%\nbrush erase\nstroke 0,0,1\n", {"sphere.obj"});
  EXPECT_THAT(again.error, HasSubstr("the stroke changes nothing: what it touches is so already"));
  const Result sharpened = view(folder, "task paint\nsize 20%\nstroke 0,0,1\n", {"sphere.obj"});
  EXPECT_THAT(sharpened.error, testing::Not(HasSubstr("the stroke")));
}

TEST(Tasks, TakeCamerasThatAreDropped) {
  const Folder folder;
  write_sphere(folder, "64");
  ASSERT_EQ(marquetry(folder, {"render", "sphere.obj", "-o", "front.png", "--cameras", "front.json", "--view",
                               "front", "--size", "200", "--unlit"})
                .status,
            0);
  const Result result = view(folder, "task photographs\ndrop front.json\nrun\nwait\n", {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto tool = result.json()["result"]["tool"];
  EXPECT_EQ(tool["name"], "texture");
  EXPECT_EQ(tool["prepared"], 1);
}

TEST(Strokes, WaitForTheBrushWhereAScriptIsFast) {
  const Folder folder;
  write_sphere(folder, "64");
  const Result result = view(folder, "view front\ntask paint\nsize 20%\ndrag surface 170 210 190 230\nwait\n", {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_GT(result.json()["result"]["tool"]["painted"], 0);
}

/// As a person names them who sees only the model's folder.
TEST(Comparing, FindsFilesBesideTheModel) {
  const Folder folder;
  write_sphere(folder, "64");
  std::filesystem::create_directory(folder / "there");
  std::filesystem::copy(folder / "sphere.png", folder / "there/other.png");
  for (const char* file : {"sphere.obj", "sphere.mtl", "sphere.png"})
    std::filesystem::rename(folder / file, folder / "there" / file);
  const Result result = view(folder, "task compare\nwith other.png\nwait\n", {"there/sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["tool"]["found"][0]["largest"], 0);
}

TEST(Strokes, AreAListThatOneGoesAlong) {
  const Folder folder;
  write_sphere(folder, "64");
  const Result result = view(folder,
                             "task paint\nsize 20%\nstroke 0,0,1\nsave-mask one.png\n"
                             "stroke 1,0,0\nbrush erase\nstroke 0,0,1\nsave-mask three.png\n"
                             "history 1\nsave-mask one_again.png\nhistory 3\nsave-mask three_again.png\n"
                             "history 0\nkey ctrl+y\nsave-mask by_key.png\n",
                             {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(differing(picture(folder, "one.png"), picture(folder, "one_again.png")), 0);
  EXPECT_EQ(differing(picture(folder, "one.png"), picture(folder, "by_key.png")), 0);
  EXPECT_EQ(differing(picture(folder, "three.png"), picture(folder, "three_again.png")), 0);
  EXPECT_GT(differing(picture(folder, "one.png"), picture(folder, "three.png")), 0);
  const Result beyond = view(folder, "task paint\nstroke 0,0,1\nhistory 2\n", {"sphere.obj"});
  EXPECT_EQ(beyond.status, 2);
  EXPECT_THAT(beyond.error, HasSubstr("line 3: there is no stroke 2: there are 1"));
}

TEST(Strokes, HaveASoftOrAHardEdge) {
  const Folder folder;
  write_sphere(folder, "64");
  const Result result = view(folder,
                             "task paint\nsize 20%\nstrength 1\nstroke 0,0,1\nsave-mask soft.png\n"
                             "undo\nhardness 1\nstroke 0,0,1\nsave-mask hard.png\n",
                             {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto count = [&](const std::string& name, float least) {
    return std::ranges::count_if(picture(folder, name).values(), [&](float v) { return v >= least; });
  };
  EXPECT_EQ(count("soft.png", 1e-4F), count("hard.png", 1e-4F));  // the same reach
  EXPECT_EQ(count("hard.png", 1e-4F), count("hard.png", 1));
  EXPECT_LT(count("soft.png", 0.9F), count("hard.png", 0.9F) / 2);
}

/// However far the mouse goes between two pictures.
TEST(Strokes, FollowTheSurfaceAtAnyRateOfPictures) {
  const Folder folder;
  write_sphere(folder, "128");
  std::string slow = "drag surface 80 220";
  for (int x = 82; x <= 270; x += 2) slow += " " + std::to_string(x) + " 220";
  const Result result = view(folder,
                             "view front\ntask paint\nsize 5%\nstrength 1\nhardness 1\nwait\n"
                             "drag surface 80 220 270 220\nsave-mask fast.png\nundo\n" +
                                 slow + "\nsave-mask slow.png\n",
                             {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  const Image<float> fast = picture(folder, "fast.png"), even = picture(folder, "slow.png");
  int both = 0, either = 0;
  for (std::size_t k = 0; k < fast.values().size(); ++k) {
    both += fast.values()[k] > 0 && even.values()[k] > 0;
    either += fast.values()[k] > 0 || even.values()[k] > 0;
  }
  EXPECT_GT(both, 200);
  EXPECT_GT(both, either * 9 / 10);
}

TEST(Painting, CountsWhatAPictureWouldClamp) {
  const Folder folder;
  write_sphere(folder, "64");
  const auto values = [&](const std::string& script) {
    const Result result = view(folder, "task paint\n" + script, {"sphere.obj"});
    EXPECT_EQ(result.status, 0) << result.error;
    return result.json()["result"]["tool"]["values"];
  };
  const auto before = values(""), after = values("set strength 3000\nfill everywhere\nwait\n");
  EXPECT_EQ(before["below"], 0);
  EXPECT_EQ(before["above"], 0);
  EXPECT_EQ(before["count"], after["count"]);
  EXPECT_GT(after["below"].get<int>() + after["above"].get<int>(), 0);
}

TEST(Closing, OffersToSaveFirst) {
  const Folder folder;
  write_sphere(folder, "64");
  const std::string paint = "task paint\nsize 30%\nstroke 0,0,1\nwait\n";
  const Result saved = view(folder, paint + "close\nanswer save\n", {"sphere.obj"});
  ASSERT_EQ(saved.status, 0) << saved.error;
  EXPECT_GT(differing(picture(folder, "filtered.png"), picture(folder, "sphere.png")), 0);
  std::filesystem::remove(folder / "filtered.png");
  ASSERT_EQ(view(folder, paint + "close\nanswer yes\n", {"sphere.obj"}).status, 0);
  EXPECT_FALSE(std::filesystem::exists(folder / "filtered.png"));
  const Result nothing = view(folder, "close\nanswer save\n", {"sphere.obj"});
  EXPECT_EQ(nothing.status, 0);  // nothing was asked, and the window is closed
}

TEST(Measuring, SaysHowFarAPlaceIs) {
  const Folder folder;
  write_sphere(folder, "128");
  const Result result = view(folder,
                             "task measure\nview front\nset isolines 0\nsource 0,0,1\nwait\n"
                             "click surface 179 218\nwait\nhover surface 250 218\nscreenshot read.png\n",
                             {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto tool = result.json()["result"]["tool"];
  const auto point = result.json()["result"]["picks"][1]["pick"]["point"];
  ASSERT_TRUE(tool.contains("reading"));
  const double along = std::atan2(point[0].get<double>(), point[2].get<double>());
  EXPECT_NEAR(tool["reading"].get<double>(), along, 0.03 * along);
}

/// With the front of each place while the mouse is dragged, and at last with what the verb finds.
TEST(Measuring, FollowsTheMouse) {
  const Folder folder;
  write_sphere(folder, "128");
  const std::string begin = "task measure\nview front\nset isolines 6\n";
  const Result dragged = view(folder,
                              begin + "source 0,0,1\nwait\ndrag surface 170 210 180 215 190 220 200 230 210 240\n"
                                      "wait\npicture dragged.png atlas\ncopy-command command.txt\n",
                              {"sphere.obj"});
  ASSERT_EQ(dragged.status, 0) << dragged.error;
  const auto tool = dragged.json()["result"]["tool"];
  EXPECT_GE(tool["live_seconds"].size(), 2U);  // of the first place, and of one at least on the way
  EXPECT_EQ(tool["live_seconds"].size(), tool["front_seconds"].size());
  EXPECT_EQ(tool["stages"].size(), 1U);
  const std::string command = file_bytes(folder / "command.txt");
  const std::size_t at = command.find("--from=") + 7;
  const Result placed = view(folder,
                             begin + "source " + command.substr(at, command.find(' ', at) - at) +
                                 "\nwait\npicture placed.png atlas\n",
                             {"sphere.obj"});
  ASSERT_EQ(placed.status, 0) << placed.error;
  EXPECT_EQ(differing(picture(folder, "dragged.png"), picture(folder, "placed.png")), 0);
}

TEST(Keys, DoWhatTheListSays) {
  const Folder folder;
  write_sphere(folder, "64");
  const Result result = view(folder,
                             "screenshot plain.png\nkey ?\nscreenshot list.png\nkey escape\n"
                             "screenshot again.png\nkey s\nscreenshot seams.png surface\noverlay seams off\n"
                             "key 3\nwait\nhover surface 1 1\nkey d\nscreenshot light.png\nkey d\nkey 1\n",
                             {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_GT(differing(picture(folder, "plain.png"), picture(folder, "list.png")), 1000);
  EXPECT_EQ(differing(picture(folder, "plain.png"), picture(folder, "again.png")), 0);
  const Image<float> light = picture(folder, "light.png"), dark = picture(folder, "plain.png");
  EXPECT_GT(light(5, 300, 0), 0.8F);
  EXPECT_LT(dark(5, 300, 0), 0.3F);
  const Result none = view(folder, "key x\n", {"sphere.obj"});
  EXPECT_EQ(none.status, 2);
  EXPECT_THAT(none.error, HasSubstr("the key 'x' does nothing here"));
}

/// The front is +z, or −y.
TEST(Looking, HasTheUprightAxisThatIsChosen) {
  const Folder folder;
  write_sphere(folder, "64");
  const std::string hover = "hover surface 179 218\n";
  const Result result =
      view(folder, "view front\n" + hover + "up z\nview front\n" + hover, {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto picks = result.json()["result"]["picks"];
  EXPECT_GT(picks[0]["pick"]["point"][2].get<double>(), 0.99);
  EXPECT_LT(picks[1]["pick"]["point"][1].get<double>(), -0.99);
}

/// Twice as large in twice the window is the same layout.
TEST(Scale, EnlargesPanelsAndLetters) {
  const Folder folder;
  write_sphere(folder, "64");
  const Result result = marquetry(folder, {"view", "sphere.obj", "--size", "1800x920", "--scale", "2",
                                           "--screenshot", "large.png"});
  ASSERT_EQ(result.status, 0) << result.error;
  const Image<float> large = picture(folder, "large.png");
  // The panel ends where its 300 pixels do, doubled: beyond is the backdrop, which is light.
  EXPECT_LT(large(590, 700, 0), 0.3F);
  EXPECT_GT(large(604, 20, 0), 0.5F);
}

}  // namespace
}  // namespace mq::test
