// marquetry fields, run as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>

#include <fmt/format.h>

#include "cli/models.h"
#include "mq/io/bytes.h"
#include "mq/io/vector_field.h"

namespace mq::test {
namespace {

using ::testing::HasSubstr;

/// The strip of models.h lies in the plane; a stroke from its left to its right.
void write_stroke(const Folder& folder, const Model& model) {
  const Vector3 a = model.mesh.positions.front(), b = model.mesh.positions[std::size_t(model.mesh.triangles.back()[0])];
  write_bytes(folder / "strokes.json", fmt::format(R"({{"strokes": [{{"points": [[{}, {}, {}], [{}, {}, {}]]}}]}})", a.x(), a.y(),
                                           a.z(), b.x(), b.y(), b.z()));
}

TEST(Fields, OfOneStrokeOnAFlatModelIsParallelAndAMapSaysSo) {
  const Folder folder;
  write_strip(folder);
  const Model strip = read_model(folder / "strip.obj");
  write_stroke(folder, strip);
  const Result result = marquetry(folder, {"fields", "strip.obj", "--field", "strokes.json", "-o", "f.ply", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  const VectorField field = read_vector_field(folder / "f.ply", strip.mesh);
  const Vector3 along =
      (strip.mesh.positions[std::size_t(strip.mesh.triangles.back()[0])] - strip.mesh.positions.front()).normalized();
  for (const Vector3& X : field.vectors) EXPECT_LT((X - along).norm(), 0.02);

  ASSERT_EQ(marquetry(folder, {"fields", "strip.obj", "--field", "f.ply", "-o", "map.png"}).status, 0);
  ASSERT_EQ(marquetry(folder, {"fields", "strip.obj", "--field", "map.png", "-o", "back.ply"}).status, 0);
  for (const Vector3& X : read_vector_field(folder / "back.ply", strip.mesh).vectors) EXPECT_LT((X - along).norm(), 0.02);
  ASSERT_EQ(marquetry(folder, {"fields", "strip.obj", "--field", "strokes.json", "-o", "same.png"}).status, 0);
  const Image<float> map = read_texture(folder / "map.png").pixels, same = read_texture(folder / "same.png").pixels;
  ASSERT_EQ(map.channels(), 3);
  ASSERT_EQ(map.width(), strip.textures.front().pixels.width());
  int inside = 0;
  for (int y = 0; y < map.height(); ++y)
    for (int x = 0; x < map.width(); ++x) {
      if (map(x, y, 2) == 0) continue;
      ++inside;
      const std::complex<double> direction(2 * map(x, y, 0) - 1, 2 * map(x, y, 1) - 1);
      EXPECT_NEAR(std::abs(direction), 1, 1e-3);
      EXPECT_NEAR(map(x, y, 2), 1, 0.02);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(map(x, y, c), same(x, y, c), 0.02);
    }
  EXPECT_GT(inside, 100);
}

TEST(Fields, AreTakenApartIntoFilesThatSumToTheWhole) {
  const Folder folder;
  ASSERT_EQ(marquetry(folder, {"sample", "torus", "--size", "64", "-o", "t/"}).status, 0);
  const Result result =
      marquetry(folder, {"fields", "t/torus.obj", "--field", "max-curvature", "-o", "parts/", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  const Mesh mesh = read_model(folder / "t/torus.obj").mesh;
  const auto part = [&](const std::string& name) {
    return read_vector_field(folder / ("parts/torus_" + name + ".ply"), mesh).vectors;
  };
  const auto whole = part("whole"), gradient = part("gradient"), curl = part("curl"), harmonic = part("harmonic");
  for (std::size_t t = 0; t < whole.size(); ++t)
    EXPECT_LT((gradient[t] + curl[t] + harmonic[t] - whole[t]).norm(), 1e-9 * (1 + whole[t].norm()));
  const auto shares = result.json()["result"]["shares"];
  EXPECT_NEAR(shares["gradient"].get<double>() + shares["curl"].get<double>() + shares["harmonic"].get<double>(), 1, 1e-9);
  EXPECT_EQ(read_model(folder / "parts/torus_potential.ply").mesh.vertex_count(), mesh.vertex_count());
  EXPECT_EQ(result.json()["result"]["outputs"].size(), 6U);
  // A harmonic field is all harmonic.
  const Result one = marquetry(folder, {"fields", "t/torus.obj", "--field", "harmonic", "--number", "2", "--part",
                                        "harmonic", "-o", "h.vf", "--json"});
  ASSERT_EQ(one.status, 0) << one.error;
  EXPECT_NEAR(one.json()["result"]["shares"]["harmonic"].get<double>(), 1, 1e-9);
  EXPECT_EQ(one.json()["result"]["harmonic_fields"], 2);
}

TEST(Fields, SteerLicReactAndFilter) {
  const Folder folder;
  write_strip(folder);
  write_stroke(folder, read_model(folder / "strip.obj"));
  EXPECT_EQ(marquetry(folder, {"lic", "strip.obj", "--field", "strokes.json", "-o", "l.png"}).status, 0);
  EXPECT_EQ(marquetry(folder, {"react", "strip.obj", "--field", "strokes.json", "--scale", "10%", "--time", "20", "-o",
                               "r.png"}).status, 0);
  const std::vector<std::string> smooth = {"filter", "strip.obj", "--strength", "-100", "--radius", "4tx", "-o"};
  const auto with = [&](std::vector<std::string> more) {
    std::vector<std::string> words = smooth;
    words.insert(words.end(), more.begin(), more.end());
    return marquetry(folder, words);
  };
  ASSERT_EQ(with({"all.png"}).status, 0);
  ASSERT_EQ(with({"along.png", "--field", "strokes.json"}).status, 0);
  ASSERT_EQ(with({"no.png", "--field", "strokes.json", "--kappa", "0"}).status, 0);
  EXPECT_TRUE(read_texture(folder / "all.png").pixels == read_texture(folder / "no.png").pixels) << "kappa 0 is no metric";
  EXPECT_FALSE(read_texture(folder / "all.png").pixels == read_texture(folder / "along.png").pixels);
}

/// Low contrast is sharpened as the equation says, in the metric of the field too.
TEST(Fields, SteerSharpeningWithinHalosAsWithout) {
  const Folder folder;
  write_strip(folder);
  write_stroke(folder, read_model(folder / "strip.obj"));
  Image<float> faint = read_texture(folder / "strip.png").pixels;
  for (float& value : faint.values()) value = 0.5F + 0.05F * value;
  write_image(folder / "strip.png", faint);
  const auto sharpened = [&](const std::string& halo) {
    const std::string out = halo + ".exr";
    const Result result = marquetry(folder, {"filter", "strip.obj", "--field", "strokes.json", "--beta", "3", "--alpha", "1e-3",
                                             "--halo", halo, "--depth", "float", "-o", out});
    EXPECT_EQ(result.status, 0) << result.error;
    return read_texture(folder / out).pixels;
  };
  const Image<float> wide = sharpened("0.2"), without = sharpened("inf");
  float largest = 0;
  for (std::size_t i = 0; i < wide.values().size(); ++i)
    largest = std::max(largest, std::abs(wide.values()[i] - without.values()[i]));
  EXPECT_LT(largest, 1e-4);
}

TEST(Fields, HaveAMapForEachTextureThatIsReadBackBySuchAName) {
  const Folder folder;
  write_bytes(folder / "two.obj",
              "mtllib two.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 3 0 0\nv 3 1 0\nv 2 1 0\n"
              "vt 0.1 0.1\nvt 0.9 0.1\nvt 0.9 0.9\nvt 0.1 0.9\nusemtl a\nf 1/1 2/2 3/3 4/4\n"
              "usemtl b\nf 5/2 6/3 7/4 8/1\n");  // the second one turned
  write_bytes(folder / "two.mtl", "newmtl a\nmap_Kd a.png\nnewmtl b\nmap_Kd b.png\n");
  write_image(folder / "a.png", busy_picture(32, 32));
  write_image(folder / "b.png", busy_picture(24, 24));
  write_bytes(folder / "strokes.json", R"({"strokes": [{"points": [[0.1, 0.5, 0], [0.9, 0.5, 0]]},
                                                      {"points": [[2.1, 0.5, 0], [2.9, 0.5, 0]]}]})");
  ASSERT_EQ(marquetry(folder, {"fields", "two.obj", "--field", "strokes.json", "-o", "map_%s.png"}).status, 0);
  const Result back = marquetry(folder, {"fields", "two.obj", "--field", "map_%s.png", "-o", "back.ply"});
  ASSERT_EQ(back.status, 0) << back.error;
  for (const Vector3& X : read_vector_field(folder / "back.ply", read_model(folder / "two.obj").mesh).vectors)
    EXPECT_LT((X - Vector3(1, 0, 0)).norm(), 0.05);
  const Result one = marquetry(folder, {"fields", "two.obj", "--field", "map_a.png", "-o", "one.ply"});
  EXPECT_EQ(one.status, 2);
  EXPECT_THAT(one.error, HasSubstr("put %s in its name"));
}

TEST(Fields, AreRefusedWhereTheyCannotBe) {
  const Folder folder;
  write_strip(folder);
  const auto refused = [&](std::vector<std::string> words, const std::string& why) {
    words.insert(words.begin(), {"fields", "strip.obj"});
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 2) << why;
    EXPECT_THAT(result.error, HasSubstr(why));
  };
  refused({"--field", "none.json", "-o", "f.ply"}, "none.json");
  write_bytes(folder / "far.json", R"({"strokes": [{"points": [[900, 0, 0], [901, 0, 0]]}]})");
  refused({"--field", "far.json", "-o", "f.ply"}, "other units");
  write_bytes(folder / "out.json", R"({"strokes": [{"uv": [[3, 3], [4, 4]]}]})");
  refused({"--field", "out.json", "-o", "f.ply"}, "lies nowhere");
  write_bytes(folder / "texture.json", R"({"strokes": [{"uv": [[0, 0], [1, 1]], "texture": 7}]})");
  refused({"--field", "texture.json", "-o", "f.ply"}, "found 7, wanted one of 1");
  write_bytes(folder / "point.json", R"({"strokes": [{"points": [[1, 0, 0], [1, 0, 0]]}]})");
  refused({"--field", "point.json", "-o", "f.ply"}, "2 points that are one");
  write_image(folder / "black.png", Image<float>(8, 8, 3, 0.0F));
  refused({"--field", "black.png", "-o", "f.ply"}, "0 everywhere");
  refused({"-o", "f.ply"}, "--field");
  refused({"--field", "max-curvature", "-o", "f.obj"}, "wanted .ply or .vf");
  refused({"--field", "max-curvature", "--part", "curl", "-o", "parts/"}, "a folder gets all parts");
  const Result lonely = marquetry(folder, {"filter", "strip.obj", "--strength", "50", "--kappa", "3", "-o", "f.png"});
  EXPECT_EQ(lonely.status, 2);
  EXPECT_THAT(lonely.error, HasSubstr("name one with --field"));
}

}  // namespace
}  // namespace mq::test
