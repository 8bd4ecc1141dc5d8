// marquetry lic, run as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cli/models.h"
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
  ASSERT_EQ(marquetry(folder, {"lic", "strip.obj", "--field", "f.vf", "-o", "l.png"}).status, 0);
  const Texture lines = read_texture(folder / "l.png");
  double along = 0, across = 0;
  for (int y = 8; y < 40; ++y)
    for (int x = 8; x < 24; ++x) {
      along += std::abs(lines.pixels(x, y) - lines.pixels(x + 1, y));
      across += std::abs(lines.pixels(x, y) - lines.pixels(x, y + 1));
    }
  EXPECT_LT(4 * along, across);  // values spread over less than four texels here
}

TEST(Lic, SaysWhatIsMissing) {
  const Folder folder;
  write_strip(folder);
  const auto refused = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"lic", "strip.obj", "-o", "l.png"};
    words.insert(words.end(), more.begin(), more.end());
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 2);
    EXPECT_FALSE(std::filesystem::exists(folder / "l.png"));
    return result.error;
  };
  EXPECT_THAT(refused({}), HasSubstr("it is 0 everywhere"));  // a plane is not curved
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
