#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "cli/models.h"
#include "cli/refusal.h"
#include "mq/io/evolving_file.h"
#include "mq/io/vertex_colours.h"
#include "mq/mesh/orient.h"

namespace mq::test {
namespace {

using testing::HasSubstr;
using testing::Not;

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
  int added = 0, renewed = 0;
  for (const auto& frame : found["frames"]) {
    EXPECT_LT(frame["distance_p95"], 0.01);
    EXPECT_GT(frame["occupancy"], 0.2);
    EXPECT_GT(frame["charts"], 0);
    if (frame["frame"] == 28) continue;
    added += frame["triangles_born"].get<int>();
    renewed += frame["renewed"].get<int>();
  }
  EXPECT_GT(added, 0);  // the balls touch
  EXPECT_GE(renewed, added);
  const EvolvingMesh evolving = EvolvingReader(folder / "balls.evolving").read();
  EXPECT_NO_THROW(check(evolving));
  EXPECT_GT(evolving.segments.size(), 1U);
  for (const EvolvingSegment& segment : evolving.segments) EXPECT_FALSE(segment.uvs.empty());
}

TEST(Evolve, SaysWhatHelpsNoisyCaptures) {
  const Folder folder;
  const auto evolved = [&](const std::string& body, const std::vector<std::string>& noise,
                           const std::vector<std::string>& more) {
    std::vector<std::string> words{"sample", body, "-o", "captured/", "--triangles", "1200", "--frames", "0-4", "--overwrite"};
    words.insert(words.end(), noise.begin(), noise.end());
    EXPECT_EQ(marquetry(folder, words).status, 0);
    words = {"evolve", "captured", "-o", "e.evolving", "--size", "128", "--trials", "2", "--nodes", "9", "--overwrite"};
    words.insert(words.end(), more.begin(), more.end());
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 0) << result.error;
    return result.error;
  };
  const std::vector<std::string> noise{"--off", "0.25", "--holes", "3", "--handles", "2"};
  const auto advises = HasSubstr("with --look-ahead 0 texture coordinates of long ones last longer");
  EXPECT_THAT(evolved("bending", noise, {}), advises);
  EXPECT_THAT(evolved("bending", noise, {"--look-ahead", "0"}), Not(advises));
  EXPECT_THAT(evolved("bending", {}, {}), Not(advises));
}

/// How far a model's colours are from those of another, where that one's vertices are.
double colour_error(const Model& shown, const Model& captured) {
  const ColourAt at = surface_colours(shown), there = surface_colours(captured);
  const ClosestPointFinder closest(shown.mesh), own(captured.mesh);
  double sum = 0;
  for (const Vector3& p : captured.mesh.positions) {
    const auto a = at(closest(p)), b = there(own(p));
    for (int k = 0; k < 3; ++k) sum += std::abs(a[k] - b[k]) / 3;
  }
  return sum / captured.mesh.vertex_count();
}

TEST(ExportFrom, WritesWhatWasCapturedAsTextures) {
  const Folder folder;
  make_balls(folder, "28-30");
  ASSERT_EQ(marquetry(folder, evolve("balls.evolving")).status, 0);
  std::filesystem::create_directory(folder / "out");
  const Result result = marquetry(folder, {"export", "balls.evolving", "-o", "out/frame_%04d.obj",
                                           "--from", "balls", "--size", "256", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  const auto textures = result.json()["result"]["textures"];
  ASSERT_EQ(textures.size(), 3U);
  EXPECT_LT(textures[0]["unseen"].get<double>(), 0.05 * textures[0]["texels"].get<double>());
  EXPECT_EQ(textures[0]["filled"], textures[0]["unseen"]);
  EXPECT_GT(textures[0]["accuracy"], 0);
  EXPECT_LT(textures[2]["accuracy"], 0.01);
  const Model shown = read_model(folder / "out/frame_0028.obj");
  ASSERT_EQ(shown.textures.size(), 1U);
  EXPECT_EQ(shown.textures[0].pixels.width(), 256);
  const Model captured = read_model(folder / "balls/frame_0028.ply");
  // The first frame lies on what was captured; patches of colour differ by much more.
  EXPECT_LT(colour_error(shown, captured), 0.03);
  Model wrong = captured;
  wrong.colors.values =
      std::vector<float>(captured.colors.values.rbegin(), captured.colors.values.rend());
  EXPECT_GT(colour_error(shown, wrong), 0.1);
  // Pictures alone are the same.
  ASSERT_EQ(marquetry(folder, {"export", "balls.evolving", "-o", "texture_%02d.png", "--frames",
                               "28", "--from", "balls", "--size", "256"})
                .status,
            0);
  const Texture alone = read_texture(folder / "texture_28.png");
  EXPECT_TRUE(std::ranges::equal(alone.pixels.values(), shown.textures[0].pixels.values()));
}

TEST(ExportFrom, TurnsBackWhatFacesTheWrongWay) {
  const Folder folder;
  make_balls(folder, "28-28");
  ASSERT_EQ(marquetry(folder, {"track", "balls", "-o", "bare.evolving"}).status, 0);
  const std::vector<std::string> words = {"export",   "bare.evolving", "-o",
                                          "f_%d.ply", "--from",        "balls"};
  ASSERT_EQ(marquetry(folder, words).status, 0);
  const std::string sound = file_bytes(folder / "f_28.ply");
  Model model = read_model(folder / "balls/frame_0028.ply");
  std::vector<int> all(model.mesh.triangles.size());
  std::iota(all.begin(), all.end(), 0);
  model.mesh = with_flipped(std::move(model.mesh), all);
  write_model(folder / "balls/frame_0028.ply", model);
  const Result result = marquetry(folder, words);
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_THAT(result.error,
              HasSubstr("frame_0028.ply: 1240 triangles of parts that were inside out: flipped with their part"));
  EXPECT_EQ(file_bytes(folder / "f_28.ply"), sound);
}

TEST(ExportFrom, TakesTheSizeThatTheAtlasWasMadeFor) {
  const Folder folder;
  make_balls(folder, "28-28");
  ASSERT_EQ(marquetry(folder,
                      {"evolve", "balls", "-o", "balls.evolving", "--size", "320", "--trials", "2"})
                .status,
            0);
  const auto side_with = [&](std::vector<std::string> more, const std::string& warned) {
    std::vector<std::string> words = {"export",     "balls.evolving", "-o",
                                      "t_%02d.png", "--from",         "balls"};
    words.insert(words.end(), more.begin(), more.end());
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 0) << result.error;
    EXPECT_THAT(result.error, HasSubstr(warned));
    EXPECT_EQ(result.error.find("gutters") == std::string::npos, warned.empty()) << result.error;
    return read_texture(folder / "t_28.png").pixels.width();
  };
  EXPECT_EQ(side_with({}, ""), 320);
  EXPECT_EQ(side_with({"--size", "640"}, ""), 640);
  EXPECT_EQ(side_with({"--size", "256"}, "256 texels, and the atlas was made for 320"), 256);
}

TEST(ExportFrom, GivesColoursAtVerticesWhereThereIsNoAtlas) {
  const Folder folder;
  make_balls(folder, "28-29");
  ASSERT_EQ(marquetry(folder, {"track", "balls", "-o", "bare.evolving"}).status, 0);
  ASSERT_EQ(
      marquetry(folder, {"export", "bare.evolving", "-o", "f_%02d.ply", "--from", "balls"}).status,
      0);
  EXPECT_FALSE(std::filesystem::exists(folder / "f_28.png"));
  for (const std::string number : {"28", "29"}) {
    const Model shown = read_model(folder / ("f_" + number + ".ply"));
    const Model captured = read_model(folder / ("balls/frame_00" + number + ".ply"));
    ASSERT_EQ(shown.colors.channels, 3);
    const Signal own = vertex_colours(shown), there = vertex_colours(captured);
    const std::vector<ClosestPoint> places =
        ClosestPointFinder(captured.mesh)(shown.mesh.positions);
    // Where the bodies have merged what follows them is on neither.
    int asked = 0;
    for (int v = 0; v < shown.mesh.vertex_count(); ++v) {
      if (places[v].squared_distance > 1e-6) continue;
      ++asked;
      Eigen::RowVector3d wanted = Eigen::RowVector3d::Zero();
      for (int k = 0; k < 3; ++k)
        wanted +=
            places[v].barycentric[k] * there.row(captured.mesh.triangles[places[v].triangle][k]);
      ASSERT_LT((own.row(v) - wanted).norm(), 0.01) << "frame " << number << ", vertex " << v;
    }
    EXPECT_GT(asked, 0.85 * shown.mesh.vertex_count());
  }
}

TEST(ExportFrom, PutsTexturesIntoAnAnimation) {
  const Folder folder;
  make_balls(folder, "28-30");
  ASSERT_EQ(marquetry(folder, evolve("balls.evolving")).status, 0);
  const std::size_t segments = EvolvingReader(folder / "balls.evolving").segments().size();
  const Result result = marquetry(
      folder, {"export", "balls.evolving", "-o", "a.glb", "--from", "balls", "--size", "128"});
  ASSERT_EQ(result.status, 0) << result.error;
  const std::string bytes = file_bytes(folder / "a.glb");
  std::uint32_t size = 0;
  std::memcpy(&size, bytes.data() + 12, sizeof size);
  EXPECT_EQ(nlohmann::json::parse(bytes.substr(20, size))["images"].size(), segments);
  const Model shown = read_model(folder / "a.glb");
  ASSERT_EQ(shown.textures.size(), 1U);
  // What is shown first lies on the first frame, in its colours.
  ASSERT_EQ(marquetry(folder, {"export", "balls.evolving", "-o", "f_%02d.obj", "--frames", "28",
                               "--from", "balls", "--size", "128"})
                .status,
            0);
  EXPECT_TRUE(std::ranges::equal(shown.textures[0].pixels.values(),
                                 read_model(folder / "f_28.obj").textures[0].pixels.values()));
}

TEST(ExportFrom, RefusesWhatItCannotDo) {
  const Folder folder;
  make_balls(folder, "28-29");
  ASSERT_EQ(marquetry(folder, {"track", "balls", "-o", "bare.evolving"}).status, 0);
  const auto refused = [&](std::vector<std::string> words, const std::string& output) {
    words.insert(words.begin(), {"export", "bare.evolving"});
    return refusal(folder, words, output);
  };
  EXPECT_THAT(refused({"-o", "t_%02d.png", "--from", "balls"}, "t_28.png"),
              HasSubstr("no texture coordinates"));
  EXPECT_THAT(refused({"-o", "t.png", "--from", "balls"}, "t.png"), HasSubstr("a place for the"));
  EXPECT_THAT(refused({"-o", "t_%02d.ply", "--from", "cubes"}, "t_28.ply"), HasSubstr("cubes"));
  EXPECT_THAT(refused({"--from", "balls"}, "t_28.png"), HasSubstr("--output"));
  const Result missing =
      marquetry(folder, {"export", "bare.evolving", "-o", "t_%02d.ply", "--from", "nothere/"});
  EXPECT_EQ(missing.status, 2);
  EXPECT_EQ(missing.output, "");
  EXPECT_THAT(refused({"-o", "t_%02d.ply", "--from", "balls", "--stitch"}, "t_28.ply"),
              HasSubstr("no texture coordinates"));
  EXPECT_THAT(refused({"--stitch"}, "t_28.ply"), HasSubstr("--stitch"));
}

TEST(ExportFrom, TakesOutStepsBetweenCapturedCharts) {
  const Folder folder;
  // A captured frame in charts, each photographed with another exposure, and all with the same.
  for (const std::string name : {"photos", "true"}) {
    std::vector<std::string> words = {"sample", "bust", "-o",          name + "/",
                                      "--size", "256",  "--triangles", "3000"};
    if (name == "photos") words.emplace_back("--misaligned");
    ASSERT_EQ(marquetry(folder, words).status, 0);
    for (const std::string number : {"1", "2"})
      std::filesystem::copy(folder / (name + "/bust.obj"),
                            folder / (name + "/f_" + number + ".obj"));
  }
  ASSERT_EQ(marquetry(folder, {"evolve", "photos/f_%d.obj", "--frames", "1-2", "-o", "b.evolving",
                               "--size", "256", "--trials", "2"})
                .status,
            0);
  const auto steps = [&](const std::string& name) {
    const Result result =
        marquetry(folder, {"export", "b.evolving", "-o", name + "_%d.png", "--frames", "2",
                           "--from", name + "/f_%d.obj", "--size", "512", "--stitch", "--json"});
    EXPECT_EQ(result.status, 0) << result.error;
    return result.json()["result"]["textures"][0]["steps"];
  };
  const auto photos = steps("photos"), truth = steps("true");
  EXPECT_GT(photos["before"]["across"], 1.4 * truth["before"]["across"].get<double>());
  // As even as what was photographed with one exposure, up to what that has of steps itself.
  EXPECT_LT(photos["after"]["across"], 1.02 * truth["before"]["across"].get<double>());
  EXPECT_NEAR(photos["after"]["within"], photos["before"]["within"].get<double>(), 0.001);
  // Colours at vertices have no charts.
  make_balls(folder, "28-29");
  ASSERT_EQ(marquetry(folder, evolve("balls.evolving")).status, 0);
  EXPECT_THAT(
      refusal(folder, {"export", "balls.evolving", "-o", "u_%d.png", "--from", "balls", "--stitch"},
              "u_28.png"),
      HasSubstr("between charts"));
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
