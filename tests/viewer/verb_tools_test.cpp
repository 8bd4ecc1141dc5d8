// Tools that are verbs show what the verb writes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mq/image/false_colour.h"
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
              HasSubstr("marquetry geodesic --output=out.png --from="));
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

TEST(InterpolateTool, SaysWhichPicturesItWants) {
  const Folder folder;
  write_sphere(folder, "64");
  const Result result = view(folder, "tool interpolate\nwith a.png b.png\n", {"sphere.obj"});
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.error, HasSubstr("wanted one for each of the 1 textures"));
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
