// marquetry-mpi seams and fill give what marquetry gives, however many processes share the work.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mpi/runs.h"

namespace mq::test {
namespace {

using testing::HasSubstr;

TEST(SharedSeams, GiveThePicturesOfTheProgram) {
  const Folder folder;
  make(folder, {"bust", "--size", "160", "--misaligned", "--depth", "16", "-o", "bust.obj"});
  for (const Words& words :
       {Words{"seams", "bust.obj"}, Words{"seams", "bust.obj", "--weight", "3"}, Words{"fill", "bust.obj"},
        Words{"fill", "bust.obj", "--weight", "0", "--distance", "3"}}) {
    const auto to = [&](const std::string& output) {
      Words all = words;
      all.insert(all.end(), {"-o", output, "--depth", "float", "--overwrite", "--json"});
      return all;
    };
    const Result one = marquetry(folder, to("one.exr"));
    ASSERT_EQ(one.status, 0) << one.error;
    const auto expected = one.json()["result"];
    const Result result = mpirun(folder, 3, to("by.exr"));
    ASSERT_EQ(result.status, 0) << result.error;
    EXPECT_LT(difference(folder / "one.exr", folder / "by.exr"), 1e-6) << words[0];
    const auto found = result.json()["result"];
    for (const char* count : {"unknowns", "seam_texels", "border_texels", "outside_texels"})
      if (expected.contains(count)) EXPECT_EQ(found[count], expected[count]) << count;
    EXPECT_NEAR(found["rms_change"].get<double>(), expected["rms_change"].get<double>(), 1e-7);
  }
}

/// What is outside charts is filled where a picture is written, whoever has the texels at its borders.
TEST(SharedSeams, FillEveryPictureOfAWall) {
  const Folder folder;
  make(folder, {"wall", "--tiles", "2", "--size", "96", "--misaligned", "--depth", "16", "-o", "wall/"});
  for (const char* verb : {"seams", "fill"}) {
    ASSERT_EQ(marquetry(folder, {verb, "wall/wall.obj", "-o", "one/", "--overwrite"}).status, 0);
    const Result shared = mpirun(folder, 3, {verb, "wall/wall.obj", "-o", "by/", "--overwrite"});
    ASSERT_EQ(shared.status, 0) << shared.error;
    for (const char* tile : {"wall.1001.png", "wall.1002.png", "wall.1011.png", "wall.1012.png"})
      EXPECT_LT(difference(folder / "one" / tile, folder / "by" / tile), 2.0 / 65535) << verb << ' ' << tile;
  }
}

TEST(SharedSeams, SayWhatTheyDoNotDoYet) {
  const Folder folder;
  make(folder, {"bust", "--size", "64", "-o", "bust.obj"});
  for (const char* verb : {"seams", "fill"})
    EXPECT_THAT(mpirun(folder, 2, {verb, "bust.obj", "-o", "out.png", "--normals"}).error,
                HasSubstr(std::string("marquetry ") + verb + " does, on one machine"));
}

}  // namespace
}  // namespace mq::test
