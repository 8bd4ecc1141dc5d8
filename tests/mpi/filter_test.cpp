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
  for (const char* solver : {"multigrid", "boomeramg", "gamg"}) {
    Words all = words;
    all.insert(all.end(), {solver, "-o", std::string(solver) + ".exr"});
    const Result result = mpirun(folder, 2, all);
    ASSERT_EQ(result.status, 0) << result.error;
    EXPECT_LT(difference(folder / "multigrid.exr", folder / (std::string(solver) + ".exr")), 2e-6) << solver;
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
  EXPECT_THAT(refused({"--beta", "0", "-o", "out/", "--mask", "mask.png"}), HasSubstr("marquetry filter does"));
  EXPECT_THAT(refused({"--beta", "2", "-o", "out/"}), HasSubstr("--halo inf"));
  EXPECT_THAT(refused({"--beta", "0", "-o", "out/wall.obj"}), HasSubstr("name a folder"));
  EXPECT_THAT(refused({"-o", "out/"}), HasSubstr("--strength"));
  EXPECT_THAT(refused({"--beta", "0", "--alpha", "1", "-o", "out/"}), HasSubstr("marquetry filter"));
  write_bytes(folder / "wall/wall.1011.png", file_bytes(folder / "wall/wall.1011.png").substr(0, 3000));
  EXPECT_THAT(refused({"--beta", "0", "-o", "out/"}), HasSubstr("wall.1011.png"));
}

}  // namespace
}  // namespace mq::test
