// marquetry-mpi geodesic gives the distances of marquetry geodesic, however many processes share the work.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "mpi/runs.h"

namespace mq::test {
namespace {

using testing::HasSubstr;

/// The words with an output, and a report on standard output.
Words measured(Words words, const std::string& output, const std::string& tolerance) {
  words.insert(words.begin(), "geodesic");
  words.insert(words.end(), {"-o", output, "--tolerance", tolerance, "--json"});
  return words;
}

double mean_difference(const fs::path& a, const fs::path& b) {
  const Texture first = read_texture(a), second = read_texture(b);
  double sum = 0;
  for (std::size_t i = 0; i < first.pixels.values().size(); ++i)
    sum += std::abs(double(first.pixels.values()[i]) - double(second.pixels.values()[i]));
  return sum / double(first.pixels.values().size());
}

/// Distances differ by less than these shares of the largest: at most, and on average.
constexpr double share = 1e-6, mean_share = 1e-8;

void expect_distances_of_the_program(const Folder& folder, const Words& words, const std::vector<int>& counts) {
  const Result one = marquetry(folder, measured(words, "one.exr", "1e-9"));
  ASSERT_EQ(one.status, 0) << one.error;
  const auto expected = one.json()["result"];
  const double most = expected["max"].get<double>();
  for (const int processes : counts) {
    const std::string output = "by_" + std::to_string(processes) + ".exr";
    const Result result = mpirun(folder, processes, measured(words, output, "1e-8"));
    ASSERT_EQ(result.status, 0) << result.error;
    EXPECT_LT(difference(folder / "one.exr", folder / output), share * most) << processes << " processes";
    EXPECT_LT(mean_difference(folder / "one.exr", folder / output), mean_share * most) << processes << " processes";
    const auto json = result.json();
    EXPECT_TRUE(json["solve"]["converged"]);
    const auto found = json["result"];
    for (const char* count : {"sources", "unreached"}) EXPECT_EQ(found[count], expected[count]) << count;
    EXPECT_NEAR(found["max"].get<double>(), most, share * most);
    EXPECT_EQ(found["processes"].size(), std::size_t(processes));
  }
}

/// The charts of this bust share texels at their borders.
TEST(SharedGeodesic, GivesTheDistancesOfTheProgram) {
  const Folder folder;
  make(folder, {"bust", "--size", "96", "-o", "bust.obj"});
  expect_distances_of_the_program(folder, {"bust.obj", "--from", "0,0.3,1"}, {1, 2, 4, 8});
}

TEST(SharedGeodesic, BeginsAtManyPlacesAndEndsAtBoundaries) {
  const Folder folder;
  make(folder, {"wall", "--tiles", "1", "--size", "96", "-o", "wall/"});
  expect_distances_of_the_program(
      folder, {"wall/wall.obj", "--from", "0.9,0.1,0", "--from", "vertex,3", "--from", "texel,40,70"}, {3});
}

TEST(SharedGeodesic, WritesEveryTileOfAWallTheSameTwice) {
  const Folder folder;
  make(folder, {"wall", "--tiles", "2", "--size", "96", "--misaligned", "-o", "wall/"});
  const Words words{"wall/wall.obj", "--from", "0.2,0.1,0"};
  ASSERT_EQ(marquetry(folder, measured(words, "one/", "1e-9")).status, 0);
  for (const char* output : {"first/", "again/"})
    ASSERT_EQ(mpirun(folder, 3, measured(words, output, "1e-8")).status, 0);
  for (const char* tile : {"wall.1001.png", "wall.1002.png", "wall.1011.png", "wall.1012.png"}) {
    EXPECT_LT(difference(folder / "one" / tile, folder / "first" / tile), 1.01 / 255) << tile;
    EXPECT_EQ(file_bytes(folder / "first" / tile), file_bytes(folder / "again" / tile)) << tile;
  }
}

/// Three squares beside each other, which do not touch.
void make_islands(const Folder& folder) {
  std::string obj = "mtllib islands.mtl\nusemtl one\n", faces;
  for (int k = 0; k < 3; ++k)
    for (int corner = 0; corner < 4; ++corner) {
      const int x = (corner == 1 || corner == 2), y = corner >= 2;
      obj += "v " + std::to_string(2 * k + x) + " " + std::to_string(y) + " 0\n";
      obj += "vt " + std::to_string(0.05 + 0.32 * k + 0.26 * x) + " " + std::to_string(0.1 + 0.3 * y) + "\n";
      const std::string number = std::to_string(4 * k + corner + 1);
      faces += (corner == 0 ? "f " : " ") + number + "/" + number + (corner == 3 ? "\n" : "");
    }
  write_bytes(folder / "islands.obj", obj + faces);
  write_bytes(folder / "islands.mtl", "newmtl one\nmap_Kd islands.png\n");
  write_image(folder / "islands.png", Image<float>(96, 96, 3));
}

TEST(SharedGeodesic, TakesMasksAndSaysWhereNoPathLeads) {
  const Folder folder;
  make_islands(folder);
  Image<float> mask(96, 96, 1);
  for (int y = 60; y < 66; ++y)
    for (int x = 8; x < 20; ++x) mask(x, y) = 1;
  write_image(folder / "mask.png", mask);
  expect_distances_of_the_program(folder, {"islands.obj", "--from-mask", "mask.png", "--from", "4.5,0.5,0"}, {3});
}

TEST(SharedGeodesic, SaysOnceWhatIsWrongAndLeavesNothing) {
  const Folder folder;
  make(folder, {"bust", "--size", "64", "-o", "bust.obj"});
  const auto refused = [&](const Words& more) {
    Words words{"geodesic", "bust.obj", "-o", "out.exr"};
    words.insert(words.end(), more.begin(), more.end());
    const Result result = mpirun(folder, 2, words);
    EXPECT_EQ(result.status, 2) << result.error;
    EXPECT_FALSE(fs::exists(folder / "out.exr"));
    return result.error;
  };
  EXPECT_THAT(refused({}), HasSubstr("say where distances begin"));
  EXPECT_THAT(refused({"--from", "texel,0,0"}), HasSubstr("no chart of"));
  EXPECT_THAT(refused({"--from", "vertex,0", "--vertices"}), HasSubstr("marquetry geodesic does, on one machine"));
}

}  // namespace
}  // namespace mq::test
