#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cli/models.h"
#include "cli/refusal.h"
#include "evolving/evolving_models.h"
#include "mq/base/random.h"
#include "mq/io/evolving_file.h"
#include "mq/io/image_file.h"

namespace mq::test {
namespace {

using testing::HasSubstr;

/// A waving sheet that is renewed here and there, with an atlas, and pictures of its twelve frames:
/// one that stays where it is, and `disturbed` by what a frame adds to a pixel.
template <class Disturbance>
void make_film(const Folder& folder, const Disturbance& disturbance) {
  write_evolving(folder / "bare.evolving", patched_sheet(10, 4, 5), store_step(10));
  ASSERT_EQ(marquetry(folder, {"unwrap", "bare.evolving", "-o", "sheet.evolving", "--size", "64",
                               "--trials", "2"})
                .status,
            0);
  const Image<float> still = busy_picture(64, 64);
  for (int f = 0; f < 12; ++f) {
    Image<float> picture = still;
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 64; ++x)
        for (int c = 0; c < picture.channels(); ++c)
          picture(x, y, c) = 0.2F + 0.6F * picture(x, y, c);
    write_image(folder / ("still_" + std::to_string(f) + ".png"), picture);
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 64; ++x)
        for (int c = 0; c < picture.channels(); ++c)
          picture(x, y, c) += float(disturbance(f, x, y, c));
    write_image(folder / ("film_" + std::to_string(f) + ".png"), picture);
  }
}

std::vector<std::string> relight(const std::vector<std::string>& more,
                                 const std::string& output = "out_%d.png") {
  std::vector<std::string> words = {"relight", "sheet.evolving", "film_%d.png", "-o", output};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

double noise(int f, int x, int y, int c) {
  static const Random random(3);
  return random.uniform(std::uint64_t(((f * 64 + y) * 64 + x) * 3 + c), -0.1, 0.1);
}

TEST(Relight, TakesFlickerOutAndKeepsWhatIsSharp) {
  const Folder folder;
  make_film(folder, noise);
  const Result result = marquetry(folder, relight({"--method", "poisson", "--gamma", "4", "--alpha", "5e-6", "--space",
                                                   "stored", "--truth", "still_%d.png", "--json"}));
  ASSERT_EQ(result.status, 0) << result.error;
  const auto report = result.json();
  EXPECT_TRUE(report["solve"]["converged"]);
  const auto found = report["result"];
  const auto flicker = found["flicker"];
  EXPECT_NEAR(flicker["before"]["deviation"].get<double>(), 0.1 / std::sqrt(3), 0.003);
  // Lives of three frames at least; of a long one 0.36 would be left.
  EXPECT_LT(flicker["after"]["deviation"].get<double>(),
            0.5 * flicker["before"]["deviation"].get<double>());
  EXPECT_LT(flicker["after"]["step"].get<double>(), 0.2 * flicker["before"]["step"].get<double>());
  EXPECT_NEAR(found["truth"]["after"]["sharpness"].get<double>(), 1, 0.03);
  EXPECT_LT(found["truth"]["after"]["error"].get<double>(),
            0.6 * found["truth"]["before"]["error"].get<double>());
  EXPECT_EQ(picture_info(folder / "out_11.png").width, 64);
}

TEST(Relight, TakesLightOutThatComesAndGoes) {
  const Folder folder;
  make_film(folder, [](int f, int x, int, int) { return f % 2 == 0 ? 0.002 * x : 0.0; });
  const Result result = marquetry(folder, relight({"--length", "10tx", "--crossover", "gentle", "--space", "stored", "--json"}));
  ASSERT_EQ(result.status, 0) << result.error;
  const auto flicker = result.json()["result"]["flicker"];
  EXPECT_LT(flicker["after"]["step"].get<double>(), 0.4 * flicker["before"]["step"].get<double>());
}

/// A picture that slides by half a texel in every frame, as it is and with an exposure that jumps.
TEST(Relight, TakesExposureThatJumpsOffWhatSlidesAndKeepsItSharp) {
  const Folder folder;
  make_film(folder, [](int, int, int, int) { return 0.0; });
  const Image<float> still = busy_picture(64, 64);
  for (int f = 0; f < 12; ++f) {
    Image<float> truth = still;
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 64; ++x)
        for (int c = 0; c < truth.channels(); ++c)
          truth(x, y, c) = 0.2F + 0.3F * (still((x + f / 2) % 64, y, c) + still((x + (f + 1) / 2) % 64, y, c));
    write_image(folder / ("true_" + std::to_string(f) + ".png"), truth);
    for (float& value : truth.values()) value *= f % 2 == 0 ? 0.95F : 1.05F;
    write_image(folder / ("film_" + std::to_string(f) + ".png"), truth);
  }
  const Result result = marquetry(folder, relight({"--length", "10tx", "--truth", "true_%d.png", "--drift", "measure", "--json"}));
  ASSERT_EQ(result.status, 0) << result.error;
  const auto found = result.json()["result"];
  const auto before = found["truth"]["before"], after = found["truth"]["after"];
  EXPECT_LT(after["flicker"].get<double>(), 0.3 * before["flicker"].get<double>());
  EXPECT_GT(after["sharpness"].get<double>(), 0.97 * before["sharpness"].get<double>());
  EXPECT_GT(found["flicker"]["before"]["along"].get<double>(), 0.01);
}

/// In the middle of each triangle of a frame its picture is the one it was.
void expect_kept_in_triangles(const Folder& folder, int frame, double tolerance) {
  const EvolvingReader reader(folder / "sheet.evolving");
  const EvolvingMesh evolving = reader.read();
  const std::string name = std::to_string(frame) + ".png";
  const Image<float> was = read_texture(folder / ("film_" + name)).pixels,
                     is = read_texture(folder / ("out_" + name)).pixels;
  const EvolvingSegment& segment = evolving.segments[evolving.frames[frame].segment];
  for (int t = 0; t < segment.triangle_count(); ++t) {
    Vector2 centre = Vector2::Zero();
    for (const int uv : segment.corner_uvs[t]) centre += segment.uvs[uv] / 3;
    const int x = int(centre.x() * 64), y = int((1 - centre.y()) * 64);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(is(x, y, c), was(x, y, c), tolerance);
  }
}

TEST(Relight, GivesBackWhatIsToStay) {
  const Folder folder;
  make_film(folder, noise);
  ASSERT_EQ(
      marquetry(folder, relight({"--method", "poisson", "--change", "1", "--space", "log"})).status,
      0);
  expect_kept_in_triangles(folder, 4, 0);
}

/// Over segments too, in which triangles are replaced.
TEST(Relight, FollowsNothingWhereNothingSlides) {
  const Folder folder;
  make_film(folder, [](int, int, int, int) { return 0.0; });
  ASSERT_EQ(marquetry(folder, relight({"--alpha", "0", "--radius", "3", "--drift", "follow"})).status, 0);
  for (const int f : {0, 5, 11}) expect_kept_in_triangles(folder, f, 1.01 / 255);
  // Where triangles are replaced the film changes, with drift or not.
  const std::vector<std::string> poisson = {"--method", "poisson", "--gamma", "16", "--drift"};
  for (const char* how : {"ignore", "follow"}) {
    std::vector<std::string> options = poisson;
    options.push_back(how);
    ASSERT_EQ(marquetry(folder, relight(options, std::string(how) + "_%d.png")).status, 0);
  }
  for (const int f : {0, 5, 11}) {
    const std::string name = "_" + std::to_string(f) + ".png";
    const Image<float> one = read_texture(folder / ("ignore" + name)).pixels,
                       other = read_texture(folder / ("follow" + name)).pixels;
    for (std::size_t i = 0; i < one.values().size(); ++i) ASSERT_NEAR(one.values()[i], other.values()[i], 1.01 / 255) << f;
  }
}

/// Of frames that stay where they are, and of ones that slide by a texel.
TEST(Relight, SaysWhichFramesDriftIsFollowedTo) {
  const Folder folder;
  make_film(folder, [](int, int, int, int) { return 0.0; });
  const Image<float> still = busy_picture(64, 64);
  for (int f = 6; f < 12; ++f) {
    Image<float> slid = still;
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 64; ++x)
        for (int c = 0; c < slid.channels(); ++c)
          slid(x, y, c) = 0.2F + 0.6F * still((x + f) % 64, y, c);
    write_image(folder / ("film_" + std::to_string(f) + ".png"), slid);
  }
  const auto drift_of = [&](const std::string& part) {
    std::vector<std::string> words = {"--drift", "follow", "--radius", "2", "--json"};
    if (!part.empty()) words.insert(words.end(), {"--shard", part});
    const Result result = marquetry(folder, relight(words));
    EXPECT_EQ(result.status, 0) << result.error;
    if (part.empty()) EXPECT_THAT(result.error, HasSubstr("they are joined as if nothing slid"));
    return result.json()["result"]["drift"];
  };
  const auto whole = drift_of("");
  const EvolvingReader reader(folder / "sheet.evolving");
  ASSERT_EQ(whole.size(), 11U);
  int changes = 0, followed = 0;
  for (int f = 1; f < 12; ++f) {
    const auto row = whole[std::size_t(f - 1)];
    EXPECT_EQ(row["frame"], f);
    const bool change = reader.frames()[std::size_t(f)].segment != reader.frames()[std::size_t(f - 1)].segment;
    EXPECT_EQ(row.contains("explained"), !change) << f;
    changes += change ? 1 : 0;
    if (change || f < 6) EXPECT_FALSE(row["followed"].get<bool>()) << f;
    if (change || f < 7) continue;
    ++followed;
    EXPECT_TRUE(row["followed"].get<bool>()) << f;
    EXPECT_GT(row["explained"].get<double>(), 0.2) << f;
    EXPECT_NEAR(row["texels"].get<double>(), 1, 0.3) << f;
  }
  EXPECT_GT(changes, 0);
  EXPECT_GT(followed, 0);
  auto parts = drift_of("1/3");
  for (const char* part : {"2/3", "3/3"})
    for (const auto& row : drift_of(part)) parts.push_back(row);
  EXPECT_EQ(parts, whole);
}

TEST(Relight, WritesModelsAndVideosToo) {
  const Folder folder;
  make_film(folder, noise);
  ASSERT_EQ(marquetry(folder, relight({"--frames", "2-5"}, "lit_%d.obj")).status, 0);
  EXPECT_EQ(marquetry(folder, {"check", "lit_4.obj"}).status, 0);
  ASSERT_EQ(marquetry(folder, relight({"--frames", "2-5"}, "lit.mkv")).status, 0);
  EXPECT_GT(std::filesystem::file_size(folder / "lit.mkv"), 1000U);
}

TEST(Relight, KeepsDepth) {
  const Folder folder;
  make_film(folder, noise);
  for (int f = 0; f < 3; ++f) {
    const std::string name = "film_" + std::to_string(f) + ".png";
    write_image(folder / name, read_texture(folder / name).pixels, Depth::u16);
  }
  ASSERT_EQ(marquetry(folder, relight({"--frames", "0-2"})).status, 0);
  EXPECT_EQ(read_texture(folder / "out_1.png").format.depth, Depth::u16);
  ASSERT_EQ(marquetry(folder, relight({"--frames", "3-4"})).status, 0);
  EXPECT_EQ(read_texture(folder / "out_3.png").format.depth, Depth::u8);
}

TEST(Relight, RefusesWhatItCannotDo) {
  const Folder folder;
  make_film(folder, noise);
  EXPECT_THAT(refusal(folder, relight({"--method", "poisson", "--alpha", "3e5"}), "out_0.png"),
              HasSubstr("at most 100000"));
  EXPECT_THAT(refusal(folder, relight({"--codec", "av1"}), "out_0.png"), HasSubstr("--codec"));
  EXPECT_THAT(refusal(folder, relight({"--codec", "ffv1"}, "out.mp4"), "out.mp4"),
              HasSubstr("goes into .mkv"));
  EXPECT_THAT(refusal(folder, relight({"--gamma", "2"}), "out_0.png"), HasSubstr("poisson"));
  EXPECT_THAT(refusal(folder, relight({"--method", "poisson", "--radius", "2"}), "out_0.png"),
              HasSubstr("mean"));
  EXPECT_THAT(refusal(folder, relight({"--frames", "40"}), "out_0.png"), HasSubstr("no frame 40"));
  EXPECT_THAT(refusal(folder, relight({}, "out.png"), "out.png"), HasSubstr("place for"));
  EXPECT_THAT(refusal(folder, relight({"--method", "poisson", "--gamma", "100", "--hold", "8"}),
                      "out_0.png"),
              HasSubstr("--hold: found 8, and a gamma of 100 looks 47 frames ahead"));
  EXPECT_THAT(
      refusal(folder, {"relight", "sheet.evolving", "film_3.png", "-o", "o_%d.png"}, "o_0.png"),
      HasSubstr("place for"));
  EXPECT_THAT(
      refusal(folder, {"relight", "sheet.evolving", "none_%d.png", "-o", "o_%d.png"}, "o_0.png"),
      HasSubstr("none_0.png"));
  EXPECT_THAT(
      refusal(folder, {"relight", "bare.evolving", "film_%d.png", "-o", "o_%d.png"}, "o_0.png"),
      HasSubstr("no texture coordinates"));
  write_image(folder / "film_7.png", busy_picture(32, 32));
  EXPECT_THAT(refusal(folder, relight({}), "out_0.png"), HasSubstr("film_7.png"));
  for (const int f : {0, 1}) {
    write_image(folder / ("film_" + std::to_string(f) + ".png"), busy_picture(63, 64));
  }
  EXPECT_THAT(refusal(folder, relight({"--frames", "0-1"}, "out.mp4"), "out.mp4"),
              HasSubstr("63 × 64"));
}

/// What is written in parts, on machines that know nothing of each other.
TEST(Relight, GivesTheSamePicturesInParts) {
  const Folder folder;
  make_film(folder, [](int f, int x, int, int) { return f % 2 == 0 ? 0.002 * x : 0.0; });
  const std::vector<std::string> mean = {"--length", "10tx", "--radius", "2"};
  const auto with = [&](std::vector<std::string> words, const std::string& part) {
    words.insert(words.end(), {"--shard", part, "--report", "part_" + part.substr(0, 1) + ".json"});
    return words;
  };
  ASSERT_EQ(marquetry(folder, relight(mean, "whole_%d.png")).status, 0);
  for (const char* part : {"3/5", "1/5", "5/5", "2/5", "4/5"})
    ASSERT_EQ(marquetry(folder, relight(with(mean, part), "part_%d.png")).status, 0) << part;
  for (int f = 0; f < 12; ++f)
    EXPECT_TRUE(file_bytes(folder / ("part_" + std::to_string(f) + ".png")) ==
                file_bytes(folder / ("whole_" + std::to_string(f) + ".png")))
        << f;

  const Result merged = marquetry(folder, {"merge", "part_5.json", "part_2.json", "part_1.json", "part_4.json", "part_3.json",
                                           "-o", "whole.json", "--json"});
  ASSERT_EQ(merged.status, 0) << merged.error;
  EXPECT_EQ(merged.json()["result"]["frames"], 12);
  const auto whole = nlohmann::json::parse(file_bytes(folder / "whole.json"));
  ASSERT_EQ(whole["parts"].size(), 5U);
  EXPECT_EQ(whole["parts"][1]["result"]["part"]["first"], 2);
  EXPECT_THAT(refusal(folder, {"merge", "part_1.json", "part_2.json", "part_3.json", "part_5.json"}, "none"),
              HasSubstr("of 5 parts one is missing: 4"));
  std::filesystem::remove(folder / "part_3.png");
  EXPECT_THAT(refusal(folder, {"merge", "part_1.json", "part_2.json", "part_3.json", "part_4.json", "part_5.json"}, "none"),
              HasSubstr("part_3.png: not there"));

  // Of the frames that are read for it none is written; all at once is as near as the accuracy says.
  const std::vector<std::string> poisson = {"--method", "poisson", "--gamma", "1", "--accuracy", "0.01"};
  ASSERT_EQ(marquetry(folder, relight(poisson, "all_%d.png")).status, 0);
  ASSERT_EQ(marquetry(folder, relight(with(poisson, "2/3"), "own_%d.png")).status, 0);
  for (int f = 0; f < 12; ++f) {
    const auto own = folder / ("own_" + std::to_string(f) + ".png");
    ASSERT_EQ(std::filesystem::exists(own), f >= 4 && f < 8) << f;
    if (f < 4 || f >= 8) continue;
    const Image<float> one = read_texture(own).pixels,
                       other = read_texture(folder / ("all_" + std::to_string(f) + ".png")).pixels;
    float most = 0;
    for (std::size_t k = 0; k < one.values().size(); ++k)
      most = std::max(most, std::abs(one.values()[k] - other.values()[k]));
    EXPECT_LT(most, 0.01F + 1.0F / 255) << f;
  }
  EXPECT_THAT(refusal(folder, relight(with(mean, "1/13")), "out_0.png"), HasSubstr("12"));
}

}  // namespace
}  // namespace mq::test
