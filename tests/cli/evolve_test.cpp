#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/models.h"
#include "cli/refusal.h"
#include "mq/io/evolving_file.h"

namespace mq::test {
namespace {

using testing::HasSubstr;

void make_balls(const Folder& folder, const std::string& frames) {
  ASSERT_EQ(marquetry(folder, {"sample", "merging", "-o", "balls/", "--triangles", "1200",
                               "--frames", frames})
                .status,
            0);
}

std::vector<std::string> evolve(const std::string& output) {
  return {"evolve", "balls", "-o", output, "--size", "128", "--trials", "2", "--json"};
}

TEST(Evolve, FollowsRemeshesAndLaysOut) {
  const Folder folder;
  make_balls(folder, "28-31");
  const Result result = marquetry(folder, evolve("balls.evolving"));
  ASSERT_EQ(result.status, 0) << result.error;
  const auto found = result.json()["result"];
  EXPECT_EQ(found["flipped"], 0);
  ASSERT_EQ(found["frames"].size(), 4U);
  int born = 0, renewed = 0;
  for (const auto& frame : found["frames"]) {
    EXPECT_LT(frame["distance_p95"], 0.01);
    EXPECT_GT(frame["occupancy"], 0.2);
    EXPECT_GT(frame["charts"], 0);
    if (frame["frame"] == 28) continue;
    born += frame["triangles_born"].get<int>();
    renewed += frame["renewed"].get<int>();
  }
  EXPECT_GT(born, 0);  // the balls touch
  EXPECT_GE(renewed, born);
  const EvolvingMesh evolving = EvolvingReader(folder / "balls.evolving").read();
  EXPECT_NO_THROW(check(evolving));
  EXPECT_GT(evolving.segments.size(), 1U);
  for (const EvolvingSegment& segment : evolving.segments) EXPECT_FALSE(segment.uvs.empty());
}

TEST(Evolve, GoesOnWithWhatWasFollowed) {
  const Folder folder;
  make_balls(folder, "28-31");
  ASSERT_EQ(marquetry(folder, evolve("whole.evolving")).status, 0);
  ASSERT_EQ(
      marquetry(folder, {"track", "balls", "-o", "part.evolving", "--remesh", "--frames", "28-30"})
          .status,
      0);
  std::vector<std::string> words = evolve("part.evolving");
  words.push_back("--resume");
  const Result result = marquetry(folder, words);
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("goes on after frame 30"));
  EXPECT_EQ(file_bytes(folder / "part.blocks"), file_bytes(folder / "whole.blocks"));
}

TEST(Evolve, RefusesOtherNames) {
  const Folder folder;
  make_balls(folder, "28-29");
  EXPECT_THAT(refusal(folder, {"evolve", "balls", "-o", "balls.ply"}, "balls.ply"),
              HasSubstr("ends in .evolving"));
}

}  // namespace
}  // namespace mq::test
