// Tools that are verbs show what the verb writes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mq/draw/false_colour.h"
#include "viewer/sessions.h"

namespace mq::test {
namespace {

using testing::HasSubstr;

void expect_nearly_equal(const Image<float>& a, const Image<float>& b, double slack) {
  ASSERT_EQ(a.values().size(), b.values().size());
  double largest = 0;
  for (std::size_t k = 0; k < a.values().size(); ++k)
    largest = std::max(largest, std::abs(double(a.values()[k]) - b.values()[k]));
  EXPECT_LE(largest, slack);
}

TEST(GeodesicTool, ShowsTheDistancesThatTheVerbWrites) {
  const Folder folder;
  write_sphere(folder);
  const Result result = view(folder,
                             "view front\ntool geodesic\nset isolines 12\nsource 0,0,1\nwait\n"
                             "screenshot shown.png atlas\nsave-texture verb.png\n"
                             "drag surface 170 210 190 230 200 250\nwait\nhover surface 200 250\n"
                             "copy-command command.txt\n",
                             {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  ASSERT_EQ(view(folder, "screenshot verb_shown.png atlas\n", {"sphere.obj", "verb.png"}).status,
            0);
  // The tool's equations are prepared as the verb's are: the same bits.
  expect_nearly_equal(picture(folder, "shown.png"), picture(folder, "verb_shown.png"), 0);

  // Where the mouse let go, distances begin, in the first colour.
  const auto pick = result.json()["result"]["picks"][0]["pick"];
  const Colour first = distance_colour(0, {});
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(pick["values"][c].get<double>(), first[std::size_t(c)], 0.02);
  EXPECT_THAT(file_bytes(folder / "command.txt"),
              HasSubstr("marquetry geodesic --output=verb.png --from="));
  EXPECT_GT(result.json()["result"]["tool"]["found"]["max"].get<double>(),
            2.9);  // half a great circle
}

TEST(VerbTool, ShowsWhatTheVerbWrites) {
  const Folder folder;
  write_sphere(folder);
  const Result result = view(folder,
                             "tool denoise\nset length 2tx\nset edge 0.1\nwait\n"
                             "screenshot shown.png atlas\ncopy-command command.txt\n"
                             "tool none\nscreenshot none.png atlas\n",
                             {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  const std::string line = file_bytes(folder / "command.txt");
  EXPECT_EQ(line, "marquetry denoise --output=out.png --length=2tx --edge=0.1 sphere.obj\n");
  ASSERT_EQ(
      marquetry(folder, {"denoise", "--output=out.png", "--length=2tx", "--edge=0.1", "sphere.obj"})
          .status,
      0);
  ASSERT_EQ(view(folder, "screenshot verb.png atlas\n", {"sphere.obj", "out.png"}).status, 0);
  ASSERT_EQ(view(folder, "screenshot plain.png atlas\n", {"sphere.obj"}).status, 0);
  expect_nearly_equal(picture(folder, "shown.png"), picture(folder, "verb.png"), 0);
  expect_nearly_equal(picture(folder, "none.png"), picture(folder, "plain.png"), 0);
}

TEST(CombTool, DrawsLinesAlongTheStrokesOfTheMouse) {
  const Folder folder;
  write_sphere(folder, "128");
  const Result result = view(folder,
                             "view front\ntool lic\ndrag surface 120 220 180 215 240 220\nhover surface 5 5\nwait\n"
                             "screenshot one.png atlas\ndrag surface 170 120 180 330\nhover surface 5 5\nwait\n"
                             "screenshot two.png atlas\nundo\nwait\nscreenshot again.png atlas\nredo\nwait\n"
                             "screenshot shown.png atlas\nsave-strokes combed.json\ncopy-command command.txt\n",
                             {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["tool"]["strokes"], 2);
  expect_nearly_equal(picture(folder, "one.png"), picture(folder, "again.png"), 0);
  expect_nearly_equal(picture(folder, "two.png"), picture(folder, "shown.png"), 0);
  EXPECT_FALSE(picture(folder, "one.png") == picture(folder, "two.png"));
  EXPECT_EQ(file_bytes(folder / "command.txt"),
            "marquetry lic --output=out.png --field=combed.json --by=paths sphere.obj\n");
  ASSERT_EQ(marquetry(folder, {"lic", "--output=out.png", "--field=combed.json", "--by=paths", "sphere.obj"}).status, 0);
  ASSERT_EQ(view(folder, "screenshot verb.png atlas\n", {"sphere.obj", "out.png"}).status, 0);
  expect_nearly_equal(picture(folder, "shown.png"), picture(folder, "verb.png"), 0);

  const Result unsaved = view(folder, "tool lic\ndrag surface 120 220 240 220\nwait\ncopy-command c.txt\n", {"sphere.obj"});
  EXPECT_EQ(unsaved.status, 2);
  EXPECT_THAT(unsaved.error, HasSubstr("save them first"));
}

TEST(InterpolateTool, ShowsTheMomentsThatTheVerbWrites) {
  const Folder folder;
  write_sphere(folder, "128");
  ASSERT_EQ(marquetry(folder, {"filter", "sphere.obj", "--beta", "0", "--length", "3tx", "-o",
                               "smooth.png"})
                .status,
            0);
  const Result result =
      view(folder,
           "tool interpolate\nwith smooth.png\nset time 0\nwait\nscreenshot first.png atlas\n"
           "set time 0.4\nwait\nscreenshot shown.png atlas\ncopy-command command.txt\n"
           "set time 1\nwait\nscreenshot second.png atlas\n",
           {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["tool"]["between_seconds"].size(), 4U);  // once at the default
  EXPECT_THAT(file_bytes(folder / "command.txt"),
              HasSubstr("marquetry interpolate --output=out.png"));
  ASSERT_EQ(marquetry(folder, {"interpolate", "sphere.obj", "sphere.png", "smooth.png", "--time",
                               "0.4", "-o", "between.png"})
                .status,
            0);
  const auto shown_alone = [&](const std::string& texture) {
    EXPECT_EQ(view(folder, "screenshot alone.png atlas\n", {"sphere.obj", texture}).status, 0);
    return picture(folder, "alone.png");
  };
  expect_nearly_equal(picture(folder, "first.png"), shown_alone("sphere.png"), 0);
  expect_nearly_equal(picture(folder, "shown.png"), shown_alone("between.png"), 0);
  expect_nearly_equal(picture(folder, "second.png"), shown_alone("smooth.png"), 0);
}

/// Two photographs of the sphere, everywhere: as it is, and brighter, which shows it less well.
void write_photographs(const Folder& folder) {
  const Image<float> colours = picture(folder, "sphere.png");
  Image<float> best(colours.width(), colours.height(), 4, 1.0F), bright = best;
  for (int y = 0; y < colours.height(); ++y)
    for (int x = 0; x < colours.width(); ++x) {
      for (int c = 0; c < 3; ++c) {
        best(x, y, c) = 0.8F * colours(x, y, c);
        bright(x, y, c) = best(x, y, c) + 0.15F;
      }
      bright(x, y, 3) = 0.5F;
    }
  write_image(folder / "best.png", best);
  write_image(folder / "bright.png", bright);
}

TEST(StitchTool, SaysThatAStrokeGivesNothing) {
  const Folder folder;
  write_sphere(folder, "64");
  write_photographs(folder);
  const std::string photographs = "tool stitch\nset partial best.png bright.png\nwait\nphotograph 1\nsize 10%\n";
  const Result away = view(folder, photographs + "stroke 9,9,9\n", {"sphere.obj"});
  ASSERT_EQ(away.status, 0) << away.error;
  EXPECT_THAT(away.error, HasSubstr("the stroke touches nothing of the model that has a texture"));
  const Result twice = view(folder, photographs + "stroke 0,0,1\nstroke 0,0,1\n", {"sphere.obj"});
  EXPECT_THAT(twice.error, HasSubstr("the stroke changes nothing: what it touches is so already"));
}

TEST(StitchTool, GivesRegionsToPhotographsAndTakesTheirBordersOut) {
  const Folder folder;
  write_sphere(folder, "128");
  write_photographs(folder);
  const Result result = view(folder,
                             "tool stitch\nset partial best.png bright.png\nwait\n"
                             "screenshot none.png atlas\n"
                             "photograph 1\nsize 40%\nstroke 0,0,1 0.5,0,0.86\n"
                             "region chart\nstroke -1,0,0\nwait\nscreenshot stitched.png atlas\n"
                             "stage 0\nscreenshot chosen.png atlas\nstage last\n"
                             "save-labels labels.png\nsave-texture saved.png\n"
                             "copy-command command.txt\n"
                             "undo\nundo\nwait\nscreenshot undone.png atlas\n"
                             "redo\nredo\nwait\nscreenshot redone.png atlas\n",
                             {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto tool = result.json()["result"]["tool"];
  EXPECT_EQ(tool["prepared"], 1);
  EXPECT_EQ(file_bytes(folder / "command.txt"),
            "marquetry stitch --output=saved.png --labels=labels.png --partial=best.png "
            "--partial=bright.png sphere.obj\n");
  const Result verb =
      marquetry(folder, {"stitch", "sphere.obj", "-o", "out.png", "--labels", "labels.png",
                         "--partial", "best.png", "--partial", "bright.png", "--json"});
  ASSERT_EQ(verb.status, 0) << verb.error;
  EXPECT_EQ(verb.json()["result"]["regions"], 2);
  // They differ by a constant. Charts lie on the left, with a seventh of it between them.
  const Image<float> best = picture(folder, "best.png"), stitched = picture(folder, "out.png"),
                     labels = picture(folder, "labels.png");
  std::vector<float> offsets, steps;
  int chosen = 0;
  for (int y = 0; y < best.height(); ++y)
    for (int x = 0; x < best.width() * 5 / 8; ++x) {
      offsets.push_back(stitched(x, y, 1) - best(x, y, 1));
      chosen += labels(x, y, 1) == 1;
      if (x > 0 && labels(x, y, 0) != labels(x - 1, y, 0))
        steps.push_back(std::abs(offsets.back() - (stitched(x - 1, y, 1) - best(x - 1, y, 1))));
      if (labels(x, y, 1) == 1) {
        EXPECT_EQ(labels(x, y, 0), 1.0F / 255);
      }
    }
  EXPECT_GT(chosen, std::ssize(offsets) / 10);
  EXPECT_LT(chosen, std::ssize(offsets) * 9 / 10);
  std::ranges::sort(offsets);
  const float middle = offsets[offsets.size() / 2];
  EXPECT_GT(middle, 0.01F);
  EXPECT_LT(middle, 0.14F);
  ASSERT_GT(steps.size(), 20U) << "where the photograph changes within a row";
  std::ranges::sort(steps);
  EXPECT_LT(steps[steps.size() / 2], 0.05F) << "of a step of 0.15; gains change contrasts too";
  ASSERT_EQ(view(folder, "screenshot verb.png atlas\n", {"sphere.obj", "out.png"}).status, 0);
  expect_nearly_equal(picture(folder, "stitched.png"), picture(folder, "verb.png"), 0);
  expect_nearly_equal(picture(folder, "redone.png"), picture(folder, "verb.png"), 0);
  EXPECT_TRUE(file_bytes(folder / "saved.png") == file_bytes(folder / "out.png"));

  // Nothing chosen: the best alone, as it is.
  expect_nearly_equal(picture(folder, "undone.png"), picture(folder, "none.png"), 0);
  EXPECT_FALSE(file_bytes(folder / "chosen.png") == file_bytes(folder / "none.png"));
  EXPECT_FALSE(file_bytes(folder / "chosen.png") == file_bytes(folder / "stitched.png"));
}

/// Of photographs with cameras: what the verb makes of them, by itself and with labels that were painted.
TEST(StitchTool, PaintsWhichPhotographTheVerbTextureTakes) {
  const Folder folder;
  write_sphere(folder, "128");
  std::string cameras;
  std::vector<std::string> words = {"texture", "sphere.obj", "-o", "verb.png"};
  for (const std::string view : {"0,10", "50,20", "100,0", "180,0", "-90,10"}) {
    const std::string name = "from" + view.substr(0, view.find(','));
    ASSERT_EQ(marquetry(folder, {"render", "sphere.obj", "-o", name + ".png", "--cameras", name + ".json", "--view=" + view,
                                 "--size", "300", "--unlit"})
                  .status,
              0);
    cameras += " " + name + ".json";
    words.insert(words.end(), {"--cameras", name + ".json"});
  }
  const Result result = view(folder,
                             "tool texture\nset cameras" + cameras + "\nwait\nscreenshot made.png atlas\n"
                             "photograph 1\nsize 40%\nstroke 0,0,1 0.5,0,0.86\nwait\n"
                             "screenshot painted.png atlas\nsave-labels labels.png\n",
                             {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  ASSERT_EQ(marquetry(folder, words).status, 0);
  ASSERT_EQ(view(folder, "screenshot of_verb.png atlas\n", {"sphere.obj", "verb.png"}).status, 0);
  expect_nearly_equal(picture(folder, "made.png"), picture(folder, "of_verb.png"), 0);
  words[3] = "labelled.png";
  words.insert(words.end(), {"--labels", "labels.png"});
  ASSERT_EQ(marquetry(folder, words).status, 0);
  ASSERT_EQ(view(folder, "screenshot of_labels.png atlas\n", {"sphere.obj", "labelled.png"}).status, 0);
  expect_nearly_equal(picture(folder, "painted.png"), picture(folder, "of_labels.png"), 0);
  EXPECT_FALSE(file_bytes(folder / "labelled.png") == file_bytes(folder / "verb.png"));

  // The mean of all, and one of them in place of it.
  const Result means = view(folder,
                            "tool texture\nset cameras" + cameras + "\nset blend mean\nwait\n"
                            "screenshot mean.png atlas\nphotograph 1\nsize 40%\nstroke 0,0,1 0.5,0,0.86\nwait\n"
                            "screenshot in_mean.png atlas\nsave-labels in_mean_labels.png\n",
                            {"sphere.obj"});
  ASSERT_EQ(means.status, 0) << means.error;
  words[3] = "in_mean_verb.png", words.back() = "in_mean_labels.png";
  words.insert(words.end(), {"--blend", "mean"});
  ASSERT_EQ(marquetry(folder, words).status, 0);
  ASSERT_EQ(view(folder, "screenshot in_mean_of_verb.png atlas\n", {"sphere.obj", "in_mean_verb.png"}).status, 0);
  expect_nearly_equal(picture(folder, "in_mean.png"), picture(folder, "in_mean_of_verb.png"), 0);
  EXPECT_FALSE(file_bytes(folder / "mean.png") == file_bytes(folder / "in_mean.png"));
}

TEST(StitchTool, SaysWhatItWants) {
  const Folder folder;
  write_sphere(folder, "64");
  write_photographs(folder);
  const auto refused = [&](const std::string& script) {
    const Result result = view(folder, "tool stitch\n" + script, {"sphere.obj"});
    EXPECT_EQ(result.status, 2) << script;
    return result.error;
  };
  const std::string photographs = "set partial best.png bright.png\n";
  EXPECT_THAT(refused("photograph 0\n"), HasSubstr("line 2: stitch chooses between photographs"));
  EXPECT_THAT(refused(photographs + "photograph 2\n"),
              HasSubstr("line 3: found '2', wanted best or a number from 0 to 1"));
  EXPECT_THAT(refused(photographs + "photograph 1\nstroke 0,0,1\ncopy-command a.txt\n"),
              HasSubstr("line 5: the command names the file of the choice"));
  EXPECT_THAT(refused(photographs + "save-labels labels.jpg\n"),
              HasSubstr("labels.jpg: a choice of photographs wants no loss"));
  EXPECT_THAT(refused(photographs + "save-labels best.png\n"), HasSubstr("would replace it"));
}

TEST(StitchTool, ForgetsWhatWasChosenOfOtherPhotographs) {
  const Folder folder;
  write_sphere(folder, "64");
  write_photographs(folder);
  const Result result = view(folder,
                             "tool stitch\nset partial best.png bright.png\nwait\nphotograph 1\n"
                             "stroke 0,0,1\nwait\nundo\nset partial best.png\nwait\nredo\n"
                             "stroke 0,0,1\nwait\nsave-labels labels.png\n",
                             {"sphere.obj"});
  EXPECT_EQ(result.status, 0) << result.error;
  // What is not saved is not given up for others, nor for other labels.
  for (const char* change : {"set partial best.png", "set labels \"\""}) {
    const Result lost = view(folder,
                             std::string("tool stitch\nset partial best.png bright.png\n"
                                         "set labels labels.png\nwait\nphotograph 1\n"
                                         "stroke 0,0,1\n") +
                                 change + "\n",
                             {"sphere.obj"});
    EXPECT_EQ(lost.status, 2) << change;
    EXPECT_THAT(lost.error, HasSubstr("line 7: what was chosen would be lost")) << change;
  }
}

TEST(StitchTool, TakesOtherLabelsAndNone) {
  const Folder folder;
  write_sphere(folder, "64");
  write_photographs(folder);
  const Result result = view(folder,
                             "tool stitch\nset partial best.png bright.png\nwait\n"
                             "screenshot none.png atlas\nphotograph 1\nsize 40%\nstroke 0,0,1\n"
                             "save-labels labels.png\nwait\nscreenshot chosen.png atlas\n"
                             "set labels \"\"\nwait\nscreenshot emptied.png atlas\n"
                             "save-texture emptied_texture.png\ncopy-command emptied.txt\n"
                             "set labels labels.png\nwait\nscreenshot read.png atlas\n"
                             "copy-command read.txt\n",
                             {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_TRUE(file_bytes(folder / "emptied.png") == file_bytes(folder / "none.png"));
  EXPECT_FALSE(file_bytes(folder / "chosen.png") == file_bytes(folder / "none.png"));
  expect_nearly_equal(picture(folder, "read.png"), picture(folder, "chosen.png"), 0);
  const std::string photographs = "--partial=best.png --partial=bright.png sphere.obj\n";
  EXPECT_EQ(file_bytes(folder / "emptied.txt"),
            "marquetry stitch --output=emptied_texture.png " + photographs);
  EXPECT_EQ(file_bytes(folder / "read.txt"),
            "marquetry stitch --output=emptied_texture.png --labels=labels.png " + photographs);
  ASSERT_EQ(marquetry(folder, {"stitch", "sphere.obj", "-o", "verb.png", "--partial", "best.png",
                               "--partial", "bright.png"})
                .status,
            0);
  EXPECT_TRUE(file_bytes(folder / "emptied_texture.png") == file_bytes(folder / "verb.png"));
}

TEST(VerbTool, DoesNotReplaceWhatWasOpenedLater) {
  const Folder folder;
  write_sphere(folder, "64");
  ASSERT_EQ(marquetry(folder, {"sample", "cube", "--size", "64", "-o", "cube/"}).status, 0);
  const Result result = view(folder,
                             "open cube/cube.obj\nwait\ntool filter\nfill everywhere\n"
                             "save-texture cube/cube.png\n",
                             {"sphere.obj"});
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.error, HasSubstr("would replace it"));
}

TEST(InterpolateTool, SaysWhichPicturesItWants) {
  const Folder folder;
  write_sphere(folder, "64");
  const Result result = view(folder, "tool interpolate\nwith a.png b.png\n", {"sphere.obj"});
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.error, HasSubstr("wanted one for each of the 1 textures"));
}

TEST(ShockTool, ShowsTheTimesOnTheWayAndAnyOtherAtOnce) {
  const Folder folder;
  write_sphere(folder, "128");
  const Result result =
      view(folder,
           "tool shock\nset time 4\nset smooth 0.5%\nwait\nscreenshot last.png atlas\n"
           "stage 2\nscreenshot early.png atlas\nsave-texture early_saved.png\nstage last\n"
           "screenshot last_again.png atlas\n"
           "set time 1.5\nwait\nscreenshot other.png atlas\n"
           "save-texture saved.png\n"
           "set time 2\nwait\nscreenshot kept.png atlas\n"
           "stage 0\nset time 4\nwait\nscreenshot kept_last.png atlas\n",
           {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto at_time = [&](const std::string& time) {
    EXPECT_EQ(marquetry(folder, {"shock", "sphere.obj", "--time", time, "--smooth", "0.5%", "-o",
                                 time + ".png"})
                  .status,
              0);
    EXPECT_EQ(view(folder, "screenshot alone.png atlas\n", {"sphere.obj", time + ".png"}).status,
              0);
    return picture(folder, "alone.png");
  };
  expect_nearly_equal(picture(folder, "last.png"), at_time("4"), 0);
  expect_nearly_equal(picture(folder, "last_again.png"), picture(folder, "last.png"), 0);
  expect_nearly_equal(picture(folder, "early.png"), at_time("1"), 0);
  expect_nearly_equal(picture(folder, "other.png"), at_time("1.5"), 0);
  EXPECT_TRUE(file_bytes(folder / "early_saved.png") == file_bytes(folder / "1.png"));
  EXPECT_TRUE(file_bytes(folder / "saved.png") == file_bytes(folder / "1.5.png"));
  const auto tool = result.json()["result"]["tool"];
  // In the order of times, whatever their own; what was seen once is not worked out again.
  EXPECT_EQ(tool["stages"],
            nlohmann::json({"time 0.25", "time 0.5", "time 1", "time 1.5", "time 2", "time 4"}));
  expect_nearly_equal(picture(folder, "kept_last.png"), picture(folder, "last.png"), 0);
  EXPECT_FALSE(file_bytes(folder / "kept.png") == file_bytes(folder / "last.png"));
  // Five times where paths are new, with the default smoothing and for 0.5 %; else one, for 1.5, its file
  // and that of 1.
  EXPECT_EQ(tool["path_seconds"].size(), 13U);
  EXPECT_EQ(tool["prepared"], 2);
}

TEST(LicTool, ShowsLinesForming) {
  const Folder folder;
  write_sphere(folder, "128");
  const Result result = view(folder,
                             "tool lic\nset field gradient\nwait\nscreenshot last.png atlas\n"
                             "stage 0\nscreenshot noise.png atlas\nstage 3\n"
                             "screenshot forming.png atlas\ncopy-command command.txt\n",
                             {"sphere.obj"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["tool"]["stages"],
            nlohmann::json({"noise", "step 1", "step 2", "step 4", "step 8", "step 16", "step 32",
                            "step 64", "result"}));
  ASSERT_EQ(
      marquetry(folder, {"lic", "sphere.obj", "--field", "gradient", "-o", "verb.png"}).status, 0);
  ASSERT_EQ(view(folder, "screenshot verb_shown.png atlas\n", {"sphere.obj", "verb.png"}).status,
            0);
  expect_nearly_equal(picture(folder, "last.png"), picture(folder, "verb_shown.png"), 0);
  EXPECT_FALSE(file_bytes(folder / "noise.png") == file_bytes(folder / "forming.png"));
  EXPECT_FALSE(file_bytes(folder / "forming.png") == file_bytes(folder / "last.png"));
}

TEST(VerbTool, SaysWhatTheVerbSays) {
  const Folder folder;
  write_strip(folder);
  const Result result = view(folder, "tool shock\nset steps -1\n", {"strip.obj"});
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.error, HasSubstr("session.txt, line 2: --steps: found '-1'"));
}

}  // namespace
}  // namespace mq::test
