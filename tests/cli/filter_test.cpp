#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "cli/models.h"

namespace mq::test {
namespace {

using testing::ContainsRegex;
using testing::ElementsAre;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;
using Json = nlohmann::json;
using Words = std::vector<std::string>;

TEST(Filter, SaysHowManyValuesAreCut) {
  const Folder folder;
  write_strip(folder);
  const auto error = [&](const char* beta, const char* depth) {
    const Result result = marquetry(folder, {"filter", "strip.obj", "-o", "out.exr", "--depth", depth,
                                             "--beta", beta, "--length", "2tx"});
    EXPECT_EQ(result.status, 0) << result.error;
    return result.error;
  };
  EXPECT_THAT(error("0", "keep"), Not(HasSubstr("clamped")));
  EXPECT_THAT(error("9", "float"), Not(HasSubstr("clamped")));
  EXPECT_THAT(error("9", "keep"), Not(HasSubstr("clamped")));  // EXR holds them
  const Result result =
      marquetry(folder, {"filter", "strip.obj", "-o", "out.png", "--beta", "9", "--length", "2tx", "--halo", "inf",
                         "--json"});
  const auto cut = result.json()["result"];
  const double values = cut["unknowns"].get<double>() * cut["channels"].get<double>();
  EXPECT_DOUBLE_EQ(cut["beyond_percent"], 100 * (cut["below_0"].get<double>() + cut["above_1"].get<double>()) / values);
  EXPECT_GT(cut["beyond_percent"], 0);
  EXPECT_THAT(result.error,
              ContainsRegex("values beyond what 8 bits per channel can hold \\([0-9.]+ % of all\\), clamped"));
}

TEST(Filter, ReturnsTheInputWithBetaOne) {
  for (const Depth depth : {Depth::u8, Depth::u16}) {
    for (const char* space : {"stored", "linear", "log"}) {
      const Folder folder;
      write_strip(folder, 64, 48, depth);
      const Result result = marquetry(
          folder, {"filter", "strip.obj", "-o", "out.png", "--beta", "1", "--space", space});
      ASSERT_EQ(result.status, 0) << result.error;
      const Texture before = read_texture(folder / "strip.png");
      const Texture after = read_texture(folder / "out.png");
      EXPECT_EQ(before.pixels, after.pixels) << space;
      EXPECT_EQ(after.format.depth, depth);
    }
  }
}

TEST(Filter, LeavesHuesAloneByLuminance) {
  const Folder folder;
  write_strip(folder);
  const Image<float> before = read_texture(folder / "strip.png").pixels;
  write_image(folder / "in.exr", before, Depth::f32);
  const Words words{"filter", "strip.obj", "in.exr", "--beta", "2", "--length", "2tx", "--luminance", "-o"};
  Words call = words;
  call.push_back("out.exr");
  const Result result = marquetry(folder, call);
  ASSERT_EQ(result.status, 0) << result.error;
  const Image<float> after = read_texture(folder / "out.exr").pixels;
  double changed = 0;
  for (int y = 0; y < before.height(); ++y)
    for (int x = 0; x < before.width(); ++x)
      for (int c = 0; c < 3; ++c) {
        const float by = after(x, y, 0) - before(x, y, 0);
        EXPECT_NEAR(after(x, y, c) - before(x, y, c), by, 1e-6);
        changed = std::max(changed, double(std::abs(by)));
      }
  EXPECT_GT(changed, 0.05);
  EXPECT_EQ(marquetry(folder, {"filter", "strip.obj", "--beta", "2", "--luminance", "--normals", "-o", "x.png"}).status, 2);
}

TEST(Filter, GivesTheSamePictureWithEverySolver) {
  const Folder folder;
  write_strip(folder, 128, 96);
  std::vector<Image<float>> pictures;
  for (const std::string solver : {"direct", "multigrid", "reference"}) {
    const Result result =
        marquetry(folder, {"filter", "strip.obj", "-o", solver + ".exr", "--depth", "float",
                           "--beta", "3", "--alpha", "0.01", "--halo", "inf", "--solver", solver, "--json"});
    ASSERT_EQ(result.status, 0) << result.error;
    EXPECT_THAT(result.json()["solve"]["method"].get<std::string>(), HasSubstr(solver));
    EXPECT_TRUE(result.json()["solve"]["converged"]);
    pictures.push_back(read_texture(folder / (solver + ".exr")).pixels);
  }
  for (int y = 0; y < 96; ++y)
    for (int x = 0; x < 128; ++x)
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(pictures[1].pixel(x, y)[c], pictures[0].pixel(x, y)[c], 1.0 / 65535);
        EXPECT_NEAR(pictures[2].pixel(x, y)[c], pictures[0].pixel(x, y)[c], 1.0 / 65535);
      }
}

TEST(Filter, LimitsHalosOfColoursByItself) {
  const Folder folder;
  write_strip(folder, 128, 96);
  const auto result = [&](const Words& more) {
    Words words = {"filter", "strip.obj", "-o", "out.exr", "--depth", "float", "--beta", "9",
                   "--length", "3tx", "--overwrite", "--json"};
    words.insert(words.end(), more.begin(), more.end());
    const Result found = marquetry(folder, words);
    EXPECT_EQ(found.status, 0) << found.error;
    return found.json()["result"];
  };
  const auto as_said = result({"--halo", "inf"}), usual = result({}), stated = result({"--halo", "0.2"});
  EXPECT_EQ(as_said["halo"], "inf");
  EXPECT_EQ(usual["halo"], 0.2);
  EXPECT_EQ(usual["rms_change"], stated["rms_change"]);
  EXPECT_GT(usual["rms_change"], 0);
  EXPECT_LT(usual["largest_change"].get<double>(), 0.7 * as_said["largest_change"].get<double>());
  EXPECT_LT(usual["beyond_percent"].get<double>(), 0.7 * as_said["beyond_percent"].get<double>());
  EXPECT_EQ(result({"--space", "linear"})["halo"], "inf");
  EXPECT_EQ(result({"--space", "log"})["halo"], 0.2);
  EXPECT_EQ(result({"--luminance"})["halo"], 0.2);
}

/// A square and, along one of its edges, a strip of this width; each takes as much of the texture.
void write_bevel(const Folder& folder, double width, int size) {
  write_bytes(folder / "bevel.obj",
              fmt::format("mtllib bevel.mtl\nusemtl bevel\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
                          "v 0 1 {0}\nv 1 1 {0}\nvt .02 .02\nvt .48 .02\nvt .48 .48\nvt .02 .48\n"
                          "vt .52 .52\nvt .98 .52\nvt .98 .98\nvt .52 .98\nf 1/1 2/2 3/3\n"
                          "f 1/1 3/3 4/4\nf 4/5 3/6 6/7\nf 4/5 6/7 5/8\n",
                          -width));
  write_bytes(folder / "bevel.mtl", "newmtl bevel\nmap_Kd bevel.png\n");
  write_image(folder / "bevel.png", busy_picture(size, size), Depth::u8);
}

// A residual of 1e-6 says little where the rows of a matrix differ by orders of magnitude.
TEST(Filter, IsAccurateWhereTexelsAreStretchedFar) {
  for (const double width : {1.0 / 30, 1e-4}) {
    const Folder folder;
    write_bevel(folder, width, 320);
    std::vector<Image<float>> pictures;
    for (const std::string solver : {"direct", "automatic"}) {
      const Result result =
          marquetry(folder, {"filter", "bevel.obj", "-o", solver + ".exr", "--depth", "float",
                             "--beta", "0", "--alpha", "0.01", "--solver", solver, "--json"});
      ASSERT_EQ(result.status, 0) << result.error;
      EXPECT_TRUE(result.json()["solve"]["converged"]);
      if (width > 0.01 && solver == "automatic") {
        EXPECT_EQ(result.json()["solve"]["method"], "multigrid");
      }
      pictures.push_back(read_texture(folder / (solver + ".exr")).pixels);
    }
    double worst = 0;
    for (int y = 0; y < 320; ++y)
      for (int x = 0; x < 320; ++x)
        for (int c = 0; c < 3; ++c)
          worst = std::max(
              worst, std::abs(double(pictures[0].pixel(x, y)[c]) - pictures[1].pixel(x, y)[c]));
    EXPECT_LE(worst, 1.0 / 65535) << width;
  }
}

// Whatever iterations do there, rubbish is not written.
TEST(Filter, WritesNothingWorseThanTheInputWhereMultigridDiverges) {
  const Folder folder;
  write_bytes(folder / "long.obj",
              "mtllib long.mtl\nusemtl long\nv 0 0 0\nv 1000000 0 0\nv 1000000 1 0\nv 0 1 0\n"
              "vt .02 .02\nvt .98 .02\nvt .98 .98\nvt .02 .98\nf 1/1 2/2 3/3 4/4\n");
  write_bytes(folder / "long.mtl", "newmtl long\nmap_Kd long.png\n");
  write_image(folder / "long.png", busy_picture(256, 256), Depth::u8);
  const Result result = marquetry(folder, {"filter", "long.obj", "-o", "o.png", "-b", "0", "-a",
                                           "1", "--cycles", "60", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_LE(result.json()["result"]["largest_change"].get<double>(), 1);
  const Result asked = marquetry(folder, {"filter", "long.obj", "-o", "m.png", "-b", "0", "-a", "1",
                                          "--cycles", "60", "--solver", "multigrid"});
  EXPECT_TRUE(asked.status == 0 || !std::filesystem::exists(folder / "m.png")) << asked.error;
}

TEST(Filter, TakesInfiniteWeights) {
  const Folder folder;
  write_strip(folder, 64, 48);
  const auto filtered = [&](const Words& how) {
    Words command = {"filter", "strip.obj", "-o", "o.exr", "--depth", "float", "-b", "0", "--json"};
    command.insert(command.end(), how.begin(), how.end());
    const Result result = marquetry(folder, command);
    EXPECT_EQ(result.status, 0) << result.error;
    EXPECT_EQ(result.json()["solve"]["converged"], true);
    return result;
  };
  const Result infinite = filtered({"--alpha", "inf"});
  EXPECT_EQ(infinite.json()["result"]["alpha"], "inf");
  EXPECT_EQ(infinite.json()["options"]["alpha"], "inf");
  // A smooth value is between the least and the largest, however far smoothing reaches.
  for (const char* length : {"1e3", "1e6", "1e12", "1e200"}) {
    const Result far = filtered({"--length", length});
    EXPECT_NEAR(far.json()["result"]["largest_change"].get<double>(),
                infinite.json()["result"]["largest_change"].get<double>(), 1e-4)
        << length;
  }
}

TEST(Filter, ChangesNoTexelFarFromTheCharts) {
  const Folder folder;
  write_strip(folder);
  ASSERT_EQ(marquetry(folder, {"filter", "strip.obj", "-o", "out.png", "--beta", "3"}).status, 0);
  const Image<float> before = read_texture(folder / "strip.png").pixels;
  const Image<float> after = read_texture(folder / "out.png").pixels;
  int changed = 0;
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) {
      const bool same = std::ranges::equal(before.pixel(x, y), after.pixel(x, y));
      changed += !same;
      // The charts span columns 2.7 to 28.3 and 34.7 to 60.3, rows 4.3 to 42.7.
      const bool far = x < 1 || x > 62 || y < 3 || y > 44 || (x > 30 && x < 33);
      EXPECT_TRUE(same || !far) << x << ", " << y;
    }
  EXPECT_GT(changed, 1500);
}

TEST(Filter, ReportsWhatItDid) {
  const Folder folder;
  write_strip(folder);
  const Result result = marquetry(folder, {"filter", "strip.obj", "strip.png", "-o", "out.png",
                                           "--beta", "0", "--length", "4tx", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  const Json json = result.json();
  EXPECT_EQ(json["options"]["beta"], 0.0);
  EXPECT_EQ(json["options"]["length"], "4tx");
  EXPECT_FALSE(json["options"].contains("alpha"));
  EXPECT_EQ(json["options"]["texture"], Json::array({"strip.png"}));
  EXPECT_TRUE(json["solve"]["converged"].get<bool>());
  EXPECT_EQ(json["solve"]["residuals"][0], 1.0);
  EXPECT_GT(json["result"]["unknowns"].get<int>(), 1500);
  EXPECT_GT(json["result"]["rms_change"].get<double>(), 0.01);
  EXPECT_GT(json["seconds"]["total"].get<double>(), 0);
  EXPECT_GT(json["peak_bytes"].get<double>(), 1e6);
  EXPECT_EQ(json["result"]["outputs"], Json::array({"out.png"}));
}

TEST(Filter, IsRepeatedFromItsReport) {
  const Folder folder;
  write_strip(folder);
  ASSERT_EQ(marquetry(folder, {"filter", "strip.obj", "-o", "a.png", "--beta", "2.5", "--length",
                               "3%", "--report", "report.json"})
                .status,
            0);
  const Result repeated = marquetry(folder, {"filter", "--config", "report.json", "-o", "b.png"});
  ASSERT_EQ(repeated.status, 0) << repeated.error;
  EXPECT_TRUE(file_bytes(folder / "a.png") == file_bytes(folder / "b.png"));

  const Result other = marquetry(
      folder, {"filter", "--config", "report.json", "-o", "c.png", "--alpha", "0.1", "--json"});
  ASSERT_EQ(other.status, 0) << other.error;
  EXPECT_EQ(other.json()["options"]["alpha"], 0.1);
  EXPECT_EQ(other.json()["options"]["beta"], 2.5);
}

TEST(Filter, RefusesConfigurationsItDoesNotUnderstand) {
  const Folder folder;
  write_strip(folder);
  const auto with = [&](const std::string& config) {
    write_bytes(folder / "c.json", config);
    return marquetry(folder, {"filter", "strip.obj", "-o", "o.png", "--config", "c.json"});
  };
  EXPECT_THAT(with("{\"bta\": 1}").error, HasSubstr("did you mean '--beta'?"));
  EXPECT_THAT(with("{\"beta\": \"much\"}").error,
              HasSubstr("c.json, line 1, column 10: --beta: found 'much'"));
  EXPECT_THAT(with("{\"verb\": \"inspect\", \"options\": {}}").error, HasSubstr("inspect"));
  EXPECT_THAT(with("{\"beta\": [1, 2]}").error, HasSubstr("takes one value"));
  EXPECT_THAT(with("[1]").error, HasSubstr("c.json, line 1, column 1: found no JSON object"));
  EXPECT_THAT(with("{\n\"beta\"").error,
              HasSubstr("c.json, line 2, column 7: not JSON from here on: found the "
                        "end of the file, wanted ':'"));
  EXPECT_THAT(with("{\"verb\": 3}").error, HasSubstr("written by 'marquetry 3'"));
  EXPECT_THAT(with("{\"options\": 3}").error, HasSubstr("wanted one of options"));
  EXPECT_EQ(with("{\"beta\": null}").status, 2);
  EXPECT_EQ(with("{\"beta\": 1}").status, 0);
}

TEST(Filter, GivesEqualBitsForAnyNumberOfThreads) {
  const Folder folder;
  write_strip(folder, 300, 200, Depth::u16);
  std::string first;
  for (const char* threads : {"1", "2", "7"}) {
    ASSERT_EQ(marquetry(folder, {"filter", "strip.obj", "-o", "out.png", "--beta", "2", "--threads",
                                 threads})
                  .status,
              0);
    const std::string bytes = file_bytes(folder / "out.png");
    if (first.empty()) first = bytes;
    EXPECT_EQ(bytes, first) << threads;
  }
}

TEST(Filter, RefusesBadOptionsBeforeReadingAnything) {
  const Folder folder;
  const auto error = [&](const Words& more) {
    Words words = {"filter", "missing.obj", "-o", "out.png"};
    words.insert(words.end(), more.begin(), more.end());
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 2);
    EXPECT_THAT(result.error, StartsWith("marquetry filter: "));
    return result.error;
  };
  EXPECT_THAT(error({}), HasSubstr("how much is wanted"));
  EXPECT_THAT(error({}), HasSubstr("marquetry filter scan.obj --strength 50% -o sharp.obj"));
  EXPECT_THAT(error({"--strength", "-101%"}), HasSubstr("from -100 to 99900"));
  EXPECT_THAT(error({"--strength", "50", "--beta", "2"}), HasSubstr("contradict"));
  EXPECT_THAT(error({"--strength", "50", "--alpha", "1"}), HasSubstr("contradict"));
  EXPECT_THAT(error({"--beta", "1", "--radius", "1%", "--length", "1%"}), HasSubstr("contradict"));
  EXPECT_THAT(error({"--beta", "nan"}), HasSubstr("--beta: found 'nan'"));
  EXPECT_THAT(error({"--beta", "-1"}), HasSubstr("from 0 to 1000"));
  EXPECT_THAT(error({"--betta", "1"}), HasSubstr("did you mean '--beta'?"));
  EXPECT_THAT(error({"--beta", "1", "--alpha", "1", "--length", "1"}), HasSubstr("contradict"));
  EXPECT_THAT(error({"--beta", "1", "--length", "8px"}), HasSubstr("--length: found '8px'"));
  EXPECT_THAT(error({"--beta", "1", "--weld", "0"}), HasSubstr("--weld: found '0'"));
  EXPECT_THAT(error({"--beta", "1", "--frames", "9-1"}), HasSubstr("--frames: found '9-1'"));
  EXPECT_THAT(error({"--beta", "1"}), HasSubstr("missing.obj"));
}

TEST(Filter, TakesStrengthAndRadiusForBetaAndLength) {
  const Folder folder;
  write_strip(folder);
  const auto made = [&](const Words& more) {
    Words words = {"filter", "strip.obj", "-o", "out.png", "--overwrite"};
    words.insert(words.end(), more.begin(), more.end());
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 0) << result.error;
    return file_bytes(folder / "out.png");
  };
  EXPECT_EQ(made({"--strength", "150%", "--radius", "2tx"}),
            made({"--beta", "2.5", "--length", "2tx", "--luminance", "--threshold", "0.02"}));
  EXPECT_NE(made({"--strength", "150%", "--radius", "2tx"}), made({"--beta", "2.5", "--length", "2tx"}));
  EXPECT_EQ(made({"--strength", "-100"}), made({"--beta", "0", "--length", "3tx"}));
  EXPECT_EQ(made({"--beta", "2", "--radius", "4tx", "--luminance"}),
            made({"--strength", "100", "--length", "4tx", "--threshold", "0"}));
  EXPECT_NE(made({"--strength", "50"}), made({"--beta", "1.5"}));
}

/// What is reported says what was done, and does it again.
TEST(Filter, IsRepeatedWithAStrengthFromItsReport) {
  const Folder folder;
  write_strip(folder);
  ASSERT_EQ(marquetry(folder, {"filter", "strip.obj", "-o", "a.png", "--strength", "80%", "--report", "a.json"}).status,
            0);
  ASSERT_EQ(marquetry(folder, {"filter", "--config", "a.json", "-o", "b.png"}).status, 0);
  EXPECT_TRUE(file_bytes(folder / "a.png") == file_bytes(folder / "b.png"));
}

TEST(Filter, RunsOverFrames) {
  const Folder folder;
  write_strip(folder);
  for (int frame = 2; frame <= 6; ++frame)
    std::filesystem::copy(folder / "strip.png", folder / ("in_0" + std::to_string(frame) + ".png"));
  const Result result =
      marquetry(folder, {"filter", "strip.obj", "in_%02d.png", "-o", "out_%03d.png", "--beta", "0",
                         "--frames", "2-6x2", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  const Json json = result.json();
  ASSERT_EQ(json["frames"].size(), 3U);
  EXPECT_EQ(json["frames"][1]["result"]["outputs"][0], "out_004.png");
  EXPECT_EQ(json["options"]["frames"], "2-6x2");
  for (const char* name : {"out_002.png", "out_004.png", "out_006.png"})
    EXPECT_TRUE(std::filesystem::exists(folder / name)) << name;
  EXPECT_EQ(marquetry(folder, {"filter", "strip.obj", "-o", "out.png", "-b", "0", "--frames", "1-2"}).status, 2);
}

TEST(Filter, RefusesAFoldWithItsPlace) {
  const Folder folder;
  write_bytes(folder / "folded.obj", folded_obj);
  write_image(folder / "a.png", busy_picture(32, 32));
  const Result result =
      marquetry(folder, {"filter", "folded.obj", "a.png", "-o", "out.png", "--beta", "0"});
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.error, HasSubstr("folded.obj"));
  EXPECT_THAT(result.error, HasSubstr("flipped_triangles"));
  EXPECT_FALSE(std::filesystem::exists(folder / "out.png"));
}

TEST(Filter, KeepsFloatingPointBeyondOne) {
  const Folder folder;
  write_strip(folder);
  Image<float> bright = busy_picture(64, 48);
  for (float& value : bright.values()) value *= 40;
  write_image(folder / "bright.exr", bright, Depth::f32);
  const Result result =
      marquetry(folder, {"filter", "strip.obj", "bright.exr", "-o", "out.exr", "--beta", "2"});
  ASSERT_EQ(result.status, 0) << result.error;
  const Texture after = read_texture(folder / "out.exr");
  EXPECT_EQ(after.format.depth, Depth::f32);
  EXPECT_GT(*std::ranges::max_element(after.pixels.values()), 20.0F);
}

TEST(Filter, SmoothsColoursAtVertices) {
  const Folder folder;
  write_bytes(folder / "fan.ply", coloured_ply);
  const Result result = marquetry(
      folder, {"filter", "fan.ply", "-o", "out.ply", "--beta", "0", "--alpha", "1", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["unknowns"], 5);
  const VertexSignal colors = read_model(folder / "out.ply").colors;
  ASSERT_EQ(colors.values.size(), 15U);
  EXPECT_EQ(colors.depth, Depth::u8);
  EXPECT_LT(colors.values[0], 180 / 255.0F);
  EXPECT_GT(colors.values[3], 100 / 255.0F);

  ASSERT_EQ(marquetry(folder, {"filter", "fan.ply", "-o", "same.ply", "--beta", "1"}).status, 0);
  EXPECT_TRUE(file_bytes(folder / "same.ply") == file_bytes(folder / "fan.ply"));
  EXPECT_EQ(marquetry(folder, {"filter", "fan.ply", "-o", "out.png", "--beta", "1"}).status, 2);
}

TEST(Filter, TreatsSeveralTexturesAsOneSignal) {
  const Folder folder;
  write_bytes(folder / "two.obj",
              "mtllib two.mtl\nv 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\n"
              "vt 0.1 0.1\nvt 0.9 0.1\nvt 0.9 0.9\nvt 0.1 0.9\n"
              "usemtl a\nf 1/1 2/2 5/3 4/4\nusemtl b\nf 2/1 3/2 6/3 5/4\n");
  write_bytes(folder / "two.mtl", "newmtl a\nmap_Kd dark.png\nnewmtl b\nmap_Kd bright.png\n");
  write_image(folder / "dark.png", Image<float>(32, 32, 3, 0.2F));
  write_image(folder / "bright.png", Image<float>(40, 40, 4, 0.8F));
  const auto filter = [&](const std::string& output) {
    return marquetry(folder, {"filter", "two.obj", "-o", output, "--beta", "0", "--length", "0.2"});
  };
  ASSERT_EQ(filter("out/").status, 0);
  const Image<float> dark = read_texture(folder / "out/dark.png").pixels;
  const Image<float> bright = read_texture(folder / "out/bright.png").pixels;
  EXPECT_EQ(dark.channels(), 3);
  EXPECT_EQ(bright.channels(), 4);
  // At the border, u = 0.9 in the one and 0.1 in the other, both show the mean.
  EXPECT_NEAR(dark(28, 16), 0.5, 0.06);
  EXPECT_NEAR(bright(4, 20), 0.5, 0.06);
  EXPECT_LT(dark(4, 16), 0.3);
  EXPECT_GT(bright(36, 20), 0.7);

  EXPECT_EQ(filter("smooth_%s.png").status, 0);
  EXPECT_EQ(file_bytes(folder / "smooth_dark.png"), file_bytes(folder / "out/dark.png"));
  EXPECT_THAT(filter("out.png").error, HasSubstr("2 textures"));
}

TEST(Filter, FactorisesWhatMultigridDoesNotReach) {
  const Folder folder;
  write_strip(folder, 300, 250);
  const Words words = {"filter", "strip.obj", "-o",     "o.png",
                       "--beta", "0",         "--json", "--overwrite"};
  const auto with = [&](const Words& more) {
    Words all = words;
    all.insert(all.end(), more.begin(), more.end());
    return marquetry(folder, all);
  };
  const Json plain = with({}).json()["solve"];
  EXPECT_EQ(plain["method"], "multigrid");
  EXPECT_EQ(plain["tried"].size(), 0U);

  // No residual in double precision is that small.
  const Result fallen = with({"--tolerance", "1e-16"});
  ASSERT_EQ(fallen.status, 0) << fallen.error;
  const Json solve = fallen.json()["solve"];
  EXPECT_THAT(solve["method"].get<std::string>(), StartsWith("direct"));
  EXPECT_TRUE(solve["converged"].get<bool>());
  ASSERT_EQ(solve["tried"].size(), 1U);
  EXPECT_EQ(solve["tried"][0]["method"], "multigrid");
  EXPECT_FALSE(solve["tried"][0]["converged"].get<bool>());

  const Result kept = with({"--tolerance", "1e-16", "--solver", "multigrid"});
  ASSERT_EQ(kept.status, 0) << kept.error;
  EXPECT_THAT(kept.error, HasSubstr("warning: multigrid stopped after"));
  EXPECT_FALSE(kept.json()["solve"]["converged"].get<bool>());

  // Who asks for two cycles gets them, is told how far they came, and hears no complaint.
  const Result brief = with({"--tolerance", "1e-16", "--cycles", "2"});
  ASSERT_EQ(brief.status, 0) << brief.error;
  EXPECT_THAT(brief.error, AllOf(Not(HasSubstr("warning")), HasSubstr("more --cycles come nearer")));
  EXPECT_EQ(brief.json()["solve"]["cycles"], 2);
  EXPECT_EQ(brief.json()["solve"]["residuals"].size(), 3U);
}

TEST(Filter, SaysWhoseTextureHasNoArea) {
  const Folder folder;
  write_image(folder / "a.png", busy_picture(16, 16));
  write_bytes(folder / "flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.5 0.5\nf 1/1 2/1 3/1\n");
  const Result result =
      marquetry(folder, {"filter", "flat.obj", "a.png", "-o", "o.png", "--beta", "0"});
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.error, HasSubstr("flat.obj: no triangle has texture coordinates and area"));
  EXPECT_THAT(result.error, HasSubstr("1 triangle with no area in the texture: no texel can show them, left out"));
  const Result drawn =
      marquetry(folder, {"render", "flat.obj", "a.png", "-o", "o.png", "--at", "1,0,0"});
  EXPECT_EQ(drawn.status, 2);
  EXPECT_THAT(drawn.error, HasSubstr("flat.obj: no triangle has an area"));
}

}  // namespace
}  // namespace mq::test
