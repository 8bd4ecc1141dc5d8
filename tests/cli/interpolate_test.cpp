// marquetry interpolate, run as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "cli/moving_pictures.h"
#include "flow/waves.h"
#include "mq/io/flow_file.h"

namespace mq::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(Interpolate, GivesBackBothEndsAndMovesBetween) {
  const Folder folder;
  write_image(folder / "a.png", blobs(60, 50, 0, 0));
  write_image(folder / "b.png", blobs(60, 50, 3, 0));
  const Result result = marquetry(
      folder, {"interpolate", "a.png", "b.png", "-o", "f_%02d.png", "--frames", "0-3", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(read_texture(folder / "f_00.png").pixels, read_texture(folder / "a.png").pixels);
  EXPECT_EQ(read_texture(folder / "f_03.png").pixels, read_texture(folder / "b.png").pixels);
  EXPECT_EQ(result.json()["result"]["times"].size(), 4U);
  const Image<float> second = read_texture(folder / "f_01.png").pixels, truth = blobs(60, 50, 1, 0);
  for (int y = 8; y < 42; ++y)
    for (int x = 8; x < 52; ++x) EXPECT_NEAR(second(x, y), truth(x, y), 0.02);
  ASSERT_EQ(
      marquetry(folder, {"interpolate", "a.png", "b.png", "-o", "t.exr", "-t", "0.25"}).status, 0);
  EXPECT_TRUE(std::filesystem::exists(folder / "t.exr"));
}

/// Texels beside a chart hold the dark ground of the atlas, which lookups at borders mix in.
TEST(Interpolate, BeginsAtTheFirstAlsoAtTheBordersOfCharts) {
  const Folder folder;
  write_strip(folder);
  const auto picture = [](double u) {
    Image<float> image = blobs(64, 48, u, 0);
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < 64; ++x)
        if (x < 3 || (x > 28 && x < 35) || x > 60)
          for (int c = 0; c < 3; ++c) image(x, y, c) = 0;
    return image;
  };
  write_image(folder / "a.exr", picture(0), Depth::f32);
  write_image(folder / "b.exr", picture(1), Depth::f32);
  for (const std::string time : {"0.001", "0.999"}) {
    const Result result = marquetry(
        folder, {"interpolate", "strip.obj", "a.exr", "b.exr", "-o", "t.exr", "-t", time});
    ASSERT_EQ(result.status, 0) << result.error;
    const Image<float> near = read_texture(folder / "t.exr").pixels,
                       end = picture(time == "0.001" ? 0 : 1);
    for (std::size_t i = 0; i < end.values().size(); ++i)
      ASSERT_NEAR(near.values()[i], end.values()[i], 0.01) << i / 3 % 64 << ' ' << i / 3 / 64;
  }
}

TEST(Interpolate, TakesTexturesAndColoursAtVertices) {
  const Folder folder;
  write_strip(folder);
  write_image(folder / "b.png", busy_picture(64, 48));
  ASSERT_EQ(marquetry(folder, {"interpolate", "strip.obj", "strip.png", "b.png", "-o", "same.png"})
                .status,
            0);
  EXPECT_EQ(read_texture(folder / "same.png").pixels, read_texture(folder / "strip.png").pixels);
  // At the ends the pictures come back, also what lies outside all charts, which is mixed between.
  write_image(folder / "c.png", blobs(64, 48, 0, 0));
  for (const std::string time : {"0", "0.5", "1"})
    ASSERT_EQ(marquetry(folder, {"interpolate", "strip.obj", "strip.png", "c.png", "-o",
                                 "t" + time + ".png", "--t", time})
                  .status,
              0);
  const Image<float> one = read_texture(folder / "strip.png").pixels,
                     other_one = read_texture(folder / "c.png").pixels;
  EXPECT_EQ(read_texture(folder / "t0.png").pixels, one);
  EXPECT_EQ(read_texture(folder / "t1.png").pixels, other_one);
  EXPECT_NEAR(read_texture(folder / "t0.5.png").pixels(0, 0), (one(0, 0) + other_one(0, 0)) / 2,
              1.0 / 255);
  write_bytes(folder / "a.ply", coloured_ply);
  std::string other = coloured_ply;
  for (std::size_t at; (at = other.find("100 100 100")) != std::string::npos;)
    other.replace(at, 11, "140 140 140");
  write_bytes(folder / "b.ply", other);
  const Result result = marquetry(folder, {"interpolate", "a.ply", "b.ply", "-o", "mid.ply"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(read_model(folder / "mid.ply").colors.channels, 3);
  const Result flow = marquetry(folder, {"flow", "a.ply", "b.ply", "-o", "out", "--json"});
  ASSERT_EQ(flow.status, 0) << flow.error;
  EXPECT_EQ(flow.json()["input"]["files"], (std::vector<std::string>{"a.ply", "b.ply"}));
  for (const char* name : {"field.vf", "halfway.ply", "error.ply"})
    EXPECT_TRUE(std::filesystem::exists(folder / (std::string("out/") + name))) << name;
}

TEST(Interpolate, MakesVideos) {
  if (std::system("ffmpeg -version > /dev/null 2>&1") != 0) GTEST_SKIP() << "ffmpeg is not here";
  const Folder folder;
  write_strip(folder);
  write_image(folder / "b.png", busy_picture(64, 48));
  const std::vector<std::string> call = {"interpolate", "strip.obj", "strip.png", "b.png",
                                         "--frames",    "0-2",       "-o"};
  for (const std::string output : {"clip.mkv", "f_%d.png"}) {
    std::vector<std::string> words = call;
    words.push_back(output);
    const Result result = marquetry(folder, words);
    ASSERT_EQ(result.status, 0) << result.error;
  }
  // Its frames are the pictures.
  ASSERT_EQ(std::system(("ffmpeg -nostdin -loglevel error -i " + (folder / "clip.mkv").string() +
                         " -start_number 0 " + (folder / "v_%d.png").string())
                            .c_str()),
            0);
  for (const std::string frame : {"0", "1", "2"})
    EXPECT_EQ(as_rgb(read_texture(folder / ("v_" + frame + ".png")).pixels),
              as_rgb(read_texture(folder / ("f_" + frame + ".png")).pixels))
        << frame;
  EXPECT_FALSE(std::filesystem::exists(folder / "v_3.png"));
}

TEST(Interpolate, FollowsAFieldThatIsGiven) {
  const Folder folder;
  write_image(folder / "a.png", blobs(60, 50, 0, 0));
  write_image(folder / "b.png", blobs(60, 50, 4, -2));
  for (const std::string format : {"flo", "png", "exr"}) {
    Image<float> field = constant_field(60, 50, 4, -2);
    field(30, 20, 0) = NAN;
    write_flow(folder / ("f." + format), field);
    const Result result = marquetry(folder, {"interpolate", "a.png", "b.png", "-o", "q.png", "-t",
                                             "0.25", "--flow", "f." + format, "--json"});
    ASSERT_EQ(result.status, 0) << result.error;
    EXPECT_THAT(result.error, Not(HasSubstr("warning")));
    const auto error = result.json()["result"]["error"];
    EXPECT_LT(error[1].get<double>(), 0.3 * error[0].get<double>());
    const Image<float> between = read_texture(folder / "q.png").pixels,
                       truth = blobs(60, 50, 1, -0.5);
    for (int y = 4; y < 46; ++y)
      for (int x = 5; x < 55; ++x) EXPECT_NEAR(between(x, y), truth(x, y), 0.01);
  }
}

TEST(Interpolate, SearchesForFarMotionsUnlessToldNotTo) {
  const Folder folder;
  write_image(folder / "a.png", blobs(60, 50, 0, 0));
  write_image(folder / "b.png", blobs(60, 50, 3, 0));
  const auto run = [&](const std::string& search) {
    return marquetry(folder, {"interpolate", "a.png", "b.png", "-o", search + ".png", "--search", search, "--json"});
  };
  const Result far = run("far"), none = run("none");
  ASSERT_EQ(far.status, 0) << far.error;
  ASSERT_EQ(none.status, 0) << none.error;
  EXPECT_FALSE(far.json()["result"]["torn"].get<bool>());
  EXPECT_LT(far.json()["result"]["unfit"].get<double>(), 0.01);
  EXPECT_EQ(far.json()["result"]["light"], "kept");
  EXPECT_FALSE(far.json()["result"]["unrelated"].get<bool>());
  EXPECT_FALSE(none.json()["result"].contains("unfit"));
  const Result model = marquetry(folder, {"interpolate", "m.obj", "a.png", "b.png", "-o", "c.png", "--search", "none"});
  EXPECT_THAT(model.error, HasSubstr("--search is for pictures"));
}

TEST(Interpolate, SaysThatPicturesShowDifferentThingsOrAreInAnotherLight) {
  const Folder folder;
  const Waves waves(8, 60, 3, 60), fine(3, 9, 9, 60);
  const auto write = [&](const std::string& name, const Signal2& signal) {
    write_image(folder / name, drawn(160, 160, [&](double x, double y) { return std::clamp(signal(x, y), 0.0, 1.0); }));
  };
  write("a.png", [&](double x, double y) { return 0.5 + 0.2 * waves(x, y); });
  write("dark.png", [&](double x, double y) { return 0.2 + 0.08 * waves(x - 5, y); });
  write("other.png", [&](double x, double y) { return 0.5 + 0.3 * std::tanh(4 * fine(x, y)); });
  const Result other = marquetry(folder, {"interpolate", "a.png", "other.png", "-o", "c.png", "--report", "c.json"});
  ASSERT_EQ(other.status, 0) << other.error;
  EXPECT_THAT(other.error, AllOf(HasSubstr("warning: the two seem to show different things"), HasSubstr("--search none")));
  const Result dark = marquetry(folder, {"interpolate", "a.png", "dark.png", "-o", "d.png"});
  ASSERT_EQ(dark.status, 0) << dark.error;
  EXPECT_THAT(dark.error, AllOf(HasSubstr("the light is another in each"), Not(HasSubstr("warning"))));
}

TEST(Interpolate, RefusesOutputsThatDoNotGoWithTheOptions) {
  const Folder folder;
  write_image(folder / "a.png", blobs(20, 20, 0, 0));
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"-o", "f_%04d.png"}, "without --frames there is none"},
      {{"-o", "v.avi", "--frames", "0-4", "--rate", "24"}, ".mp4, .mov, .webm or .mkv"},
      {{"-o", "v.avi", "--rate", "24"}, "--rate is for videos (.mp4, .mov, .webm or .mkv)"},
      {{"-o", "v.mp4", "--frames", "0-4", "--depth", "16"}, "which has 8 bits"}};
  for (const auto& [rest, message] : cases) {
    std::vector<std::string> words = {"interpolate", "a.png", "a.png"};
    words.insert(words.end(), rest.begin(), rest.end());
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 2) << rest[1];
    EXPECT_THAT(result.error, HasSubstr(message));
  }
  const Result flow = marquetry(folder, {"flow", "a.png", "a.png", "-o", "out_%02d"});
  EXPECT_EQ(flow.status, 2);
  EXPECT_THAT(flow.error, HasSubstr("without --frames there is none"));
  EXPECT_EQ(folder.names(), std::vector<std::string>{"a.png"});
}

TEST(Interpolate, MissesTheEncoderBeforeAnyWork) {
  const Folder folder;
  write_image(folder / "a.png", blobs(20, 20, 0, 0));
  for (const bool dry : {false, true}) {
    std::vector<std::string> words = {"interpolate", "a.png",    "a.png", "-o",
                                      "v.mp4",       "--frames", "0-4"};
    if (dry) words.push_back("--dry-run");
    const Result result =
        marquetry(folder, words, {.environment = {{"PATH", folder.path().string()}}});
    EXPECT_EQ(result.status, 2);
    EXPECT_THAT(result.error, HasSubstr("v.mp4: videos are made by the program ffmpeg"));
  }
}

}  // namespace
}  // namespace mq::test
