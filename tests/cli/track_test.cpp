// track, and the sequences that sample makes for it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "cli/moving_body.h"
#include "model/sequences.h"
#include "mq/io/evolving_file.h"
#include "mq/io/frame_files.h"
#include "mq/io/model.h"
#include "mq/mesh/geometry.h"
#include "mq/model/sequence_tracker.h"
#include "mq/model/stored_frames.h"

namespace mq::test {
namespace {

using testing::HasSubstr;

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

TEST(Track, NamesAVertexThatIsFarFromTheOthers) {
  const Folder folder;
  make_body(folder, "bending", 1);
  Model frame = read_model(folder / "body/frame_0001.ply");
  frame.mesh.positions[7].y() = 1e30;
  write_model(folder / "body/frame_0001.ply", frame);
  const Result result = marquetry(folder, {"track", "body", "-o", "body.evolving"});
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.error, HasSubstr("frame_0001.ply: vertex 7 is at ("));
  EXPECT_THAT(result.error, HasSubstr("1e+30"));
}

TEST(Track, StoresWhatTheLibraryStores) {
  const Folder folder;
  // Balls that meet in frame 11.
  ASSERT_EQ(marquetry(folder, {"sample", "merging", "-o", "body/", "--triangles", "1000",
                               "--period", "40", "--frames", "10-12"})
                .status,
            0);
  const Result result =
      marquetry(folder, {"track", "body", "-o", "body.evolving", "--nodes", "10", "--remesh",
                         "--photometric", "--truth", "body/material", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;

  Messages silent;
  const FileFrames frames((folder / "body").string(),
                          {.material = (folder / "body/material").string()}, silent);
  SequenceTrackerOptions options{.follow = {.remeshing = Remeshing::parts,
                                            .truth = Truth::material,
                                            .colours = TemplateFollowerOptions::Colours::used}};
  options.follow.track.node_spacing = 0.1;
  EvolvingStore store(folder / "library.evolving");
  const FollowedSequence found = SequenceTracker(frames, store, options).run();

  EXPECT_EQ(file_bytes(folder / "body.blocks"), file_bytes(folder / "library.blocks"));
  const EvolvingReader made(folder / "body.evolving");
  EXPECT_GT(made.segments().size(), 1U);
  EXPECT_EQ(without_seconds(followed_frames(made)), without_seconds(found.frames));
  // The report says what the store does.
  const auto report = nlohmann::ordered_json::parse(result.output)["result"]["frames"];
  ASSERT_EQ(report.size(), made.frames().size());
  for (std::size_t f = 0; f < report.size(); ++f)
    EXPECT_EQ(report[f].dump(), made.frames()[f].measured);
}

TEST(Track, DrawsWhatItMeasuredAndSomeOfTheFrames) {
  const Folder folder;
  make_body(folder, "bending", 3);
  const Result result = marquetry(folder, {"track", "body", "-o", "body.evolving", "--plot",
                                           "plot.png", "--strip", "strip.png", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["outputs"].size(), 4U);
  const Texture plot = read_texture(folder / "plot.png");
  const Texture strip = read_texture(folder / "strip.png");
  EXPECT_GT(plot.pixels.height(), 4 * 200);  // distances, triangles, distortion and time
  EXPECT_GT(strip.pixels.width(), strip.pixels.height());
  // A store that is there is drawn by export, with the same figures.
  ASSERT_EQ(marquetry(folder, {"export", "body.evolving", "--plot", "again.png"}).status, 0);
  EXPECT_TRUE(
      std::ranges::equal(read_texture(folder / "again.png").pixels.values(), plot.pixels.values()));
  EXPECT_EQ(marquetry(folder, {"track", "body", "-o", "b.evolving", "--plot", "plot.docx"}).status,
            2);
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

TEST(Track, RoundsPositionsAsItIsAskedToAndGoesOnWithThem) {
  const Folder folder;
  make_body(folder, "bending", 3);
  const std::vector<std::string> words = {"track", "body", "-o", "body.evolving", "--nodes", "10", "--error", "0.1", "--group", "2"};
  ASSERT_EQ(marquetry(folder, words).status, 0);
  const std::string blocks = file_bytes(folder / "body.blocks");
  const EvolvingReader reader(folder / "body.evolving");
  const double diagonal = bounding_box(read_model(folder / "body/frame_0000.ply").mesh).diagonal();
  EXPECT_DOUBLE_EQ(reader.step(), step_within(diagonal / 1000));
  EXPECT_EQ(reader.group_frames(), 2);
  const std::vector<Vector3> first = reader.positions(0);
  EXPECT_EQ(rounded(first, reader.step()), first);
  const std::int64_t cut = reader.frames()[2].offset + 5;
  write_bytes(folder / "body.blocks", blocks.substr(0, std::size_t(cut)));
  std::vector<std::string> resumed = words;
  resumed.push_back("--resume");
  ASSERT_EQ(marquetry(folder, resumed).status, 0);
  EXPECT_EQ(file_bytes(folder / "body.blocks"), blocks);
  const Result coarse = marquetry(folder, {"track", "body", "-o", "coarse.evolving", "--remesh", "--error", "1"});
  EXPECT_EQ(coarse.status, 2);
  EXPECT_THAT(coarse.error, HasSubstr("--within is 0.2 %"));
  resumed[7] = "0.2";
  const Result refused = marquetry(folder, resumed);
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.error, HasSubstr("--error"));
  resumed[7] = "0.1";
  resumed[9] = "3";
  EXPECT_THAT(marquetry(folder, resumed).error, HasSubstr("--group 2"));
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

TEST(Track, GoesOnOnlyWithTheOptionsItBeganWith) {
  const Folder folder;
  make_body(folder, "bending", 2);
  ASSERT_EQ(marquetry(folder, {"track", "body", "-o", "body.evolving", "--frames", "0-1"}).status,
            0);
  const std::string blocks = file_bytes(folder / "body.blocks");
  const auto resumed = [&](const std::string& option, const std::string& value = "") {
    std::vector<std::string> words = {"track", "body", "-o", "body.evolving", "--resume", option};
    if (!value.empty()) words.push_back(value);
    return marquetry(folder, words);
  };
  for (const auto& [option, value] :
       {std::pair{"--photometric", ""}, {"--remesh", ""}, {"--nodes", "10"}, {"--within", "0.4"}}) {
    const Result result = resumed(option, value);
    EXPECT_EQ(result.status, 2) << option;
    EXPECT_THAT(result.error, HasSubstr(std::string(option).substr(2, 6))) << option;
    EXPECT_THAT(result.error, HasSubstr("options it was made with")) << option;
    EXPECT_EQ(file_bytes(folder / "body.blocks"), blocks);
  }
  EXPECT_EQ(resumed("--plot", "plot.png").status, 0);

  const Result two = marquetry(
      folder, {"track", "body", "-o", "two.evolving", "--plot", "p.png", "--strip", "./p.png"});
  EXPECT_EQ(two.status, 2);
  EXPECT_THAT(two.error, HasSubstr("two outputs"));
}

TEST(Track, SaysWhatIsWrongWithFrames) {
  const Folder folder;
  make_body(folder, "bending", 1);
  Model model = read_model(folder / "body/frame_0001.ply");
  Triangle fin = model.mesh.triangles.front();  // a third triangle at an edge
  fin[2] = model.mesh.vertex_count();
  model.mesh.positions.emplace_back(0, 0, 1);
  model.colors.values.resize(3 * model.mesh.positions.size());
  model.mesh.triangles.push_back(fin);
  write_model(folder / "body/frame_0001.ply", model);
  const Result result = marquetry(folder, {"track", "body", "-o", "body.evolving", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("frame_0001.ply"));
  EXPECT_THAT(result.json()["defects"].dump(), HasSubstr("touching_edges"));
}

TEST(Track, ExportsAModelAFrameAlsoAsGlb) {
  const Folder folder;
  make_body(folder, "bending", 1);
  ASSERT_EQ(marquetry(folder, {"track", "body", "-o", "body.evolving"}).status, 0);
  ASSERT_EQ(marquetry(folder, {"export", "body.evolving", "-o", "f_%d.glb"}).status, 0);
  const Mesh first = read_model(folder / "f_0.glb").mesh,
             second = read_model(folder / "f_1.glb").mesh;
  EXPECT_EQ(first.triangles, second.triangles);
  EXPECT_NE(first.positions, second.positions);
}

TEST(Track, SaysFromWhereItIsLost) {
  const Folder folder;
  make_body(folder, "bending", 1);
  ASSERT_EQ(
      marquetry(folder, {"sample", "torus", "-o", "body/frame_0001.ply", "--triangles", "1000"})
          .status,
      0);
  const Result result = marquetry(folder, {"track", "body", "-o", "body.evolving"});
  EXPECT_EQ(result.status, 0);
  EXPECT_THAT(result.error, HasSubstr("in frame 1 5 % of the points are farther than"));
  EXPECT_THAT(result.error, HasSubstr("--restart 1"));
}

TEST(Track, SaysWhereAFewPointsAreLost) {
  const Folder folder;
  // Balls that meet in frame 11, whose caps then stay.
  ASSERT_EQ(marquetry(folder, {"sample", "merging", "-o", "body/", "--triangles", "1200",
                               "--period", "40", "--frames", "9-13"})
                .status,
            0);
  const Result left = marquetry(folder, {"track", "body", "-o", "left.evolving", "--json"});
  ASSERT_EQ(left.status, 0) << left.error;
  const auto report = left.json();
  for (const auto& frame : report["result"]["frames"]) EXPECT_LT(frame["distance_p95"], 0.01);
  EXPECT_THAT(left.error, HasSubstr("in frame 12 the farthest point is"));
  EXPECT_THAT(left.error, HasSubstr("--remesh"));
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
  EXPECT_THAT(refusal({"body", "-o", "a.evolving", "--keyframes"}), HasSubstr("--remesh"));
  write_bytes(folder / "body/frame_0001.ply", "");
  EXPECT_THAT(refusal({"body", "-o", "a.evolving"}), HasSubstr("such frames with --skip-bad"));
  EXPECT_THAT(refusal({"body", "-o", "a.evolving", "--frames", "1", "--skip-bad"}),
              HasSubstr("--skip-bad: not one of the frames can be followed"));
}

TEST(Track, WritesNothingWhenDry) {
  const Folder folder;
  make_body(folder, "bending", 1);
  EXPECT_EQ(marquetry(folder, {"track", "body", "-o", "body.evolving", "--dry-run"}).status, 0);
  EXPECT_FALSE(std::filesystem::exists(folder / "body.evolving"));
  EXPECT_FALSE(std::filesystem::exists(folder / "body.blocks"));
}

TEST(Track, KeepsTheStoreThatIsThereUntilAFrameOfTheNextIsFollowed) {
  const Folder folder;
  make_body(folder, "bending", 2);
  ASSERT_EQ(marquetry(folder, {"sample", "spinning", "-o", "other/", "--triangles", "1200",
                               "--frames", "0-2"})
                .status,
            0);
  ASSERT_EQ(marquetry(folder, {"track", "body", "-o", "body.evolving"}).status, 0);
  const std::string manifest = file_bytes(folder / "body.evolving"),
                    blocks = file_bytes(folder / "body.blocks");
  const auto names = folder.names();
  const std::vector<std::vector<std::string>> refused = {
      {"--truth", "uv"},
      {"--truth", "other/material"},
      {"--texture", "no_%04d.png"},
      {"--texture", "no_%04d.png", "--photometric"},
      {"--texture", "body/frame_0000.ply", "--photometric"}};  // no picture
  for (const auto& options : refused)
    for (const char* way : {"--quiet", "--dry-run", "--resume", "--skip-bad"}) {
      if (way == std::string("--skip-bad") && options.size() == 2 && options[0] == "--texture")
        continue;  // nothing looks at the pictures
      if (way == std::string("--resume") && options[0] == "--texture") continue;  // other options
      std::vector<std::string> words = {"track", "body", "-o", "body.evolving", way};
      words.insert(words.end(), options.begin(), options.end());
      const Result result = marquetry(folder, words);
      EXPECT_EQ(result.status, 2) << testing::PrintToString(words);
      EXPECT_EQ(file_bytes(folder / "body.evolving"), manifest) << testing::PrintToString(words);
      EXPECT_EQ(file_bytes(folder / "body.blocks"), blocks) << testing::PrintToString(words);
      EXPECT_EQ(folder.names(), names);
    }
  // Stopped before its first frame, too.
  write_bytes(folder / "body/frame_0000.ply", "ply\nformat");
  EXPECT_EQ(marquetry(folder, {"track", "body", "-o", "body.evolving", "--dry-run"}).status, 2);
  EXPECT_EQ(marquetry(folder, {"track", "body", "-o", "body.evolving"}).status, 2);
  EXPECT_EQ(file_bytes(folder / "body.blocks"), blocks);
}

TEST(Track, LeavesOutFramesThatAreMissingIfItMay) {
  const Folder folder;
  make_body(folder, "bending", 4);
  std::filesystem::remove(folder / "body/frame_0002.ply");
  std::vector<std::string> words = {"track",  "body",     "-o", "body.evolving",
                                    "--json", "--frames", "0-5"};
  EXPECT_THAT(marquetry(folder, words).error, HasSubstr("2 of 6 frames are missing"));
  words.push_back("--skip-bad");
  for (const char* way : {"--seed=0", "--resume"}) {
    std::vector<std::string> all = words;
    all.push_back(way);
    const Result result = marquetry(folder, all);
    ASSERT_EQ(result.status, 0) << result.error;
    EXPECT_THAT(result.error, HasSubstr("2 of 6 frames are missing, the first is frame 2"));
    const auto found = result.json()["result"];
    EXPECT_EQ(found["frames"].size(), 4U);
    ASSERT_EQ(found["skipped"].size(), 2U);
    EXPECT_EQ(found["skipped"][0]["frame"], 2);
    EXPECT_EQ(found["skipped"][1]["frame"], 5);
  }
}

}  // namespace
}  // namespace mq::test
