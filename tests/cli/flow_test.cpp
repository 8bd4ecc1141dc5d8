// marquetry flow, run as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cli/moving_pictures.h"
#include "mq/io/flow_file.h"

namespace mq::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

void expect_moved(const Image<float>& field, float u, float v, float tolerance) {
  for (int y = 10; y < field.height() - 10; ++y)
    for (int x = 10; x < field.width() - 10; ++x) {
      EXPECT_NEAR(std::hypot(field(x, y, 0) - u, field(x, y, 1) - v), 0, tolerance) << x << ' ' << y;
    }
}

TEST(Flow, FindsHowPicturesMove) {
  const Folder folder;
  write_image(folder / "a.png", blobs(70, 60, 0, 0), Depth::u16);
  write_image(folder / "b.png", blobs(70, 60, 2, -1), Depth::u16);
  for (const std::string format : {"flo", "png", "exr"}) {
    const Result result =
        marquetry(folder, {"flow", "a.png", "b.png", "-o", "out", "--format", format, "--json"});
    ASSERT_EQ(result.status, 0) << result.error;
    expect_moved(read_flow(folder / ("out/field." + format)), 2, -1, 0.1F);
    const auto error = result.json()["result"]["error"].get<std::vector<double>>();
    ASSERT_EQ(error.size(), result.json()["result"]["levels"].size() + 1);
    for (std::size_t i = 1; i < error.size(); ++i) EXPECT_LE(error[i], error[i - 1]);
    EXPECT_LT(error.back(), 0.1 * error.front());
  }
  for (const char* name : {"colours.png", "error.png", "blend.png", "halfway.png"})
    EXPECT_GE(read_texture(folder / (std::string("out/") + name)).pixels.width(), 70) << name;
  EXPECT_THAT(file_bytes(folder / "out/report.json"), HasSubstr("\"error\""));
  // The report repeats the run.
  const std::string before = file_bytes(folder / "out/field.flo");
  const Result again = marquetry(folder, {"flow", "a.png", "b.png", "-o", "again", "--config",
                                          "out/report.json", "--format", "flo"});
  ASSERT_EQ(again.status, 0) << again.error;
  EXPECT_EQ(file_bytes(folder / "again/field.flo"), before);
}

/// What no PNG holds: values far beyond white, or more than four channels.
TEST(Flow, MixesInFloatingPointWhatPngDoesNotHold) {
  const Folder folder;
  const auto bright = [](double u) {
    Image<float> image = blobs(40, 40, u, 0);
    for (float& value : image.values()) value *= 6e4F;
    return image;
  };
  const auto five = [](double u) {
    const Image<float> colour = blobs(40, 40, u, 0);
    Image<float> image(40, 40, 5, 1);
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 40; ++x) {
        for (int c = 0; c < 3; ++c) image(x, y, c) = colour(x, y, c);
        image(x, y, 4) = 10 + colour(x, y);
      }
    return image;
  };
  const auto picture = [&](const std::string& name, double u) {
    return name == "bright.exr" ? bright(u) : five(u);
  };
  const std::vector<std::pair<std::string, Depth>> cases = {
      {"bright.exr", Depth::f32}, {"five.exr", Depth::f32}, {"five.tif", Depth::u16}};
  for (const auto& [name, depth] : cases) {
    SCOPED_TRACE(name);
    std::vector<Image<float>> both;
    for (const int i : {0, 1}) {
      Image<float> pixels = picture(name, i);
      if (depth == Depth::u16)
        for (float& value : pixels.values()) value /= 12;
      write_image(folder / (std::to_string(i) + name), pixels, depth);
      both.push_back(read_texture(folder / (std::to_string(i) + name)).pixels);
    }
    const std::string out = depth == Depth::u16 ? "words" : name.substr(0, name.find('.'));
    const Result result = marquetry(folder, {"flow", "0" + name, "1" + name, "-o", out});
    ASSERT_EQ(result.status, 0) << result.error;
    EXPECT_FALSE(std::filesystem::exists(folder / (out + "/blend.png")));
    EXPECT_TRUE(std::filesystem::exists(folder / (out + "/halfway.exr")));
    const Image<float> blend = read_texture(folder / (out + "/blend.exr")).pixels;
    ASSERT_EQ(blend.channels(), both[0].channels());
    for (std::size_t i = 0; i < blend.values().size(); ++i) {
      const float mean = (both[0].values()[i] + both[1].values()[i]) / 2;
      EXPECT_NEAR(blend.values()[i], mean, 1e-5 * std::abs(mean));
    }
  }
}

TEST(Flow, KnowsTheOtherWays) {
  const Folder folder;
  write_image(folder / "a.png", blobs(64, 64, 0, 0, 4), Depth::u16);
  write_image(folder / "b.png", blobs(64, 64, 1, 1, 4), Depth::u16);
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"--alignment", "forward"},
                                             {"--scales", "single"},
                                             {"--scales", "full", "--largest", "6tx"},
                                             {"--preset", "thesis", "--steps", "2"},
                                             {"--robust-data", "0.5", "--robust-smoothness", "0.3"},
                                             {"--gradients", "2", "--paths", "straight", "--search", "none"},
                                             {"--space", "linear", "--detail", "10tx"}}) {
    std::vector<std::string> all = {"flow", "a.png", "b.png", "-o", "out", "--json"};
    all.insert(all.end(), words.begin(), words.end());
    const Result result = marquetry(folder, all);
    ASSERT_EQ(result.status, 0) << words[1] << result.error;
    const auto error = result.json()["result"]["error"];
    EXPECT_LT(error.back().get<double>(), 0.5 * error.front().get<double>()) << words[1];
  }
}

TEST(Flow, FindsHowTexturesMoveOverTheirSeam) {
  const Folder folder;
  write_strip(folder);
  write_image(folder / "a.png", wave_over_strip(0));
  write_image(folder / "b.png", wave_over_strip(2));
  const Result result =
      marquetry(folder, {"flow", "strip.obj", "a.png", "b.png", "-o", "out", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto error = result.json()["result"]["error"].get<std::vector<double>>();
  for (std::size_t i = 1; i < error.size(); ++i) EXPECT_LE(error[i], error[i - 1]);
  EXPECT_LT(error.back(), 0.1 * error.front());
  EXPECT_FALSE(result.json()["result"].contains("longest_edge"));
  for (const char* name : {"field.vf", "report.json", "halfway/a.png", "error/a.png"})
    EXPECT_TRUE(std::filesystem::exists(folder / (std::string("out/") + name))) << name;
  const Image<float> halfway = read_texture(folder / "out/halfway/a.png").pixels,
                     truth = wave_over_strip(1);
  double moved = 0, blend = 0;
  const Image<float> first = wave_over_strip(0), second = wave_over_strip(2);
  for (int y = 10; y < 38; ++y)
    for (const int x : {8, 14, 20, 26, 27, 28, 36, 37, 40, 46, 52})
      for (int c = 0; c < 3; ++c) {
        moved += std::pow(halfway(x, y, c) - truth(x, y, c), 2);
        blend += std::pow(0.5 * (first(x, y, c) + second(x, y, c)) - truth(x, y, c), 2);
      }
  EXPECT_LT(moved, 0.5 * blend);
  // The two sides of the seam are moved alike.
  for (int y = 10; y < 38; ++y)
    EXPECT_NEAR(halfway(28, y) - truth(28, y), halfway(35, y) - truth(35, y), 0.03) << y;
}

TEST(Flow, CutsTrianglesForTheirBases) {
  const Folder folder;
  write_strip(folder);
  for (const int n : {0, 2}) write_image(folder / (std::to_string(n) + ".png"), wave_over_strip(n));
  const Result result = marquetry(folder, {"flow", "strip.obj", "0.png", "2.png", "-o", "out", "--json", "--basis", "vertex"});
  EXPECT_EQ(result.json()["result"]["longest_edge"], 2);
}

TEST(Flow, TakesLengthsInTexels) {
  const Folder folder;
  write_strip(folder);
  write_image(folder / "a.png", wave_over_strip(0));
  write_image(folder / "b.png", wave_over_strip(1));
  const auto largest = [&](const std::string& length) {
    const Result result = marquetry(folder, {"flow", "strip.obj", "a.png", "b.png", "-o", "out",
                                             "--largest", length, "--smallest", "4tx", "--json"});
    EXPECT_EQ(result.status, 0) << result.error;
    return result.json()["result"]["levels"][0]["length"].get<double>();
  };
  const double of_eight = largest("8tx");
  EXPECT_GT(of_eight, 0);
  EXPECT_NEAR(largest("16tx"), 2 * of_eight, 1e-9 * of_eight);
  EXPECT_NEAR(largest(std::to_string(of_eight)), of_eight, 1e-4 * of_eight);
}

/// A wave, moved by a texel, under a pattern of single texels that is another each time.
TEST(Flow, DoesNotTakeWhatIsFinerThanItsTrianglesForWaves) {
  const Folder folder;
  write_strip(folder);
  for (const int second : {0, 1}) {
    Image<float> image(64, 48, 1);
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < 64; ++x) {
        const double along = x < 32 ? x : x - 6.4;
        image(x, y) = float(0.5 + 0.2 * std::sin(0.25 * (along - second)) * std::cos(0.2 * y) +
                            0.1 * ((x + y + second) % 2 == 0 ? 1 : -1));
      }
    write_image(folder / (second ? "b.png" : "a.png"), image);
  }
  const Result result = marquetry(folder, {"flow", "strip.obj", "a.png", "b.png", "-o", "out",
                                           "--longest-edge", "6", "--detail", "0", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto error = result.json()["result"]["error"].get<std::vector<double>>();
  EXPECT_LT(error.front(), 0.2);
  EXPECT_LT(error.back(), 0.2 * error.front());
}

TEST(Flow, KnowsTheOtherWaysOnModels) {
  const Folder folder;
  write_strip(folder);
  const Image<float> first = read_texture(folder / "strip.png").pixels;
  Image<float> second = first;
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 63; ++x)
      for (int c = 0; c < first.channels(); ++c) second(x, y, c) = first(x + 1, y, c);
  write_image(folder / "b.png", second);
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"--basis", "triangle"},
                                             {"--basis", "whitney"},
                                             {"--alignment", "forward"},
                                             {"--scales", "full"},
                                             {"--gradients", "1"},
                                             {"--robust-data", "0.5", "--robust-smoothness", "0.3"},
                                             {"--detail", "10%", "--space", "linear"},
                                             {"--preset", "thesis", "--smallest", "7%"},
                                             {"--preset", "thesis", "--basis", "triangle"}}) {
    std::vector<std::string> all = {"flow", "strip.obj", "strip.png", "b.png", "-o", "out", "--json"};
    all.insert(all.end(), words.begin(), words.end());
    const Result result = marquetry(folder, all);
    ASSERT_EQ(result.status, 0) << words[1] << result.error;
    const auto error = result.json()["result"]["error"];
    EXPECT_LT(error.back().get<double>(), error.front().get<double>()) << words[1];
    if (words[1] == "thesis") EXPECT_EQ(error.size(), words[2] == "--smallest" ? 2U : 8U) << "one level, and seven";
  }
}

TEST(Flow, SaysWhatItCannotAlign) {
  const Folder folder;
  write_strip(folder);
  write_image(folder / "a.png", blobs(20, 20, 0, 0));
  write_image(folder / "b.png", blobs(21, 20, 0, 0));
  write_image(folder / "g.png", blobs(20, 20, 0, 0, 1));
  write_bytes(folder / "a.ply", coloured_ply);
  std::string floats = coloured_ply;
  for (const char* colour : {"uchar red", "uchar green", "uchar blue"})
    floats.replace(floats.find(colour), 5, "float");
  floats.replace(floats.find("100 100 100"), 3, "nan");
  write_bytes(folder / "nan.ply", floats);
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"flow", "a.png", "-o", "out"}, "nothing to align it with"},
      {{"flow", "a.png", "b.png", "-o", "out"}, "21 x 20"},
      {{"flow", "a.png", "g.png", "-o", "out"}, "1 channel"},
      {{"flow", "a.png", "a.png", "g.png", "-o", "out"}, "one more is read"},
      {{"flow", "a.png", "none.png", "-o", "out"}, "none.png"},
      {{"flow", "a.png", "a.png", "-o", "out.png"}, "wanted a folder"},
      {{"flow", "a.png", "a.png", "-o", "out", "--basis", "whitney"}, "--basis is for models"},
      {{"flow", "a.png", "a.png", "-o", "out", "--smallest", "0"}, "smallest length"},
      {{"flow", "a.png", "a.png", "-o", "out", "--largest", "2tx", "--smallest", "5tx"},
       "above the largest scale, 2 pixels"},
      {{"flow", "a.png", "a.png", "-o", "out", "--smallest", "50%", "--dry-run"}, "is above"},
      {{"interpolate", "a.png", "a.png", "-o", "x.png", "--smallest", "50%"}, "is above"},
      {{"flow", "a.ply", "a.ply", "-o", "out", "--light", "matched"}, "--light is for pictures"},
      {{"flow", "strip.obj", "a.png", "-o", "out"}, "come in pairs"},
      {{"flow", "strip.obj", "strip.png", "a.png", "-o", "out"}, "20 x 20"},
      {{"flow", "strip.obj", "strip.png", "strip.png", "-o", "out", "--paths", "straight"},
       "--paths"},
      {{"flow", "strip.obj", "a.ply", "-o", "out"}, "no colours"},
      {{"flow", "a.ply", "nan.ply", "-o", "out"}, "nan.ply: a colour of vertex 1"},
      {{"flow", "a.ply", "a.ply", "-o", "out", "--largest", "2%", "--smallest", "5%"}, "is above"},
      {{"flow", "a.ply", "a.ply", "-o", "out", "--space", "log"}, "--space is for textures"},
      {{"flow", "a.ply", "a.ply", "-o", "out", "--longest-edge", "8"},
       "--longest-edge is for textures"},
      {{"flow", "a.ply", "a.ply", "-o", "out", "--largest", "8tx", "--dry-run"}, "found '8tx'"},
      {{"interpolate", "a.png", "a.png", "-o", "x.png", "--frames", "0-3"}, "%04d"},
      {{"interpolate", "a.png", "a.png", "-o", "x.obj"}, "wanted a picture"},
      {{"interpolate", "a.png", "a.png", "-o", "x.mp4"}, "how many frames"},
      {{"interpolate", "a.png", "a.png", "-o", "x.png", "--rate", "24"}, "--rate is for videos"},
      {{"interpolate", "a.ply", "a.ply", "-o", "x.mp4", "--frames", "0-3"}, "a video shows one"},
      {{"interpolate", "a.png", "a.png", "-o", "x.png", "--time", "2"}, "--time"}};
  for (const auto& [words, message] : cases) {
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 2) << words[1] << ' ' << words[2];
    EXPECT_THAT(result.error, HasSubstr(message));
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "out/field.flo"));
  EXPECT_EQ(marquetry(folder, {"flow", "a.png", "a.png", "-o", "dry", "--dry-run"}).status, 0);
  EXPECT_FALSE(std::filesystem::exists(folder / "dry"));
}

TEST(Flow, WarnsWhereNothingCanBeAligned) {
  const Folder folder;
  write_strip(folder);
  write_image(folder / "a.png", blobs(20, 20, 0, 0));
  write_image(folder / "grey.png", Image<float>(20, 20, 3, 0.5F));
  write_bytes(folder / "a.ply", coloured_ply);
  std::string even = coloured_ply;
  even.replace(even.find("200 200 200"), 11, "100 100 100");
  write_bytes(folder / "even.ply", even);
  const auto says = [&](const std::vector<std::string>& words) {
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 0) << result.error;
    return result.error;
  };
  EXPECT_THAT(says({"flow", "a.png", "grey.png", "-o", "out"}),
              HasSubstr("the second signal is of one colour"));
  EXPECT_THAT(says({"flow", "grey.png", "a.png", "-o", "out"}),
              HasSubstr("the first signal is of one colour"));
  EXPECT_THAT(says({"flow", "a.ply", "even.ply", "-o", "out"}),
              HasSubstr("the second signal is of one colour"));
  EXPECT_THAT(says({"interpolate", "grey.png", "grey.png", "-o", "x.png"}),
              HasSubstr("both signals are of one colour"));
  for (const std::string name : {"a.png", "a.ply"})
    EXPECT_THAT(says({"flow", name, name, "-o", "out"}),
                AllOf(HasSubstr("the two are equal"), Not(HasSubstr("of one colour"))))
        << name;
  write_image(folder / "there.png", blobs(20, 20, 0, 0));
  write_image(folder / "moved.png", blobs(20, 20, 2, 0));
  EXPECT_THAT(says({"flow", "there.png", "moved.png", "-o", "out", "--detail", "0.01%"}),
              HasSubstr("--detail leaves nothing"));
  // Of two pixels there is nothing between.
  Image<float> two(2, 1, 1);
  two(1, 0) = 1;
  write_image(folder / "two.png", two);
  std::swap(two(0, 0), two(1, 0));
  write_image(folder / "swapped.png", two);
  EXPECT_THAT(says({"flow", "two.png", "swapped.png", "-o", "out"}),
              HasSubstr("no motion brings the two nearer"));
}

TEST(Flow, SaysHowFarItIsFromTheTruth) {
  const Folder folder;
  write_image(folder / "a.png", blobs(70, 60, 0, 0), Depth::u16);
  write_image(folder / "b.png", blobs(70, 60, 2, -1), Depth::u16);
  Image<float> truth = constant_field(70, 60, 2, -1);
  // Of the margin, from which pixels leave, nothing is known.
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 70; ++x)
      if (x < 8 || y < 8 || x >= 62 || y >= 52) truth(x, y, 0) = NAN;
  for (const std::string format : {"flo", "png", "exr"}) {
    write_flow(folder / ("truth." + format), truth);
    const Result result = marquetry(
        folder, {"flow", "a.png", "b.png", "-o", "out", "--truth", "truth." + format, "--json"});
    ASSERT_EQ(result.status, 0) << result.error;
    const auto errors = result.json()["result"]["truth"];
    EXPECT_EQ(errors["pixels"], 54 * 44);
    EXPECT_LT(errors["endpoint"].get<double>(), 0.05);
    EXPECT_LT(errors["angular"].get<double>(), 1);
    EXPECT_EQ(errors["outliers"], 0);
    EXPECT_GT(read_texture(folder / "out/truth.png").pixels.width(), 140);
    EXPECT_EQ(result.json()["input"]["files"].back(), "truth." + format);
  }
  // Of a field of another's making.
  write_flow(folder / "given.flo", constant_field(70, 60, 2, 3));
  const Result result = marquetry(folder, {"flow", "a.png", "b.png", "-o", "other", "--flow",
                                           "given.flo", "--truth", "truth.flo", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_DOUBLE_EQ(result.json()["result"]["truth"]["endpoint"], 4);
  EXPECT_DOUBLE_EQ(result.json()["result"]["truth"]["outliers"], 1);
  EXPECT_EQ(file_bytes(folder / "other/field.flo"), file_bytes(folder / "given.flo"));
  EXPECT_THAT(result.error, HasSubstr("brings the two no nearer"));
}

TEST(Flow, RefusesFieldsThatAreNone) {
  const Folder folder;
  write_strip(folder);
  write_image(folder / "a.png", blobs(20, 20, 0, 0));
  write_flow(folder / "good.flo", Image<float>(20, 20, 2));
  const std::string good = file_bytes(folder / "good.flo");
  write_bytes(folder / "cut.flo", good.substr(0, 900));
  write_bytes(folder / "empty.flo", "");
  write_bytes(folder / "other.flo", "PNG?" + good.substr(4));
  std::string huge = good;
  huge[7] = char(0x7f);
  write_bytes(folder / "huge.flo", huge);
  write_flow(folder / "wide.flo", Image<float>(21, 20, 2));
  // A picture of one pixel is stored as it is, at the end.
  write_flow(folder / "nan.exr", Image<float>(1, 1, 2, 1.25F));
  const std::string one = file_bytes(folder / "nan.exr");
  write_bytes(folder / "nan.exr", one.substr(0, one.size() - 4) + std::string("\0\0\xc0\x7f", 4));
  write_flow(folder / "unknown.flo", Image<float>(20, 20, 2, NAN));
  const std::vector<std::pair<std::string, std::string>> files = {
      {"cut.flo", "cut short"},         {"empty.flo", "has 0 bytes"},
      {"other.flo", "something else"},  {"huge.flo", "2130706452 x 20"},
      {"wide.flo", "21 x 20"},          {"unknown.flo", "marked as unknown"},
      {"a.png", "three of 16 (KITTI)"}, {"nan.exr", "holds nan"},
      {"none.flo", "none.flo"},         {"strip.obj", "optical flow comes"}};
  for (const std::string option : {"--flow", "--truth"})
    for (const auto& [file, message] : files) {
      const Result result =
          marquetry(folder, {"flow", "a.png", "a.png", "-o", "out", option, file});
      EXPECT_EQ(result.status, 2) << option << ' ' << file;
      EXPECT_THAT(result.error, HasSubstr(message)) << option;
      EXPECT_THAT(result.error, HasSubstr(file)) << option;
    }
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"flow", "a.png", "a.png", "-o", "out", "--flow", "good.flo", "--steps", "2"}, "--steps"},
      {{"flow", "strip.obj", "strip.png", "strip.png", "-o", "out", "--flow", "good.flo"},
       "--flow is for pictures"},
      {{"flow", "strip.obj", "strip.png", "strip.png", "-o", "out", "--truth", "good.flo"},
       "--truth is for pictures"},
      {{"interpolate", "a.png", "a.png", "-o", "good.flo", "--flow", "good.flo"}, "good.flo"}};
  for (const auto& [words, message] : cases) {
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 2) << words.back();
    EXPECT_THAT(result.error, HasSubstr(message));
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
  // What is read is not written over.
  const Result result = marquetry(
      folder, {"flow", "a.png", "a.png", "-o", ".", "--flow", "good.flo", "--format", "flo"});
  EXPECT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(marquetry(folder, {"flow", "a.png", "a.png", "-o", ".", "--flow", "field.flo"}).status,
            2);
}

TEST(Flow, NumbersTexturesOfOneName) {
  const Folder folder;
  write_bytes(folder / "two.obj",
              "mtllib two.mtl\nv 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\n"
              "vt 0.1 0.1\nvt 0.9 0.1\nvt 0.9 0.9\nvt 0.1 0.9\n"
              "usemtl a\nf 1/1 2/2 5/3 4/4\nusemtl b\nf 2/1 3/2 6/3 5/4\n");
  write_bytes(folder / "two.mtl", "newmtl a\nmap_Kd a/skin.png\nnewmtl b\nmap_Kd b/skin.png\n");
  for (const std::string name : {"a", "b", "c", "d"}) {
    std::filesystem::create_directory(folder / name);
    write_image(folder / (name + "/skin.png"), blobs(40, 30, name[0] - 'a', 0));
  }
  const std::vector<std::string> inputs = {"two.obj", "a/skin.png", "b/skin.png", "c/skin.png",
                                           "d/skin.png"};
  const auto run = [&](const std::string& verb, const std::vector<std::string>& rest) {
    std::vector<std::string> words = {verb};
    words.insert(words.end(), inputs.begin(), inputs.end());
    words.insert(words.end(), rest.begin(), rest.end());
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 0) << result.error;
  };
  run("flow", {"-o", "out"});
  for (const char* name : {"halfway/skin.png", "halfway/skin_2.png", "error/skin_2.png"})
    EXPECT_TRUE(std::filesystem::exists(folder / (std::string("out/") + name))) << name;
  run("interpolate", {"-o", "t_%s.png", "-t", "0"});
  EXPECT_EQ(read_texture(folder / "t_skin.png").pixels, read_texture(folder / "a/skin.png").pixels);
  EXPECT_EQ(read_texture(folder / "t_skin_2.png").pixels,
            read_texture(folder / "b/skin.png").pixels);
}

TEST(Flow, SaysWhichResultsAreOfAnEarlierRun) {
  const Folder folder;
  for (const int i : {0, 1}) {
    write_image(folder / (std::to_string(i) + ".png"), blobs(40, 40, i, 0));
    write_image(folder / (std::to_string(i) + ".exr"), blobs(40, 40, i, 0), Depth::f32);
  }
  const Result first = marquetry(folder, {"flow", "0.png", "1.png", "-o", "out"});
  ASSERT_EQ(first.status, 0) << first.error;
  EXPECT_THAT(first.error, Not(HasSubstr("there from before")));
  const Result second = marquetry(folder, {"flow", "0.exr", "1.exr", "-o", "out"});
  ASSERT_EQ(second.status, 0) << second.error;
  EXPECT_THAT(
      second.error,
      HasSubstr("not of this run, but there from before: out/blend.png, out/halfway.png\n"));
  EXPECT_TRUE(std::filesystem::exists(folder / "out/blend.png"));
}

TEST(Flow, SaysWhatFactorisationsWillTake) {
  const Folder folder;
  write_strip(folder);
  write_image(folder / "a.png", blobs(64, 48, 0, 0));
  write_image(folder / "b.png", blobs(64, 48, 1, 1));
  const Result small = marquetry(folder, {"flow", "strip.obj", "a.png", "b.png", "-o", "small",
                                          "--basis", "triangle", "--longest-edge", "6", "--json"});
  ASSERT_EQ(small.status, 0) << small.error;
  EXPECT_THAT(small.error, Not(HasSubstr("factors none")));
  const auto result = small.json()["result"];
  EXPECT_EQ(result["forecast"]["unknowns"], result["levels"][0]["unknowns"]);
  int corrections = 0;
  for (const auto& level : result["levels"]) corrections += level["cycles"].get<int>();
  EXPECT_LE(corrections, result["forecast"]["factorisations"].get<int>());
  EXPECT_GT(corrections, 0);
}

TEST(Flow, StopsWhenAskedTo) {
  const Folder folder;
  write_image(folder / "a.png", blobs(900, 900, 0, 0));
  write_image(folder / "b.png", blobs(900, 900, 5, 3));
  const Result result =
      marquetry(folder, {"flow", "a.png", "b.png", "-o", "out", "--steps", "1000"},
                {.interrupt_at = {"scale"}});
  EXPECT_EQ(result.status, 130) << result.error;
  EXPECT_FALSE(std::filesystem::exists(folder / "out/field.flo"));
}

TEST(Flow, GivesTheSameBitsForAnyNumberOfThreads) {
  const Folder folder;
  write_strip(folder);
  write_image(folder / "a.png", blobs(64, 48, 0, 0));
  write_image(folder / "b.png", blobs(64, 48, 1, 1));
  for (const std::string threads : {"1", "2", "7"}) {
    ASSERT_EQ(
        marquetry(folder, {"flow", "a.png", "b.png", "-o", "p" + threads, "--threads", threads})
            .status,
        0);
    ASSERT_EQ(marquetry(folder, {"flow", "strip.obj", "a.png", "b.png", "-o", "m" + threads,
                                 "--threads", threads})
                  .status,
              0);
  }
  for (const std::string threads : {"2", "7"}) {
    EXPECT_EQ(file_bytes(folder / ("p" + threads + "/field.flo")),
              file_bytes(folder / "p1/field.flo"));
    EXPECT_EQ(file_bytes(folder / ("m" + threads + "/field.vf")),
              file_bytes(folder / "m1/field.vf"));
  }
}

}  // namespace
}  // namespace mq::test
