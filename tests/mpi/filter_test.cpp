// marquetry-mpi filter gives what marquetry filter gives, however many processes share the work.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "mpi/runs.h"

namespace mq::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

TEST(SharedFilter, GivesThePictureOfTheProgram) {
  const Folder folder;
  make(folder, {"bust", "--size", "192", "--misaligned", "--depth", "16", "-o", "bust.obj"});
  const Words words{"filter", "bust.obj", "--strength", "-100%", "--length", "4%", "--depth", "float"};
  const auto to = [&](Words all, const std::string& output) {
    all.insert(all.end(), {"-o", output, "--json"});
    return all;
  };
  Words exact = words;
  exact.insert(exact.end(), {"--tolerance", "1e-9"});
  ASSERT_EQ(marquetry(folder, to(exact, "one.exr")).status, 0);
  int least = 1000, most = 0;
  for (const int processes : {1, 2, 4, 8}) {
    const std::string output = "by_" + std::to_string(processes) + ".exr";
    const Result result = mpirun(folder, processes, to(words, output));
    ASSERT_EQ(result.status, 0) << result.error;
    EXPECT_LT(difference(folder / "one.exr", folder / output), 1e-6) << processes << " processes";
    const auto json = result.json();
    EXPECT_TRUE(json["solve"]["converged"]);
    EXPECT_EQ(json["result"]["processes"].size(), std::size_t(processes));
    least = std::min(least, json["solve"]["cycles"].get<int>());
    most = std::max(most, json["solve"]["cycles"].get<int>());
  }
  EXPECT_LE(most - least, 1);
}

TEST(SharedFilter, WritesEveryTileOfAWallTheSameTwice) {
  const Folder folder;
  make(folder, {"wall", "--tiles", "2", "--size", "96", "--misaligned", "--depth", "16", "-o", "wall/"});
  const Words words{"filter", "wall/wall.obj", "--beta", "0", "--length", "6tx"};
  const auto to = [&](const std::string& output) {
    Words all = words;
    all.insert(all.end(), {"-o", output});
    return all;
  };
  ASSERT_EQ(marquetry(folder, to("one/")).status, 0);
  for (const char* output : {"first/", "again/"}) {
    const Result result = mpirun(folder, 3, to(output));
    ASSERT_EQ(result.status, 0) << result.error;
  }
  constexpr double step = 1.0 / 65535;
  for (const char* tile : {"wall.1001.png", "wall.1002.png", "wall.1011.png", "wall.1012.png"}) {
    EXPECT_LT(difference(folder / "one" / tile, folder / "first" / tile), 1.01 * step) << tile;
    EXPECT_GT(difference(folder / "wall" / tile, folder / "first" / tile), 10 * step) << tile;
    EXPECT_EQ(file_bytes(folder / "first" / tile), file_bytes(folder / "again" / tile)) << tile;
  }
}

TEST(SharedFilter, ReachesTheSameByOtherSolvers) {
  const Folder folder;
  make(folder, {"wall", "--tiles", "1", "--size", "128", "--depth", "16", "-o", "wall/"});
  const Words words{"filter", "wall/wall.obj", "--beta", "0", "--depth", "float", "--solver"};
  for (const char* solver : {"multigrid", "boomeramg", "gamg", "bddc"}) {
    Words all = words;
    all.insert(all.end(), {solver, "-o", std::string(solver) + ".exr"});
    const Result result = mpirun(folder, 2, all);
    ASSERT_EQ(result.status, 0) << result.error;
    EXPECT_LT(difference(folder / "multigrid.exr", folder / (std::string(solver) + ".exr")), 2e-6) << solver;
  }
}

// At seams a process's own elements determine its matrix badly.
TEST(SharedFilter, BalancesByConstraintsOverManySeams) {
  const Folder folder;
  make(folder, {"bust", "--size", "96", "--misaligned", "--depth", "16", "-o", "bust.obj"});
  const Words words{"filter", "bust.obj", "--beta", "0", "--alpha", "1e-3", "--depth", "float", "--tolerance", "1e-7", "--json"};
  const auto to = [&](const std::string& output, const std::string& solver) {
    Words all = words;
    all.insert(all.end(), {"--solver", solver, "-o", output});
    return all;
  };
  ASSERT_EQ(mpirun(folder, 1, to("one.exr", "multigrid")).status, 0);
  for (const int processes : {1, 2, 3, 5, 8}) {
    const Result result = mpirun(folder, processes, to("by.exr", "bddc"));
    ASSERT_EQ(result.status, 0) << processes << " processes: " << result.error;
    EXPECT_LT(difference(folder / "one.exr", folder / "by.exr"), 1e-6) << processes << " processes";
    EXPECT_LT(result.json()["solve"]["cycles"].get<int>(), 30) << processes << " processes";
  }
}

TEST(SharedFilter, SharpensTheBrightnessOfColours) {
  const Folder folder;
  make(folder, {"wall", "--tiles", "2", "--size", "64", "--depth", "16", "-o", "wall/"});
  const Words words{"filter", "wall/wall.obj", "--strength", "60%", "--halo", "inf"};
  const auto to = [&](const std::string& output) {
    Words all = words;
    all.insert(all.end(), {"-o", output});
    return all;
  };
  ASSERT_EQ(marquetry(folder, to("one/")).status, 0);
  const Result result = mpirun(folder, 2, to("two/"));
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_LT(difference(folder / "one/wall.1012.png", folder / "two/wall.1012.png"), 1.01 / 65535);
}

/// Picture by picture and in the report, as by the program; the words are those of both.
void expect_the_pictures_of_the_program(const Folder& folder, Words words, const std::vector<std::string>& pictures,
                                        const std::vector<int>& counts) {
  words.insert(words.begin(), {"filter", "wall/wall.obj", "--depth", "16"});
  const auto to = [&](const std::string& output, const std::string& tolerance) {
    Words all = words;
    all.insert(all.end(), {"-o", output, "--json", "--tolerance", tolerance});
    return all;
  };
  const Result one = marquetry(folder, to("one/", "1e-9"));
  ASSERT_EQ(one.status, 0) << one.error;
  const auto expected = one.json()["result"];
  for (const int processes : counts) {
    const std::string output = "by_" + std::to_string(processes) + "/";
    const Result result = mpirun(folder, processes, to(output, "1e-7"));
    ASSERT_EQ(result.status, 0) << result.error;
    for (const std::string& picture : pictures)
      EXPECT_LT(difference(folder / "one" / picture, folder / output / picture), 1.01 / 65535) << picture;
    const auto found = result.json()["result"];
    EXPECT_EQ(found["halo"], expected["halo"]);
    EXPECT_EQ(found["threshold"], expected["threshold"]);
    EXPECT_EQ(found.contains("mask"), expected.contains("mask"));
    if (expected.contains("mask"))
      for (const char* key : {"mean", "share", "below_0"})
        EXPECT_NEAR(found["mask"][key].get<double>(), expected["mask"][key].get<double>(), 1e-9) << key;
  }
}

const std::vector<std::string> tiles = {"wall.1001.png", "wall.1002.png", "wall.1011.png", "wall.1012.png"};

TEST(SharedFilter, SharpensWithoutHalos) {
  const Folder folder;
  make(folder, {"wall", "--tiles", "2", "--size", "96", "--misaligned", "-o", "wall/"});
  expect_the_pictures_of_the_program(folder, {"--strength", "200%"}, tiles, {1, 3});
  expect_the_pictures_of_the_program(folder, {"--beta", "3", "--length", "4tx", "--halo", "0.1", "--threshold", "0.05"},
                                     tiles, {2});
  make(folder, {"wall", "--tiles", "2", "--size", "64", "--depth", "16", "-o", "wall/"});
  expect_the_pictures_of_the_program(folder, {"--strength", "200%"}, tiles, {2});  // the threshold is of 8 bits
  EXPECT_GT(difference(folder / "wall/wall.1001.png", folder / "one/wall.1001.png"), 0.02);
}

TEST(SharedFilter, WorksWhereMasksAndSpotsSay) {
  const Folder folder;
  make(folder, {"wall", "--tiles", "2", "--size", "64", "--misaligned", "-o", "wall/"});
  Words words{"--beta", "0"};
  for (int k = 0; k < 4; ++k) {  // of other sizes than the textures, and smoothing less and less
    Image<float> mask(20, 30, 1);
    for (int y = 0; y < 30; ++y)
      for (int x = 0; x < 20; ++x) mask(x, y) = float((x + 3 * y + 5 * k) % 20) / 20;
    write_image(folder / ("mask_" + std::to_string(k) + ".png"), mask);
    words.insert(words.end(), {"--mask", "mask_" + std::to_string(k) + ".png"});
  }
  expect_the_pictures_of_the_program(folder, words, tiles, {3});
  expect_the_pictures_of_the_program(
      folder, {"--beta", "0", "--spot", "0.5,0.5,0,20%", "--spot", "texel2,20,40,9tx,-0.5", "--spot", "texel,30,30,8tx"},
      tiles, {1, 4});
}

TEST(SharedFilter, SaysOnceWhatIsWrongAndLeavesNothing) {
  const Folder folder;
  make(folder, {"wall", "--tiles", "2", "--size", "64", "-o", "wall/"});
  const auto refused = [&](const Words& more) {
    Words words{"filter", "wall/wall.obj"};
    words.insert(words.end(), more.begin(), more.end());
    const Result result = mpirun(folder, 3, words);
    EXPECT_EQ(result.status, 2) << result.error;
    EXPECT_FALSE(fs::exists(folder / "out"));
    const std::string said = "marquetry-mpi filter: ";
    const auto last = result.error.rfind(said);
    EXPECT_NE(last, std::string::npos) << result.error;
    const std::string message = result.error.substr(last, 60);
    EXPECT_EQ(result.error.find(message), last) << "said once: " << result.error;
    return result.error;
  };
  EXPECT_THAT(refused({"--beta", "0", "-o", "out/", "--geometry"}), HasSubstr("marquetry filter does"));
  EXPECT_THAT(refused({"--beta", "0", "-o", "out/", "--mask", "wall/wall.obj"}), HasSubstr("is a model"));
  EXPECT_THAT(refused({"--beta", "0", "-o", "out/", "--mask", "wall/wall.1001.png"}), HasSubstr("--mask"));
  EXPECT_THAT(refused({"--beta", "0", "-o", "out/", "--spot", "texel,1000,2,5tx"}), HasSubstr("no chart of"));
  EXPECT_THAT(refused({"--beta", "0", "-o", "out/wall.obj"}), HasSubstr("name a folder"));
  EXPECT_THAT(refused({"-o", "out/"}), HasSubstr("--strength"));
  EXPECT_THAT(refused({"--beta", "0", "--alpha", "1", "-o", "out/"}), HasSubstr("marquetry filter"));
  write_bytes(folder / "wall/wall.1011.png", file_bytes(folder / "wall/wall.1011.png").substr(0, 3000));
  EXPECT_THAT(refused({"--beta", "0", "-o", "out/"}), HasSubstr("wall.1011.png"));
}

}  // namespace
}  // namespace mq::test
