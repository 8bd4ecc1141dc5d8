// marquetry-mpi denoise gives what marquetry denoise --method edges gives, however many processes share the work.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mpi/runs.h"

namespace mq::test {
namespace {

using testing::HasSubstr;

Words with(Words words, const Words& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

/// Noise of a deviation of 0.03 to all values.
void add_noise(const fs::path& path) {
  Texture picture = read_texture(path);
  unsigned state = 1;
  for (float& value : picture.pixels.values()) {
    float sum = 0;
    for (int k = 0; k < 12; ++k) {
      state = state * 1664525u + 1013904223u;
      sum += float(state >> 8) / float(1 << 24) - 0.5F;
    }
    value = std::clamp(value + 0.03F * sum, 0.0F, 1.0F);
  }
  write_texture(path, picture);
}

TEST(SharedDenoise, GivesThePictureOfTheProgram) {
  const Folder folder;
  make(folder, {"bust", "--size", "160", "--misaligned", "--depth", "16", "-o", "bust.obj"});
  add_noise(folder / "bust.png");
  struct Asked {
    Words words;
    std::vector<int> processes;
  };
  for (const auto& [asked, counts] :
       {Asked{{}, {1, 8}}, Asked{{"--steps", "2", "--length", "3tx", "--strength", "50"}, {3}}}) {
    const Words words = with({"denoise", "bust.obj", "--depth", "float", "--json"}, asked);
    const Result one = marquetry(folder, with(words, {"--method", "edges", "--tolerance", "1e-9", "-o", "one.exr"}));
    ASSERT_EQ(one.status, 0) << one.error;
    for (const int processes : counts) {
      const Result result = mpirun(folder, processes, with(words, {"-o", "by.exr"}));
      ASSERT_EQ(result.status, 0) << result.error;
      EXPECT_LT(difference(folder / "one.exr", folder / "by.exr"), 1e-6) << processes << " processes";
      const double edge = one.json()["result"]["edge"];
      EXPECT_GT(edge, 0);
      EXPECT_NEAR(result.json()["result"]["edge"].get<double>(), edge, 1e-6 * edge) << processes << " processes";
    }
  }
}

TEST(SharedDenoise, KeepsToAnEdgeAndRefusesWhatItHasNot) {
  const Folder folder;
  make(folder, {"wall", "--tiles", "2", "--size", "64", "--depth", "16", "-o", "wall/"});
  const Result edge = mpirun(folder, 2, {"denoise", "wall/wall.obj", "--edge", "0.02", "-o", "out/"});
  ASSERT_EQ(edge.status, 0) << edge.error;
  ASSERT_EQ(marquetry(folder, {"denoise", "wall/wall.obj", "--edge", "0.02", "-o", "one/"}).status, 0);
  constexpr double step = 1.0 / 65535;
  for (const char* tile : {"wall.1001.png", "wall.1012.png"})
    EXPECT_LT(difference(folder / "one" / tile, folder / "out" / tile), 1.01 * step) << tile;
  const Result guided = mpirun(folder, 2, {"denoise", "wall/wall.obj", "--guide", "g.png", "-o", "out/"});
  EXPECT_EQ(guided.status, 2);
  EXPECT_THAT(guided.error, HasSubstr("marquetry denoise does, on one machine"));
  EXPECT_THAT(mpirun(folder, 2, {"denoise", "wall/wall.obj", "--method", "patches", "-o", "out/"}).error,
              HasSubstr("as marquetry denoise --method edges does"));
}

}  // namespace
}  // namespace mq::test
