// marquetry-mpi stitch gives what marquetry stitch gives, however many processes share the work.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mpi/runs.h"

namespace mq::test {
namespace {

using testing::HasSubstr;

/// The words with an output, and a report on standard output.
Words to(Words words, const std::string& output) {
  words.insert(words.end(), {"-o", output, "--depth", "float", "--json"});
  return words;
}

void expect_picture_of_the_program(const Folder& folder, const Words& words, const std::vector<int>& counts) {
  Words exact = words;
  exact.insert(exact.end(), {"--tolerance", "1e-9"});
  const Result one = marquetry(folder, to(exact, "one.exr"));
  ASSERT_EQ(one.status, 0) << one.error;
  const auto expected = one.json()["result"];
  for (const int processes : counts) {
    const std::string output = "by_" + std::to_string(processes) + ".exr";
    const Result result = mpirun(folder, processes, to(words, output));
    ASSERT_EQ(result.status, 0) << result.error;
    EXPECT_LT(difference(folder / "one.exr", folder / output), 1e-6) << processes << " processes";
    const auto found = result.json()["result"];
    EXPECT_EQ(found["regions"], expected["regions"]);
    EXPECT_EQ(found["unknowns"], expected["unknowns"]);
    EXPECT_NEAR(found["rms_change"].get<double>(), expected["rms_change"].get<double>(), 1e-7);
    if (expected.contains("largest_gain"))
      EXPECT_NEAR(found["largest_gain"].get<double>(), expected["largest_gain"].get<double>(), 1e-9);
  }
}

TEST(SharedStitch, GivesThePictureOfTheProgram) {
  const Folder folder;
  make(folder, {"bust", "--size", "160", "--misaligned", "--depth", "16", "-o", "bust.obj"});
  expect_picture_of_the_program(folder, {"stitch", "bust.obj"}, {1, 2, 4, 7});
  expect_picture_of_the_program(folder, {"stitch", "bust.obj", "--borders", "level", "--exposure", "keep"}, {3});
}

/// Colours that processes find in another order are the same regions.
TEST(SharedStitch, TakesRegionsFromPictures) {
  const Folder folder;
  make(folder, {"bust", "--size", "160", "--misaligned", "--depth", "16", "-o", "bust.obj"});
  Image<float> labels(80, 80, 3);
  for (int y = 0; y < 80; ++y)
    for (int x = 0; x < 80; ++x) labels(x, y, 0) = y < 30 ? 1 : 0, labels(x, y, 2) = (x / 27) / 2.0F;
  write_image(folder / "labels.png", labels);
  expect_picture_of_the_program(folder, {"stitch", "bust.obj", "--labels", "labels.png"}, {3});
}

TEST(SharedStitch, RefusesAPhotographAsLabels) {
  const Folder folder;
  make(folder, {"bust", "--size", "160", "-o", "bust.obj"});
  Image<float> shades(160, 160, 3);
  for (int y = 0; y < 160; ++y)
    for (int x = 0; x < 160; ++x) shades(x, y, 0) = float(x) / 255, shades(x, y, 1) = float(y) / 255;
  write_image(folder / "shades.png", shades);
  const Result refused = mpirun(folder, 2, {"stitch", "bust.obj", "--labels", "shades.png", "-o", "out.png"});
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.error, HasSubstr("shades.png: --labels: found "));
  EXPECT_FALSE(fs::exists(folder / "out.png"));
}

TEST(SharedStitch, SaysWhatItDoesNotDoYet) {
  const Folder folder;
  make(folder, {"bust", "--size", "64", "-o", "bust.obj"});
  Image<float> labels(64, 64, 4);
  write_image(folder / "labels.png", labels);
  const auto refused = [&](const Words& more) {
    Words words{"stitch", "bust.obj", "-o", "out.png"};
    words.insert(words.end(), more.begin(), more.end());
    const Result result = mpirun(folder, 2, words);
    EXPECT_EQ(result.status, 2) << result.error;
    EXPECT_FALSE(fs::exists(folder / "out.png"));
    return result.error;
  };
  EXPECT_THAT(refused({"--labels", "labels.png"}), HasSubstr("is transparent in column"));
  EXPECT_THAT(refused({"--labels", "labels.png", "--labels", "labels.png"}), HasSubstr("2 label pictures for 1 texture"));
  EXPECT_THAT(refused({"--unseen", "0"}), HasSubstr("marquetry stitch does, on one machine"));
  EXPECT_THAT(refused({"--alpha", "1"}), HasSubstr("use marquetry stitch"));
}

}  // namespace
}  // namespace mq::test
