// track --shard and --motion: a sequence that is followed in parts, and joined.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "cli/moving_body.h"
#include "cli/refusal.h"
#include "mq/io/evolving_file.h"
#include "places.h"

namespace mq::test {
namespace {

using testing::HasSubstr;
using Words = std::vector<std::string>;

/// Frames 0 to 7 of a body that bends, and how they are followed.
struct Body {
  Folder folder;
  Body() { make_body(folder, "bending", 7); }

  Words track(const Words& more) const {
    Words words = {"track", "body", "--nodes", "10", "--truth", "body/material"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  void follow_part(int part, int count) const {
    const std::string shard = std::to_string(part) + "/" + std::to_string(count);
    const Result result = marquetry(folder, track({"-o", "part_%d.evolving", "--shard", shard}));
    ASSERT_EQ(result.status, 0) << result.error;
  }
  Result join(const std::string& output = "joined.evolving") const {
    return marquetry(folder, track({"-o", output, "--motion", "part_%d.evolving", "--json"}));
  }
};

TEST(TrackParts, AreJoinedToOneMeshThatIsAsNearAndAsTrueAsThatOfOneRun) {
  const Body body;
  for (int part = 1; part <= 3; ++part) body.follow_part(part, 3);
  const EvolvingReader second(body.folder / "part_2.evolving");
  ASSERT_EQ(second.frames().size(), 3U);
  EXPECT_EQ(second.frames()[0].number, 2);
  const Result whole = marquetry(body.folder, body.track({"-o", "whole.evolving", "--json"})), joined = body.join();
  ASSERT_EQ(joined.status, 0) << joined.error;
  const auto in_one = whole.json()["result"]["frames"], in_parts = joined.json()["result"]["frames"];
  ASSERT_EQ(in_parts.size(), 8U);
  for (std::size_t f = 1; f < 8; ++f) {
    EXPECT_EQ(in_parts[f]["triangles_kept"], in_one[f]["triangles_kept"]) << f;
    EXPECT_LT(in_parts[f]["distance_p95"], 1.3 * in_one[f]["distance_p95"].get<double>()) << f;
    EXPECT_LT(in_parts[f]["drift"]["mean_edges"], in_one[f]["drift"]["mean_edges"].get<double>() + 0.1) << f;
    EXPECT_EQ(in_parts[f].contains("known_motion"), f != 2 && f != 5) << f;
  }
}

TEST(TrackParts, ThatAreMissingOrStoppedAreRefusedAndMadeAgain) {
  const Body body;
  for (const int part : {1, 2}) body.follow_part(part, 2);
  ASSERT_EQ(body.join().status, 0);
  const std::string blocks = file_bytes(body.folder / "joined.blocks");
  const EvolvingReader second(body.folder / "part_2.evolving");
  const auto cut = std::size_t(second.frames()[1].offset + 3);
  write_bytes(body.folder / "part_2.blocks", file_bytes(body.folder / "part_2.blocks").substr(0, cut));
  EXPECT_THAT(body.join("again.evolving").error, HasSubstr("part_2.evolving: "));
  std::filesystem::remove(body.folder / "part_2.evolving");
  const Result refused = body.join("again.evolving");
  EXPECT_EQ(refused.status, 2);
  EXPECT_EQ(marquetry(body.folder, body.track({"-o", "again.evolving", "--motion", "part_%d.evolving", "--dry-run"})).status, 2);
  EXPECT_THAT(refused.error, HasSubstr("--motion: 4 frames are in no part, from number 4 to 7"));
  EXPECT_FALSE(std::filesystem::exists(body.folder / "again.evolving"));
  body.follow_part(2, 2);
  ASSERT_EQ(body.join("again.evolving").status, 0);
  EXPECT_TRUE(file_bytes(body.folder / "again.blocks") == blocks);
}

TEST(TrackParts, AreNotReplacedByTheWholeAndNotForgottenByIt) {
  const Body body;
  for (const int part : {1, 2}) body.follow_part(part, 2);
  const std::string blocks = file_bytes(body.folder / "part_2.blocks");
  EXPECT_EQ(body.join("part_2.evolving").status, 2);
  EXPECT_TRUE(file_bytes(body.folder / "part_2.blocks") == blocks);
  ASSERT_EQ(body.join().status, 0);
  const Words again = body.track({"-o", "joined.evolving", "--motion", "part_%d.evolving", "--resume"});
  EXPECT_EQ(marquetry(body.folder, again).status, 0);
  ASSERT_EQ(marquetry(body.folder, body.track({"-o", "part_%d.evolving", "--shard", "2/2", "--elasticity", "0.5"})).status, 0);
  const Result others = marquetry(body.folder, again);
  EXPECT_EQ(others.status, 2);
  EXPECT_THAT(others.error, HasSubstr("the parts of --motion are not those"));
}

TEST(TrackParts, OfFilesThatChangedSinceAreRefused) {
  const Body body;
  for (const int part : {1, 2}) body.follow_part(part, 2);
  for (const char* kind : {"body/", "body/material/"})
    std::filesystem::copy_file(body.folder / kind / "frame_0004.ply", body.folder / kind / "frame_0005.ply",
                               std::filesystem::copy_options::overwrite_existing);
  const Result refused = body.join();
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.error, HasSubstr("part_2.evolving followed another file as frame 5"));
}

TEST(TrackParts, HavePlacesForTheirNumbersAndFrames) {
  const Body body;
  const auto said = [&](const Words& words, const std::string& output) { return refusal(body.folder, words, output); };
  EXPECT_THAT(said(body.track({"-o", "part.evolving", "--shard", "1/2"}), "part.evolving"), HasSubstr("part_%d.evolving"));
  EXPECT_THAT(said(body.track({"-o", "part_%d.evolving", "--shard", "1/9"}), "part_1.evolving"), HasSubstr("8"));
  EXPECT_THAT(said(body.track({"-o", "part_%d.evolving", "--shard", "3/2"}), "part_3.evolving"), HasSubstr("3/16"));
  EXPECT_THAT(said(body.track({"-o", "joined.evolving", "--motion", "part_%d.evolving"}), "joined.evolving"),
              HasSubstr("no file is called so"));
  EXPECT_THAT(said({"evolve", "body", "-o", "part_%d.evolving", "--shard", "1/2"}, "part_1.evolving"),
              HasSubstr("track --remesh --shard"));
}

/// The script goes on with a part that was stopped, and joins all.
TEST(TrackParts, AreRunByAScript) {
  const Body body;
  std::filesystem::rename(body.folder / "body", body.folder / "body of one");
  const std::string script = places::source().string() + "/examples/cluster/follow.sh";
  const auto run = [&] {
    const std::string command = "cd '" + body.folder.path().string() + "' && MARQUETRY='" +
                                places::program().string() + "' '" + script +
                                "' 2 'body of one' walk.evolving --nodes 10 --frames 0-5 > log.txt 2>&1";
    return std::system(command.c_str());
  };
  ASSERT_EQ(run(), 0) << file_bytes(body.folder / "log.txt");
  const std::string blocks = file_bytes(body.folder / "walk.blocks");
  EXPECT_EQ(EvolvingReader(body.folder / "walk.evolving").frames().size(), 6U);
  const auto second = body.folder / "walk.part_2.blocks";
  std::filesystem::resize_file(second, std::filesystem::file_size(second) - 9);
  std::filesystem::remove(body.folder / "walk.evolving");
  ASSERT_EQ(run(), 0) << file_bytes(body.folder / "log.txt");
  EXPECT_THAT(file_bytes(body.folder / "log.txt"), HasSubstr("goes on after frame 4"));
  EXPECT_TRUE(file_bytes(body.folder / "walk.blocks") == blocks);
}

}  // namespace
}  // namespace mq::test
