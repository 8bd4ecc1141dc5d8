#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/models.h"

namespace mq::test {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(Sample, WritesTheSameModelInBothFormats) {
  const Folder folder;
  ASSERT_EQ(marquetry(folder, {"sample", "cube", "-o", "models/", "--size", "64"}).status, 0);
  const Model obj = read_model(folder / "models/cube.obj");
  const Model ply = read_model(folder / "models/cube.ply");
  EXPECT_GT(obj.mesh.triangle_count(), 10);
  EXPECT_EQ(obj.mesh.triangle_count(), ply.mesh.triangle_count());
  ASSERT_EQ(obj.textures.size(), 1U);
  EXPECT_EQ(obj.textures[0].pixels.width(), 64);
  ASSERT_EQ(ply.textures.size(), 1U);
  EXPECT_EQ(obj.textures[0].pixels, ply.textures[0].pixels);
  EXPECT_EQ(marquetry(folder, {"check", "models/cube.obj"}).status, 0);
}

TEST(Sample, SuggestsTheNearestName) {
  const Folder folder;
  const Result result = marquetry(folder, {"sample", "cubee", "-o", "models/"});
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.error, HasSubstr("did you mean 'cube'?"));
  EXPECT_EQ(marquetry(folder, {"sample", "cube", "-o", "cube.png"}).status, 2);
  EXPECT_TRUE(folder.names().empty());
}

TEST(Sample, MakesTheSameAgainOfAReport) {
  const Folder folder;
  for (const std::string name : {"cube", "bending"}) {
    const std::vector<std::string> words = {"sample", name, "-o", name + "/", "--frames", "0-99", "--report", "r.json"};
    ASSERT_EQ(marquetry(folder, words).status, 0);
    const Result again = marquetry(folder, {"sample", "--config", "r.json", "--dry-run"});
    EXPECT_EQ(again.status, 0) << again.error;
  }
  EXPECT_EQ(marquetry(folder, {"sample", "cube", "-o", "cube/", "--frames", "0-9"}).status, 2);
}

TEST(Sample, NamesTheLibraryAmongItsOutputs) {
  const Folder folder;
  write_bytes(folder / "cube.mtl", "newmtl mine\n");
  const Result refused = marquetry(folder, {"sample", "cube", "-o", "cube.obj", "--size", "8", "--no-clobber"});
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.error, HasSubstr("cube.mtl: exists already"));
}

TEST(Sample, MakesNormalMapsThatFilterTakes) {
  const Folder folder;
  ASSERT_EQ(marquetry(folder, {"sample", "sphere", "--normals", "-o", "models/", "--size", "96"}).status, 0);
  const Result filtered =
      marquetry(folder, {"filter", "models/sphere.obj", "--normals", "--beta", "1", "-o", "same.png", "--json"});
  ASSERT_EQ(filtered.status, 0) << filtered.error;
  EXPECT_THAT(filtered.error, Not(HasSubstr("unit length")));
  const Image<float> map = read_model(folder / "models/sphere.obj").textures[0].pixels;
  EXPECT_EQ(read_texture(folder / "same.png").pixels, map);
  ASSERT_EQ(marquetry(folder, {"sample", "wall", "--normals", "-o", "wall/", "--size", "32"}).status, 0);
  EXPECT_NEAR(read_texture(folder / "wall/wall.1001.png").pixels(0, 0, 2), 1, 1e-6);
}

TEST(Sample, RefusesNormalMapsOfWhatHasNone) {
  const Folder folder;
  const Result moving = marquetry(folder, {"sample", "bending", "--normals", "-o", "body/"});
  EXPECT_EQ(moving.status, 2);
  EXPECT_THAT(moving.error, HasSubstr("--normals: a sequence has colours at its vertices"));
  const Result photographs = marquetry(folder, {"sample", "cube", "--normals", "--misaligned", "-o", "cube/"});
  EXPECT_EQ(photographs.status, 2);
  EXPECT_THAT(photographs.error, HasSubstr("--misaligned: "));
  EXPECT_TRUE(folder.names().empty());
}

}  // namespace
}  // namespace mq::test
