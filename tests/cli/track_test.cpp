// track, and the sequences that sample makes for it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/models.h"
#include "mq/io/evolving_file.h"

namespace mq::test {
namespace {

using testing::HasSubstr;

/// Frames 0 to `last` of a small body, in body/.
void make_body(const Folder& folder, const std::string& name, int last) {
  ASSERT_EQ(marquetry(folder, {"sample", name, "-o", "body/", "--triangles", "1200", "--frames",
                               "0-" + std::to_string(last)})
                .status,
            0);
}

TEST(SampleSequence, WritesFramesAndTheirMaterial) {
  const Folder folder;
  make_body(folder, "twisting", 1);
  EXPECT_THAT(folder.names(), testing::IsSupersetOf({"body/frame_0000.ply", "body/frame_0001.ply",
                                                     "body/material/frame_0000.ply",
                                                     "body/material/frame_0001.ply"}));
  const Model frame = read_model(folder / "body/frame_0001.ply");
  const Model material = read_model(folder / "body/material/frame_0001.ply");
  EXPECT_EQ(frame.mesh.triangles, material.mesh.triangles);
  EXPECT_EQ(frame.colors.channels, 3);
  EXPECT_EQ(marquetry(folder, {"check", "body/frame_0001.ply"}).status, 0);
}

TEST(SampleSequence, RefusesWhatHasNoPlaceInOne) {
  const Folder folder;
  const auto refusal = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "sample");
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 2);
    return result.error;
  };
  EXPECT_THAT(refusal({"bending", "-o", "frame.ply"}), HasSubstr("a place for the frame's number"));
  EXPECT_THAT(refusal({"bending", "-o", "body/", "--size", "64"}), HasSubstr("no texture"));
  EXPECT_THAT(refusal({"bending", "-o", "body/", "--frames", "9-1"}), HasSubstr("--frames"));
  EXPECT_THAT(refusal({"cube", "-o", "body/", "--frames", "0-9"}), HasSubstr("does not move"));
}

TEST(Track, FollowsASequenceAndSaysHowWell) {
  const Folder folder;
  make_body(folder, "bending", 3);
  const Result result = marquetry(
      folder, {"track", "body", "-o", "body.evolving", "--truth", "body/material", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto frames = result.json()["result"]["frames"];
  ASSERT_EQ(frames.size(), 4U);
  EXPECT_EQ(frames[0]["triangles_born"], frames[3]["triangles_kept"]);
  EXPECT_EQ(frames[3]["triangles_born"], 0);
  EXPECT_GT(frames[3]["distance_p95"], 0);
  EXPECT_LT(frames[3]["distance_p95"], 0.005);
  EXPECT_LT(frames[0]["drift"]["mean_edges"], 1e-3);
  EXPECT_LT(frames[3]["drift"]["mean_edges"], 1);
  EXPECT_GT(frames[3]["seconds"]["total"], 0);
  const EvolvingReader reader(folder / "body.evolving");
  EXPECT_EQ(reader.broken(), "");
  const EvolvingMesh evolving = reader.read();
  EXPECT_EQ(evolving.segments.size(), 1U);
  EXPECT_EQ(evolving.frames.size(), 4U);
  EXPECT_EQ(evolving.frames[3].number, 3);
}

TEST(Track, GoesOnWhereItWasStopped) {
  const Folder folder;
  make_body(folder, "bending", 3);
  const std::vector<std::string> words = {"track", "body", "-o", "body.evolving", "--photometric"};
  ASSERT_EQ(marquetry(folder, words).status, 0);
  const std::string blocks = file_bytes(folder / "body.blocks");
  const EvolvingMesh whole = EvolvingReader(folder / "body.evolving").read();
  // Stopped while the third frame was written.
  const std::int64_t cut = EvolvingReader(folder / "body.evolving").frames()[2].offset + 5;
  write_bytes(folder / "body.blocks", blocks.substr(0, std::size_t(cut)));
  std::vector<std::string> resumed = words;
  resumed.push_back("--resume");
  resumed.push_back("--json");
  const Result result = marquetry(folder, resumed);
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("goes on after frame 1"));
  EXPECT_EQ(result.json()["result"]["frames"].size(), 4U);
  EXPECT_EQ(file_bytes(folder / "body.blocks"), blocks);
  const EvolvingMesh again = EvolvingReader(folder / "body.evolving").read();
  for (int f = 0; f < 4; ++f) EXPECT_EQ(again.frames[f].positions, whole.frames[f].positions);
}

TEST(Track, StoppedByTheUserKeepsTheFramesItHas) {
  const Folder folder;
  make_body(folder, "bending", 20);
  // It speaks of its progress after a second, long before it is done.
  const Result stopped =
      marquetry(folder, {"track", "body", "-o", "body.evolving", "--nodes", "3", "--photometric"},
                {.interrupt_at = {"%"}});
  EXPECT_EQ(stopped.status, 130);
  const EvolvingReader reader(folder / "body.evolving");
  EXPECT_EQ(reader.broken(), "");
  EXPECT_GE(reader.frames().size(), 1U);
  EXPECT_LT(reader.frames().size(), 21U);
}

TEST(Track, BeginsAnewWhereATemplateNoLongerFits) {
  const Folder folder;
  make_body(folder, "bending", 2);
  const Result result =
      marquetry(folder, {"track", "body", "-o", "body.evolving", "--restart", "0.00001", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto frames = result.json()["result"]["frames"];
  EXPECT_EQ(frames[1]["triangles_died"], frames[0]["triangles_born"]);
  const EvolvingMesh evolving = EvolvingReader(folder / "body.evolving").read();
  EXPECT_EQ(evolving.segments.size(), 3U);
  for (const Lifespan& span : triangle_lifespans(evolving)) EXPECT_EQ(span.first, span.last);
}

TEST(Track, RefusesWhatItCannotFollow) {
  const Folder folder;
  make_body(folder, "bending", 1);
  const auto refusal = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "track");
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 2);
    return result.error;
  };
  EXPECT_THAT(refusal({"body", "-o", "body.ply"}), HasSubstr("ends in .evolving"));
  EXPECT_THAT(refusal({"nobody", "-o", "a.evolving"}), HasSubstr("no such file or folder"));
  EXPECT_THAT(refusal({"body", "-o", "a.evolving", "--frames", "0-5"}),
              HasSubstr("4 of 6 frames are missing, the first is frame 2"));
  EXPECT_THAT(refusal({"body/frame_0000.ply", "-o", "a.evolving"}), HasSubstr("wanted a sequence"));
  EXPECT_THAT(refusal({"body", "-o", "a.evolving", "--truth", "uv"}),
              HasSubstr("wants texture coordinates"));
  EXPECT_THAT(refusal({"body", "-o", "a.evolving", "--truth", "nothing"}),
              HasSubstr("--truth: found 'nothing'"));
  EXPECT_THAT(refusal({"body/material", "-o", "a.evolving", "--photometric"}),
              HasSubstr("wants colours"));
}

TEST(Track, WritesNothingWhenDry) {
  const Folder folder;
  make_body(folder, "bending", 1);
  EXPECT_EQ(marquetry(folder, {"track", "body", "-o", "body.evolving", "--dry-run"}).status, 0);
  EXPECT_FALSE(std::filesystem::exists(folder / "body.evolving"));
  EXPECT_FALSE(std::filesystem::exists(folder / "body.blocks"));
}

}  // namespace
}  // namespace mq::test
