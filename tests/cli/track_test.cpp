// track, and the sequences that sample makes for it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "cli/models.h"
#include "mq/io/evolving_file.h"
#include "mq/io/frame_files.h"
#include "mq/io/model.h"
#include "mq/mesh/orient.h"
#include "mq/mesh/surface.h"

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

TEST(Track, CutsTrianglesThatAreLongBesideTheWayFromNodeToNode) {
  const Folder folder;
  ASSERT_EQ(marquetry(folder,
                      {"sample", "bending", "-o", "body/", "--triangles", "500", "--frames", "0-1"})
                .status,
            0);
  const Result result = marquetry(folder, {"track", "body", "-o", "body.evolving", "--truth",
                                           "body/material", "--nodes", "10", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto frame = result.json()["result"]["frames"][1];
  EXPECT_GT(frame["triangles_kept"], 2 * 492);
  EXPECT_LT(frame["distance_p95"], 0.005);  // 0.0100 with the triangles as they come
  EXPECT_GT(frame["drift"]["known"], 900);  // vertices; 247 as they come
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

TEST(Track, GoesOnBeforeWhatWasDamaged) {
  const Folder folder;
  make_body(folder, "bending", 3);
  ASSERT_EQ(marquetry(folder, {"track", "body", "-o", "body.evolving"}).status, 0);
  const std::string blocks = file_bytes(folder / "body.blocks");
  std::string damaged = blocks;
  damaged[std::size_t(EvolvingReader(folder / "body.evolving").frames()[2].offset) + 5] ^= 1;
  write_bytes(folder / "body.blocks", damaged);
  const Result result = marquetry(folder, {"track", "body", "-o", "body.evolving", "--resume"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("cannot give frame 2;"));
  EXPECT_THAT(result.error, HasSubstr("goes on after frame 1"));
  EXPECT_EQ(file_bytes(folder / "body.blocks"), blocks);
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

TEST(Track, TakesKeyframesInsteadOfParts) {
  const Folder folder;
  ASSERT_EQ(marquetry(folder, {"sample", "merging", "-o", "body/", "--triangles", "1000",
                               "--period", "40", "--frames", "10-12"})
                .status,
            0);
  const auto frames_with = [&](const std::string& option) {
    const Result result =
        marquetry(folder, {"track", "body", "-o", "body.evolving", "--remesh", "--json", option});
    EXPECT_EQ(result.status, 0) << result.error;
    return result.json()["result"]["frames"];
  };
  const auto parts = frames_with("-q"), wholes = frames_with("--keyframes");
  int taken = 0;
  for (std::size_t f = 1; f < parts.size(); ++f) {
    if (wholes[f]["triangles_born"] == 0) continue;
    ++taken;
    EXPECT_EQ(wholes[f]["triangles_kept"], 0);
    // Up to the first both are the same template.
    if (taken == 1) {
      EXPECT_GT(parts[f]["triangles_born"], 0);
      EXPECT_GT(parts[f]["triangles_kept"], 0);
    }
  }
  EXPECT_GE(taken, 1);
  const Result alone = marquetry(folder, {"track", "body", "-o", "other.evolving", "--keyframes"});
  EXPECT_EQ(alone.status, 2);
  EXPECT_THAT(alone.error, HasSubstr("--remesh"));
}

TEST(Track, RemeshesWhereBodiesMergeAndGoesOnFromThere) {
  const Folder folder;
  // Balls that meet in frame 11.
  ASSERT_EQ(marquetry(folder, {"sample", "merging", "-o", "body/", "--triangles", "3000",
                               "--period", "40", "--frames", "9-13"})
                .status,
            0);
  const std::vector<std::string> words = {"track",         "body",          "-o",
                                          "body.evolving", "--truth",       "body/material",
                                          "--remesh",      "--photometric", "--json"};
  const Result whole = marquetry(folder, words);
  ASSERT_EQ(whole.status, 0) << whole.error;
  const auto frames = whole.json()["result"]["frames"];
  int added = 0;
  for (std::size_t f = 1; f < frames.size(); ++f) {
    added += frames[f]["triangles_born"].get<int>();
    EXPECT_LT(frames[f]["distance_p95"], 0.001) << f;
    EXPECT_LT(frames[f]["distance_max"], 0.005) << f;
    EXPECT_GT(frames[f]["triangles_kept"].get<int>(), 9 * frames[f]["triangles_died"].get<int>());
    EXPECT_EQ(frames[f]["manifold"], true) << f;
    EXPECT_EQ(frames[f]["folded"], 0) << f;
  }
  EXPECT_GT(added, 0);
  const EvolvingMesh evolving = EvolvingReader(folder / "body.evolving").read();
  EXPECT_GT(evolving.segments.size(), 1U);
  int throughout = 0;
  for (const Lifespan& span : triangle_lifespans(evolving))
    throughout += span.first == 0 && span.last == 4;
  EXPECT_GT(throughout, evolving.segments[0].triangle_count() / 2);
  EXPECT_EQ(make_surface(evolving.mesh(0)).components, 2);
  EXPECT_EQ(make_surface(evolving.mesh(4)).components, 1);

  // Without it the caps stay where they meet.
  const Result left = marquetry(folder, {"track", "body", "-o", "left.evolving", "--json"});
  ASSERT_EQ(left.status, 0) << left.error;
  EXPECT_GT(left.json()["result"]["frames"].back()["distance_max"], 0.05);

  // Stopped in the last frame, it goes on with the same result.
  const std::string blocks = file_bytes(folder / "body.blocks");
  const std::int64_t cut = EvolvingReader(folder / "body.evolving").frames()[4].offset + 1;
  write_bytes(folder / "body.blocks", blocks.substr(0, std::size_t(cut)));
  std::vector<std::string> resumed = words;
  resumed.push_back("--resume");
  const Result again = marquetry(folder, resumed);
  ASSERT_EQ(again.status, 0) << again.error;
  EXPECT_EQ(file_bytes(folder / "body.blocks"), blocks);
  EXPECT_EQ(again.json()["result"]["frames"][4]["drift"], frames[4]["drift"]);
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

/// Turns over every `step`-th triangle of a model file.
void turn_over(const std::filesystem::path& path, int step) {
  Model model = read_model(path);
  std::vector<int> some;
  for (int t = 0; t < model.mesh.triangle_count(); t += step) some.push_back(t);
  model.mesh = with_flipped(std::move(model.mesh), some);
  write_model(path, model);
}

TEST(Track, TurnsBackWhatFacesTheWrongWay) {
  const Folder folder;
  make_body(folder, "bending", 3);
  for (const bool remeshed : {false, true}) {
    std::vector<std::string> words = {"track",   "body",          "-o",    "body.evolving",
                                      "--truth", "body/material", "--json"};
    if (remeshed) words.push_back("--remesh");
    ASSERT_EQ(marquetry(folder, words).status, 0);
    const std::string sound = file_bytes(folder / "body.blocks");
    // Some of the first, all of the third.
    turn_over(folder / "body/frame_0000.ply", 17);
    turn_over(folder / "body/frame_0002.ply", 1);
    const Result result = marquetry(folder, words);
    ASSERT_EQ(result.status, 0) << result.error;
    EXPECT_EQ(file_bytes(folder / "body.blocks"), sound);
    EXPECT_THAT(result.error, HasSubstr("frame_0000.ply"));
    EXPECT_THAT(result.error, HasSubstr("frame_0002.ply"));
    const auto report = result.json();
    EXPECT_EQ(report["defects"][0]["kind"], "turned_triangles");
    EXPECT_EQ(report["defects"][1]["kind"], "inside_out_triangles");
    const auto frames = report["result"]["frames"];
    EXPECT_GT(frames[0]["turned"], 10);
    EXPECT_FALSE(frames[1].contains("turned"));
    EXPECT_GT(frames[2]["turned"], 1000);
    turn_over(folder / "body/frame_0000.ply", 17);
    turn_over(folder / "body/frame_0002.ply", 1);
  }
}

TEST(Track, LeavesOutBadFramesIfItMay) {
  const Folder folder;
  make_body(folder, "bending", 4);
  write_bytes(folder / "body/frame_0000.ply", "ply\nformat");
  write_bytes(folder / "body/frame_0002.ply", "");
  Model model = read_model(folder / "body/frame_0004.ply");
  for (Vector3& p : model.mesh.positions) p.setZero();
  write_model(folder / "body/frame_0004.ply", model);
  std::vector<std::string> words = {"track", "body", "-o", "body.evolving", "--json"};
  const Result refused = marquetry(folder, words);
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.error, HasSubstr("frame_0000.ply"));
  EXPECT_THAT(refused.error, HasSubstr("--skip-bad"));
  words.push_back("--skip-bad");
  const Result result = marquetry(folder, words);
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("left out"));
  const auto found = result.json()["result"];
  ASSERT_EQ(found["frames"].size(), 2U);
  EXPECT_EQ(found["frames"][1]["frame"], 3);
  ASSERT_EQ(found["skipped"].size(), 3U);
  EXPECT_EQ(found["skipped"][1]["frame"], 2);
  EXPECT_THAT(found["skipped"][1]["why"].dump(), HasSubstr("frame_0002.ply"));
  // A run that was stopped goes on with the same result.
  const std::string blocks = file_bytes(folder / "body.blocks");
  const std::int64_t cut = EvolvingReader(folder / "body.evolving").frames()[1].offset + 5;
  for (const std::int64_t size : {cut, std::int64_t(blocks.size())}) {
    write_bytes(folder / "body.blocks", blocks.substr(0, std::size_t(size)));
    std::vector<std::string> resumed = words;
    resumed.push_back("--resume");
    const Result again = marquetry(folder, resumed);
    ASSERT_EQ(again.status, 0) << again.error;
    EXPECT_EQ(file_bytes(folder / "body.blocks"), blocks);
    EXPECT_EQ(again.json()["result"]["skipped"], found["skipped"]);
  }
  const Result strict = marquetry(folder, {"track", "body", "-o", "body.evolving", "--resume"});
  EXPECT_EQ(strict.status, 2);
  EXPECT_THAT(strict.error, HasSubstr("--skip-bad"));
  for (const int bad : {1, 3}) write_bytes(folder / frame_name("body/frame_%04d.ply", bad), "");
  EXPECT_THAT(marquetry(folder, words).error, HasSubstr("not one of the frames"));
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
  for (const auto& frame : left.json()["result"]["frames"]) EXPECT_LT(frame["distance_p95"], 0.01);
  EXPECT_THAT(left.error, HasSubstr("in frame 12 the farthest point is"));
  EXPECT_THAT(left.error, HasSubstr("--remesh"));
  const Result healed = marquetry(folder, {"track", "body", "-o", "h.evolving", "--remesh"});
  ASSERT_EQ(healed.status, 0) << healed.error;
  EXPECT_THAT(healed.error, testing::Not(HasSubstr("farthest point")));
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

/// A store of two segments: frames 0 and 1, and frame 2 with its own mesh.
void make_store(const Folder& folder) {
  make_body(folder, "bending", 2);
  ASSERT_EQ(marquetry(folder, {"track", "body", "-o", "two.evolving", "--frames", "0-1"}).status,
            0);
  EvolvingMesh evolving = EvolvingReader(folder / "two.evolving").read();
  const Mesh other = read_model(folder / "body/frame_0002.ply").mesh;
  evolving.segments.push_back(
      segment_of(other, next_vertex_id(evolving), next_triangle_id(evolving)));
  evolving.frames.push_back({2, 1, other.positions});
  write_evolving(folder / "body.evolving", evolving, store_step(2));
}

TEST(Export, SaysWhatAnEvolvingMeshIs) {
  const Folder folder;
  make_store(folder);
  const Result result = marquetry(folder, {"export", "body.evolving", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto found = result.json()["result"];
  EXPECT_EQ(found["frames"], 3);
  EXPECT_EQ(found["segments"], 2);
  EXPECT_EQ(found["triangles_throughout"], 0);
  EXPECT_EQ(found["broken"], "");
  const std::string words = marquetry(folder, {"export", "body.evolving"}).output;
  EXPECT_THAT(words, HasSubstr("segment 1: from frame 2, 1 frame, "));
}

TEST(Export, WritesFramesAsFiles) {
  const Folder folder;
  make_store(folder);
  const EvolvingMesh evolving = EvolvingReader(folder / "body.evolving").read();
  std::filesystem::create_directory(folder / "out");
  for (const std::string name : {"out/f_%03d.ply", "out/f_%03d.obj"}) {
    ASSERT_EQ(marquetry(folder, {"export", "body.evolving", "-o", name}).status, 0);
    for (int f = 0; f < 3; ++f) {
      const Mesh mesh = read_model(folder / frame_name(name, f)).mesh;
      EXPECT_EQ(mesh.triangles, evolving.mesh(f).triangles);
      EXPECT_EQ(mesh.positions, evolving.mesh(f).positions);
    }
  }
}

TEST(Export, GivesFramesThatDoNotNeedWhatWasDamaged) {
  const Folder folder;
  make_store(folder);
  const EvolvingReader whole(folder / "body.evolving");
  std::string blocks = file_bytes(folder / "body.blocks");
  blocks[std::size_t(whole.segments()[1].offset) + 9] ^= 1;
  write_bytes(folder / "body.blocks", blocks);
  const Result result =
      marquetry(folder, {"export", "body.evolving", "-o", "f_%d.ply", "--frames", "0-1", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_EQ(result.json()["result"]["damaged"], nlohmann::json::array({2}));
  EXPECT_EQ(result.json()["result"]["triangles_throughout"], whole.segments()[0].triangles);
  EXPECT_THAT(result.error, HasSubstr("cannot give frame 2"));
  EXPECT_EQ(read_model(folder / "f_1.ply").mesh.positions, whole.positions(1));
  const Result all = marquetry(folder, {"export", "body.evolving", "-o", "f_%d.ply"});
  EXPECT_EQ(all.status, 2);
  EXPECT_THAT(all.error, HasSubstr("2 of 3 frames were written; damaged, and not written: 2"));
  // A damaged frame in between costs no other.
  blocks[std::size_t(whole.segments()[1].offset) + 9] ^= 1;
  blocks[std::size_t(whole.frames()[1].offset) + 1] ^= 1;
  write_bytes(folder / "body.blocks", blocks);
  EXPECT_EQ(marquetry(folder, {"export", "body.evolving", "-o", "g_%d.ply"}).status, 2);
  EXPECT_TRUE(std::filesystem::exists(folder / "g_0.ply"));
  EXPECT_FALSE(std::filesystem::exists(folder / "g_1.ply"));
  EXPECT_EQ(read_model(folder / "g_2.ply").mesh.positions, whole.positions(2));
}

TEST(Export, WritesAnAnimationWithATargetForEachFurtherFrame) {
  const Folder folder;
  make_store(folder);
  const EvolvingMesh evolving = EvolvingReader(folder / "body.evolving").read();
  ASSERT_EQ(marquetry(folder, {"export", "body.evolving", "-o", "body.glb"}).status, 0);
  const std::string bytes = file_bytes(folder / "body.glb");
  std::uint32_t size = 0;
  std::memcpy(&size, bytes.data() + 12, sizeof size);
  const auto gltf = nlohmann::json::parse(bytes.substr(20, size));
  ASSERT_EQ(gltf["meshes"].size(), 2U);
  EXPECT_EQ(gltf["meshes"][0]["primitives"][0]["targets"].size(), 1U);
  EXPECT_FALSE(gltf["meshes"][1]["primitives"][0].contains("targets"));
  EXPECT_EQ(gltf["animations"][0]["channels"].size(), 3U);  // weights, and both come and go
  // Base and target of a vertex add up to its second frame.
  const auto value = [&](const nlohmann::json& accessor, int vertex, int k) {
    const auto& view = gltf["bufferViews"][accessor["bufferView"].get<int>()];
    float found = 0;
    std::memcpy(&found,
                bytes.data() + 28 + size + view["byteOffset"].get<std::size_t>() +
                    std::size_t(12 * vertex + 4 * k),
                sizeof found);
    return found;
  };
  const auto& primitive = gltf["meshes"][0]["primitives"][0];
  const auto& base = gltf["accessors"][primitive["attributes"]["POSITION"].get<int>()];
  const auto& target = gltf["accessors"][primitive["targets"][0]["POSITION"].get<int>()];
  const int first = evolving.segments[0].triangles[0][0];  // the first corner is vertex 0
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(value(base, 0, k) + value(target, 0, k), evolving.frames[1].positions[first][k],
                1e-6);
  // Without the animation the first frame is seen, and nothing else.
  EXPECT_EQ(read_model(folder / "body.glb").mesh.triangle_count(),
            evolving.mesh(0).triangle_count());
}

TEST(Export, CarriesTheColoursOfTheFirstFrameAlong) {
  const Folder folder;
  make_store(folder);
  ASSERT_EQ(marquetry(folder, {"export", "body.evolving", "-o", "f_%d.ply", "--paint",
                               "body/frame_0000.ply"})
                .status,
            0);
  // Vertices of the store have an order of their own.
  const Model source = read_model(folder / "body/frame_0000.ply");
  const Model first = read_model(folder / "f_0.ply"), second = read_model(folder / "f_1.ply");
  const auto near = [&](const Vector3& p) {
    int best = 0;
    for (int v = 0; v < source.mesh.vertex_count(); ++v)
      if ((source.mesh.positions[v] - p).norm() < (source.mesh.positions[best] - p).norm())
        best = v;
    return best;
  };
  // Of a mesh so coarse there are more of them: those on the way from one to another are in
  // between.
  int same = 0;
  for (int v = 0; v < first.mesh.vertex_count(); ++v) {
    const int u = near(first.mesh.positions[v]);
    if ((first.mesh.positions[v] - source.mesh.positions[u]).norm() > 1e-3) continue;
    ++same;
    for (int c = 0; c < 3; ++c)
      ASSERT_NEAR(first.colors.values[std::size_t(3 * v + c)],
                  source.colors.values[std::size_t(3 * u + c)], 0.01);
  }
  EXPECT_EQ(same, source.mesh.vertex_count());
  EXPECT_NE(first.mesh.positions, second.mesh.positions);
  EXPECT_EQ(first.colors.values, second.colors.values);
  // The third frame is a mesh of its own.
  for (const float value : read_model(folder / "f_2.ply").colors.values)
    ASSERT_NEAR(value, 0.5, 0.01);
}

TEST(Export, RefusesWhatItCannotWrite) {
  const Folder folder;
  make_store(folder);
  const auto refusal = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "export");
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 2);
    return result.error;
  };
  EXPECT_THAT(refusal({"body.evolving", "-o", "frame.ply"}), HasSubstr("wanted an animation"));
  EXPECT_THAT(refusal({"body.evolving", "-o", "nodir/f%d.ply"}), HasSubstr("make its folder"));
  EXPECT_FALSE(std::filesystem::exists(folder / "nodir"));
  EXPECT_THAT(refusal({"body.evolving", "-o", "one_%d_%d.ply"}), HasSubstr("two places"));
  EXPECT_THAT(refusal({"body.evolving", "-o", "f%d.ply", "--frames", "7"}),
              HasSubstr("has no frame 7"));
  EXPECT_THAT(refusal({"body.evolving", "-o", "a.glb", "--frames", "0-2x2"}),
              HasSubstr("takes all frames"));
  EXPECT_THAT(
      refusal({"body.evolving", "-o", "f%d.ply", "--paint", "body/material/frame_0000.ply"}),
      HasSubstr("wants colours"));
  EXPECT_THAT(refusal({"body.evolving", "-o", "f%d.ply", "--size", "64"}), HasSubstr("--from"));
  ASSERT_EQ(marquetry(folder, {"sample", "torus", "-o", "other.ply"}).status, 0);
  EXPECT_THAT(refusal({"body.evolving", "-o", "f%d.ply", "--paint", "other.ply"}),
              HasSubstr("the first frame's own model"));
  EXPECT_THAT(refusal({"body/frame_0000.ply"}), HasSubstr("found no evolving mesh"));
  EXPECT_THAT(refusal({"none.evolving"}), HasSubstr("none.evolving"));
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

TEST(Track, GoesOnBeforeAFrameThatWasCapturedAnew) {
  const Folder folder;
  make_body(folder, "bending", 4);
  const std::vector<std::string> words = {"track", "body", "-o", "body.evolving", "--resume"};
  ASSERT_EQ(marquetry(folder, words).status, 0);
  const std::string before = file_bytes(folder / "body.blocks");
  EXPECT_THAT(marquetry(folder, words).error, HasSubstr("goes on after frame 4"));
  EXPECT_EQ(file_bytes(folder / "body.blocks"), before);
  Model model = read_model(folder / "body/frame_0003.ply");
  for (Vector3& p : model.mesh.positions) p.z() += 0.01;
  write_model(folder / "body/frame_0003.ply", model);
  const Result resumed = marquetry(folder, words);
  ASSERT_EQ(resumed.status, 0) << resumed.error;
  EXPECT_THAT(resumed.error, HasSubstr("body/frame_0003.ply was changed since"));
  EXPECT_THAT(resumed.error, HasSubstr("goes on after frame 2"));
  const std::string again = file_bytes(folder / "body.blocks");
  EXPECT_NE(again, before);
  ASSERT_EQ(marquetry(folder, {"track", "body", "-o", "whole.evolving"}).status, 0);
  EXPECT_EQ(again, file_bytes(folder / "whole.blocks"));
  // The template itself.
  model = read_model(folder / "body/frame_0000.ply");
  for (Vector3& p : model.mesh.positions) p.z() += 0.01;
  const std::string first = file_bytes(folder / "body/frame_0000.ply");
  write_model(folder / "body/frame_0000.ply", model);
  const Result other = marquetry(folder, words);
  EXPECT_EQ(other.status, 2);
  EXPECT_THAT(other.error, HasSubstr("frame_0000.ply is not the mesh that it was made of"));
  EXPECT_EQ(file_bytes(folder / "body.blocks"), again);
  write_bytes(folder / "body/frame_0000.ply", first);
  // What cannot be read instead loses nothing.
  write_bytes(folder / "body/frame_0003.ply", "");
  EXPECT_EQ(marquetry(folder, words).status, 2);
  EXPECT_EQ(file_bytes(folder / "body.blocks"), again);
}

TEST(Track, FollowsFramesThatWereLeftOutOnceTheyCanBeRead) {
  const Folder folder;
  make_body(folder, "bending", 4);
  const std::string sound = file_bytes(folder / "body/frame_0002.ply");
  write_bytes(folder / "body/frame_0002.ply", "ply\nformat");
  const std::vector<std::string> words = {"track",         "body",     "-o",
                                          "body.evolving", "--resume", "--skip-bad"};
  ASSERT_EQ(marquetry(folder, words).status, 0);
  EXPECT_EQ(EvolvingReader(folder / "body.evolving").frames().size(), 4U);
  write_bytes(folder / "body/frame_0002.ply", sound);
  const Result resumed = marquetry(folder, words);
  ASSERT_EQ(resumed.status, 0) << resumed.error;
  EXPECT_THAT(resumed.error, HasSubstr("frame_0002.ply is not in body.evolving, and can be"));
  ASSERT_EQ(marquetry(folder, {"track", "body", "-o", "whole.evolving"}).status, 0);
  EXPECT_EQ(file_bytes(folder / "body.blocks"), file_bytes(folder / "whole.blocks"));
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
