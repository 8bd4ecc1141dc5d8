// marquetry denoise, run as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include <nlohmann/json.hpp>

#include "cli/models.h"
#include "mq/base/random.h"

namespace mq::test {
namespace {

using Json = nlohmann::json;
using ::testing::HasSubstr;

/// Half dark, half twenty times brighter than white, with noise.
Image<float> noisy_light() {
  Image<float> light = busy_picture(64, 48, 3);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x)
      for (float& value : light.pixel(x, y))
        value = (y < 24 ? 1.0F : 20.0F) * (0.5F + 0.2F * value);
  return light;
}

double roughness(const Image<float>& light, int from, int to) {
  double sum = 0;
  for (int y = from; y < to; ++y)
    for (int x = 6; x < 26; ++x) sum += std::abs(light(x, y) - light(x + 1, y));
  return sum;
}

TEST(Denoise, SmoothsAnHdrLightmapButNotOverItsEdge) {
  const Folder folder;
  write_strip(folder);
  const Image<float> light = noisy_light();
  write_image(folder / "light.exr", light, Depth::f32);
  const Result result =
      marquetry(folder, {"denoise", "strip.obj", "light.exr", "-o", "clean.exr", "--space", "log",
                         "--length", "6tx", "--edge", "0.3", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  const Image<float> clean = read_texture(folder / "clean.exr").pixels;
  EXPECT_LT(roughness(clean, 8, 20), 0.3 * roughness(light, 8, 20));
  EXPECT_LT(roughness(clean, 28, 40), 0.3 * roughness(light, 28, 40));
  for (int x = 6; x < 26; ++x) EXPECT_GT(clean(x, 26) / clean(x, 21), 12);
}

TEST(Denoise, LeavesNormalsOfUnitLength) {
  const Folder folder;
  write_strip(folder);
  Image<float> map = busy_picture(64, 48, 3);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) {
      const Vector3 normal =
          Vector3(map(x, y, 0) - 0.5, map(x, y, 1) - 0.5, y % 32 < 16 ? 1 : -1).normalized();
      for (int c = 0; c < 3; ++c) map(x, y, c) = float(0.5 + 0.5 * normal[c]);
    }
  write_image(folder / "normals.exr", map, Depth::f32);
  const std::vector<std::string> words = {"denoise",  "strip.obj", "normals.exr", "-o", "clean.exr",
                                          "--length", "6tx",       "--edge",      "1"};
  const auto farthest_from_unit = [&] {
    const Image<float> clean = read_texture(folder / "clean.exr").pixels;
    double most = 0;
    for (int y = 8; y < 40; ++y)
      for (int x = 6; x < 26; ++x) {
        const Vector3 normal(clean(x, y, 0), clean(x, y, 1), clean(x, y, 2));
        most = std::max(most, std::abs((2 * normal - Vector3::Ones()).norm() - 1));
      }
    return most;
  };
  ASSERT_EQ(marquetry(folder, words).status, 0);
  EXPECT_GT(farthest_from_unit(), 0.05);
  std::vector<std::string> with = words;
  with.push_back("--normals");
  ASSERT_EQ(marquetry(folder, with).status, 0);
  EXPECT_LT(farthest_from_unit(), 1e-5);
}

TEST(Denoise, KeepsTheEdgesOfAGuide) {
  const Folder folder;
  write_strip(folder);
  const Image<float> light = noisy_light();
  write_image(folder / "light.exr", light, Depth::f32);
  Image<float> guide(64, 48, 1);
  for (int y = 24; y < 48; ++y)
    for (int x = 0; x < 64; ++x) guide(x, y) = 1;
  write_image(folder / "guide.png", guide);
  const Result result =
      marquetry(folder, {"denoise", "strip.obj", "light.exr", "-o", "clean.exr", "--edge", "0",
                         "--guide", "guide.png", "--length", "6tx"});
  ASSERT_EQ(result.status, 0) << result.error;
  const Image<float> clean = read_texture(folder / "clean.exr").pixels;
  EXPECT_LT(roughness(clean, 28, 40), 0.3 * roughness(light, 28, 40));
  for (int x = 6; x < 26; ++x) EXPECT_GT(clean(x, 26) / clean(x, 21), 8);
}

/// A ramp with noise of 0.05, as a picture of 8 bits.
Image<float> noisy_ramp() {
  const Random random(3);
  Image<float> picture(96, 96, 3);
  for (int y = 0; y < 96; ++y)
    for (int x = 0; x < 96; ++x)
      for (int c = 0; c < 3; ++c) {
        double noise = -6;  // twelve uniform numbers
        for (int k = 0; k < 12; ++k) noise += random.uniform(std::uint64_t(((y * 96 + x) * 3 + c) * 12 + k));
        picture(x, y, c) = float(0.3 + 0.4 * x / 96 + 0.05 * noise);
      }
  return picture;
}

TEST(Denoise, MeasuresTheNoiseOfAPictureAndTakesItOff) {
  const Folder folder;
  write_image(folder / "noisy.png", noisy_ramp());
  const Result result = marquetry(folder, {"denoise", "noisy.png", "-o", "clean.png", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  const Json found = Json::parse(result.output)["result"];
  EXPECT_EQ(found["method"], "patches");
  for (const double noise : found["noise"]) EXPECT_NEAR(noise, 0.05, 0.005);
  EXPECT_FALSE(found.contains("edge"));
  const Image<float> clean = read_texture(folder / "clean.png").pixels;
  EXPECT_LT(roughness(clean, 8, 88), 0.3 * roughness(noisy_ramp(), 8, 88));
}

TEST(Denoise, TakesSaltAndPepperOffAndSaysHowMuch) {
  const Folder folder;
  const Random random(5);
  Image<float> truth(96, 96, 3), picture(96, 96, 3);
  for (int y = 0; y < 96; ++y)
    for (int x = 0; x < 96; ++x) {
      const double drawn = random.uniform(std::uint64_t(y * 96 + x));
      for (int c = 0; c < 3; ++c) {
        truth(x, y, c) = float(0.5 + 0.2 * std::sin(0.1 * x + 0.2 * c) * std::cos(0.13 * y));
        picture(x, y, c) = drawn < 0.02 ? 0.0F : drawn > 0.98 ? 1.0F : truth(x, y, c);
      }
    }
  write_image(folder / "specks.png", picture);
  const Result result = marquetry(folder, {"denoise", "specks.png", "-o", "clean.png", "--report", "r.json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_THAT(result.output + result.error, HasSubstr("texels set to the least or the largest value"));
  const Image<float> clean = read_texture(folder / "clean.png").pixels;
  int left = 0;
  for (int y = 0; y < 96; ++y)
    for (int x = 0; x < 96; ++x)
      if (std::abs(clean(x, y, 1) - truth(x, y, 1)) > 0.06) ++left;
  EXPECT_LT(left, 12);  // of 370: those in larger groups
}

/// The stronger the smoother, by patches and by edges.
TEST(Denoise, IsAsStrongAsItIsAskedToBe) {
  const Folder folder;
  write_image(folder / "noisy.png", noisy_ramp());
  for (const char* method : {"patches", "edges"}) {
    std::vector<double> left;
    for (const char* strength : {"30%", "100", "200%"}) {
      const Result result = marquetry(folder, {"denoise", "noisy.png", "-o", "clean.png", "--method", method,
                                               "--strength", strength, "--json", "--overwrite"});
      ASSERT_EQ(result.status, 0) << result.error;
      left.push_back(roughness(read_texture(folder / "clean.png").pixels, 8, 88));
    }
    EXPECT_GT(left[0], 1.3 * left[1]) << method;
    EXPECT_GT(left[1], left[2]) << method;
  }
  const Result both = marquetry(folder, {"denoise", "noisy.png", "-o", "o.png", "--edge", "1", "--strength", "50"});
  EXPECT_EQ(both.status, 2);
}

TEST(Denoise, GoesByEdgesWhereTheyAreAskedFor) {
  const Folder folder;
  write_image(folder / "noisy.png", noisy_ramp());
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"--edge", "0.1"}, {"--length", "3tx"}, {"--method", "edges"}}) {
    std::vector<std::string> all = {"denoise", "noisy.png", "-o", "clean.png", "--json", "--overwrite"};
    all.insert(all.end(), words.begin(), words.end());
    const Result result = marquetry(folder, all);
    ASSERT_EQ(result.status, 0) << result.error;
    EXPECT_EQ(Json::parse(result.output)["result"]["method"], "edges");
    EXPECT_EQ(result.error.find("smoothing up to edges, as " + words[0]) != std::string::npos, words[0] != "--method");
  }
  const Result both =
      marquetry(folder, {"denoise", "noisy.png", "-o", "o.png", "--method", "patches", "--steps", "2"});
  EXPECT_EQ(both.status, 2);
  EXPECT_THAT(both.error, HasSubstr("--steps is of smoothing up to edges"));
  write_bytes(folder / "fan.ply", coloured_ply);
  EXPECT_EQ(marquetry(folder, {"denoise", "fan.ply", "-o", "f.ply", "--method", "patches"}).status, 2);
}

TEST(Denoise, RefusesGuidesThatDoNotFit) {
  const Folder folder;
  write_strip(folder);
  write_image(folder / "small.png", Image<float>(8, 8, 1));
  const Result result =
      marquetry(folder, {"denoise", "strip.obj", "--guide", "small.png", "-o", "clean.png"});
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.error, HasSubstr("small.png: is 8 x 8, and the texture 64 x 48"));
  write_bytes(folder / "fan.ply", coloured_ply);
  EXPECT_EQ(marquetry(folder, {"denoise", "fan.ply", "--guide", "small.png", "-o", "f.ply"}).status,
            2);
  EXPECT_EQ(marquetry(folder, {"denoise", "fan.ply", "-o", "f.ply"}).status, 0);
}

}  // namespace
}  // namespace mq::test
