// marquetry lic, run as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "cli/models.h"
#include "cli/refusal.h"
#include "mq/io/vector_field.h"

namespace mq::test {
namespace {

using ::testing::HasSubstr;

TEST(Lic, FindsEightHarmonicFieldsOnFourHandles) {
  const Folder folder;
  ASSERT_EQ(marquetry(folder, {"sample", "genus4", "--size", "128", "-o", "g/"}).status, 0);
  const Result result = marquetry(folder, {"lic", "g/genus4.obj", "--field", "harmonic", "--number",
                                           "8", "-o", "h.png", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["harmonic_fields"], 8);
  EXPECT_TRUE(result.json()["solve"]["converged"]);
  const Texture lines = read_texture(folder / "h.png");
  EXPECT_EQ(lines.pixels.width(), 128);
  EXPECT_EQ(lines.pixels.channels(), 3);
  const Result ninth = marquetry(
      folder, {"lic", "g/genus4.obj", "--field", "harmonic", "--number", "9", "-o", "n.png"});
  EXPECT_EQ(ninth.status, 2);
  EXPECT_THAT(ninth.error, HasSubstr("there are 8 harmonic fields"));
}

TEST(Lic, FollowsAFieldFromAFile) {
  const Folder folder;
  write_strip(folder);
  const Model strip = read_model(folder / "strip.obj");
  write_vector_field(folder / "f.vf", strip.mesh,
                     std::vector<Vector3>(std::size_t(strip.mesh.triangle_count()), {1, 0, 0}));
  ASSERT_EQ(marquetry(folder, {"lic", "strip.obj", "--field", "f.vf", "--length", "10%", "--kappa",
                               "100", "--over", "nothing", "-o", "l.png"})
                .status,
            0);
  const Texture lines = read_texture(folder / "l.png");
  double along = 0, across = 0;
  for (int y = 8; y < 40; ++y)
    for (int x = 8; x < 24; ++x) {
      along += std::abs(lines.pixels(x, y) - lines.pixels(x + 1, y));
      across += std::abs(lines.pixels(x, y) - lines.pixels(x, y + 1));
    }
  EXPECT_LT(4 * along, across);  // values spread over less than four texels here
}

/// A field a hundred times as weak in the second square: its lines are neither broader nor fainter, but where that is
/// asked for.
TEST(Lic, DrawsWeakFieldsByLinesOfTheSameWidthAndContrast) {
  const Folder folder;
  write_strip(folder, 320, 240);
  const Model strip = read_model(folder / "strip.obj");
  std::vector<Vector3> field(std::size_t(strip.mesh.triangle_count()), {1, 0, 0});
  for (int t = 0; t < strip.mesh.triangle_count(); ++t)
    if (strip.mesh.position(t, 0).x() + strip.mesh.position(t, 1).x() + strip.mesh.position(t, 2).x() > 3)
      field[std::size_t(t)] *= 0.01;
  write_vector_field(folder / "f.vf", strip.mesh, field);
  struct Half {
    double contrast, slope;
  };
  const auto halves = [&](std::vector<std::string> more) {
    std::vector<std::string> words = {"lic", "strip.obj", "--field", "f.vf", "--over", "nothing", "-o", "l.png", "--overwrite"};
    words.insert(words.end(), more.begin(), more.end());
    EXPECT_EQ(marquetry(folder, words).status, 0);
    const Image<float> image = read_texture(folder / "l.png").pixels;
    std::array<Half, 2> result;
    for (const int half : {0, 1}) {
      double sum = 0, squares = 0, slopes = 0;
      int count = 0;
      for (int y = 48; y < 192; ++y)
        for (int x = 40 + 160 * half; x < 120 + 160 * half; ++x, ++count) {
          const double value = image(x, y);
          sum += value, squares += value * value, slopes += std::pow(image(x, y + 1) - value, 2);
        }
      const double mean = sum / count;
      result[std::size_t(half)].contrast = std::sqrt(squares / count - mean * mean);
      result[std::size_t(half)].slope = std::sqrt(slopes / count) / result[std::size_t(half)].contrast;
    }
    return result;
  };
  const auto [strong, weak] = halves({});
  EXPECT_NEAR(weak.contrast, strong.contrast, 0.1 * strong.contrast);
  EXPECT_NEAR(weak.slope, strong.slope, 0.1 * strong.slope);
  const auto [clear, faded] = halves({"--strength", "scaled"});
  EXPECT_LT(faded.contrast, 0.5 * clear.contrast);
}

/// The same strip with charts of another size, and the second one turned by a quarter.
const char* const strip_cut_anew =
    "mtllib strip.mtl\nusemtl strip\n"
    "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\n"
    "vt 0.1 0.5\nvt 0.4 0.5\nvt 0.4 0.9\nvt 0.1 0.9\n"
    "vt 0.9 0.5\nvt 0.9 0.9\nvt 0.6 0.9\nvt 0.6 0.5\n"
    "f 1/1 2/2 5/3 4/4\nf 2/5 3/6 6/7 5/8\n";

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  double ma = 0, mb = 0, ab = 0, aa = 0, bb = 0;
  for (std::size_t i = 0; i < a.size(); ++i) ma += a[i] / a.size(), mb += b[i] / a.size();
  for (std::size_t i = 0; i < a.size(); ++i)
    ab += (a[i] - ma) * (b[i] - mb), aa += std::pow(a[i] - ma, 2), bb += std::pow(b[i] - mb, 2);
  return ab / std::sqrt(aa * bb);
}

TEST(Lic, ShowsTheSameLinesOnAnyAtlasWhereGrainIsALengthOnTheSurface) {
  const Folder folder;
  write_strip(folder, 320, 240);
  write_bytes(folder / "anew.obj", strip_cut_anew);
  const Model strip = read_model(folder / "strip.obj");
  write_vector_field(folder / "f.vf", strip.mesh,
                     std::vector<Vector3>(std::size_t(strip.mesh.triangle_count()), {3, 1, 0}));
  const auto lines = [&](const std::string& model, const std::string& grain) {
    const Result result =
        marquetry(folder, {"lic", model, "--field", "f.vf", "--length", "0.2", "--over", "nothing",
                           "--grain", grain, "--kappa", "10", "-o", "l.png", "--json"});
    EXPECT_EQ(result.status, 0) << result.error;
    if (grain != "2tx") {
      EXPECT_NEAR(result.json()["result"]["grain"].get<double>(), 0.06, 1e-6);
    }
    return read_texture(folder / "l.png").pixels;
  };
  const auto at = [](const Image<float>& image, double u, double v) {
    return image(int(u * image.width()), int((1 - v) * image.height()));
  };
  for (const std::string grain : {"0.06", "4.2426407%", "2tx"}) {  // 4.24 % of √2 is 0.06
    const Image<float> one = lines("strip.obj", grain), two = lines("anew.obj", grain);
    std::vector<double> a, b;
    for (double x = 0.1; x < 1.9; x += 0.0137)
      for (double y = 0.1; y < 0.9; y += 0.0137) {
        const double s = x < 1 ? x : x - 1;
        a.push_back(at(one, (x < 1 ? 0.05 : 0.55) + 0.4 * s, 0.1 + 0.8 * y));
        b.push_back(x < 1 ? at(two, 0.1 + 0.3 * s, 0.5 + 0.4 * y)
                          : at(two, 0.9 - 0.3 * y, 0.5 + 0.4 * s));
      }
    const double found = correlation(a, b);
    if (grain == "2tx")
      EXPECT_LT(found, 0.5);
    else
      EXPECT_GT(found, 0.9) << grain;
  }
}

/// Two squares, a picture each: grey with alpha, and colours.
TEST(Lic, TakesGradientsOfPicturesWithUnlikeChannels) {
  const Folder folder;
  write_bytes(folder / "two.obj",
              "mtllib two.mtl\nv 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\n"
              "vt 0.1 0.1\nvt 0.9 0.1\nvt 0.9 0.9\nvt 0.1 0.9\n"
              "usemtl a\nf 1/1 2/2 5/3 4/4\nusemtl b\nf 2/1 3/2 6/3 5/4\n");
  write_bytes(folder / "two.mtl", "newmtl a\nmap_Kd a.png\nnewmtl b\nmap_Kd b.png\n");
  Image<float> grey(32, 32, 2, 1.0F), colours(32, 32, 3);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x) {
      grey(x, y) = float(x) / 64;
      for (int c = 0; c < 3; ++c) colours(x, y, c) = 0.4F + float(x) / 64;
    }
  write_image(folder / "a.png", grey);
  write_image(folder / "b.png", colours);
  const Result result =
      marquetry(folder, {"lic", "two.obj", "--field", "gradient", "-o", "lines/"});
  ASSERT_EQ(result.status, 0) << result.error;
  for (const char* name : {"lines/a.png", "lines/b.png"})
    EXPECT_EQ(read_texture(folder / name).pixels.channels(), 3);
}

TEST(Lic, SaysWhatIsMissing) {
  const Folder folder;
  write_strip(folder);
  const auto refused = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"lic", "strip.obj", "-o", "l.png"};
    words.insert(words.end(), more.begin(), more.end());
    return refusal(folder, words, "l.png");
  };
  EXPECT_THAT(refused({}),
              HasSubstr("the field is 0 everywhere: choose another"));  // a plane is not curved
  write_image(folder / "strip.png", Image<float>(64, 48, 3, 0.7F));
  EXPECT_THAT(refused({"--field", "gradient"}),
              HasSubstr("the field is 0 everywhere: choose another"));
  EXPECT_THAT(refused({"--grain", "0"}), HasSubstr("wanted 0.1 to 10000"));
  EXPECT_THAT(refused({"--grain", "1e300"}), HasSubstr("wanted 0.1 to 10000"));
  EXPECT_THAT(refused({"--field", "harmonic"}), HasSubstr("without handles has none"));
  EXPECT_THAT(refused({"--field", "none.vf"}), HasSubstr("none.vf"));
  EXPECT_THAT(refused({"--field", "wind"}), HasSubstr("max-curvature, min-curvature, harmonic"));
}

TEST(Lic, DrawsAtVertices) {
  const Folder folder;
  ASSERT_EQ(marquetry(folder, {"sample", "torus", "--size", "32", "-o", "t/"}).status, 0);
  const Result result =
      marquetry(folder, {"lic", "t/torus.ply", "--vertices", "-o", "l.ply", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(read_model(folder / "l.ply").colors.channels, 3);
}

}  // namespace
}  // namespace mq::test
