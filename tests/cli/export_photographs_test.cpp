// Photographs of a body that moves, with their cameras, as textures of the mesh that follows it.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cli/models.h"
#include "cli/refusal.h"
#include "mq/io/model.h"
#include "mq/io/vertex_colours.h"
#include "mq/mesh/closest_point.h"

namespace mq::test {
namespace {

using testing::HasSubstr;

/// Two frames, followed and with an atlas, photographed from ten sides.
class PhotographedBody : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new Folder;
    run({"sample", "bending", "-o", "body/", "--triangles", "1000", "--frames", "0-1"});
    run({"track", "body", "-o", "body.evolving"});
    run({"unwrap", "body.evolving", "-o", "laid.evolving", "--size", "128", "--trials", "2"});
    for (const int frame : {0, 1}) photograph(frame);
  }
  static void TearDownTestSuite() { delete folder_; }

  static void run(const std::vector<std::string>& words) {
    const Result result = marquetry(*folder_, words);
    ASSERT_EQ(result.status, 0) << result.error;
  }

  static void photograph(int frame) {
    std::filesystem::create_directories(*folder_ / fmt::format("shots/{:04}", frame));
    nlohmann::json all;
    for (int k = 0; k < 10; ++k) {
      const std::string picture = fmt::format("shots/{:04}/side{}.png", frame, k);
      run({"render", fmt::format("body/frame_{:04}.ply", frame), "-o", picture, "--view",
           k < 8 ? fmt::format("{},{}", 45 * k, k % 2 == 0 ? 30 : -30) : k == 8 ? "0,85" : "0,-85", "--size", "240x240", "--unlit", "--cameras", "one.json",
           "--overwrite"});
      nlohmann::json camera = nlohmann::json::parse(file_bytes(*folder_ / "one.json"))["cameras"][0];
      camera["image"] = picture;
      all["cameras"].push_back(camera);
    }
    write_bytes(*folder_ / fmt::format("cameras_{:04}.json", frame), all.dump());
    // Of a rig that stands still: names alone.
    for (nlohmann::json& camera : all["cameras"])
      camera["image"] = std::filesystem::path(camera["image"].get<std::string>()).filename().string();
    write_bytes(*folder_ / fmt::format("rig_{}.json", frame), all.dump());
  }

  static Result exported(std::vector<std::string> words, const std::string& output) {
    std::filesystem::create_directories((*folder_ / output).parent_path());
    words.insert(words.begin(), {"export", "laid.evolving", "-o", output, "--size", "128", "--json"});
    return marquetry(*folder_, words);
  }

  static Folder* folder_;
};
Folder* PhotographedBody::folder_ = nullptr;

/// Of the colours of two models, at the vertices of the second.
double mean_difference(const Model& shown, const Model& truth) {
  const ColourAt at = surface_colours(shown), there = surface_colours(truth);
  const std::vector<ClosestPoint> places = ClosestPointFinder(shown.mesh)(truth.mesh.positions),
                                  own = ClosestPointFinder(truth.mesh)(truth.mesh.positions);
  double sum = 0;
  for (std::size_t v = 0; v < places.size(); ++v)
    for (std::size_t c = 0; c < 3; ++c) sum += std::abs(at(places[v])[c] - there(own[v])[c]) / 3;
  return sum / double(places.size());
}

TEST_F(PhotographedBody, HasTheColoursThatItsMeshesHave) {
  const Result result = exported({"--from", "cameras_%04d.json"}, "seen/t_%04d.obj");
  ASSERT_EQ(result.status, 0) << result.error;
  ASSERT_EQ(exported({"--from", "body"}, "meshes/t_%04d.obj").status, 0);
  const auto frames = result.json()["result"]["textures"];
  ASSERT_EQ(frames.size(), 2U);
  for (const auto& frame : frames) {
    EXPECT_GT(frame["texels"], 5000);
    EXPECT_LT(frame["unseen"].get<double>(), 0.1 * frame["texels"].get<double>());
    EXPECT_LE(frame["changed"].get<double>(), 0.2);
  }
  for (const char* name : {"0000", "0001"}) {
    const Model seen = read_model(*folder_ / fmt::format("seen/t_{}.obj", name));
    const Model truth = read_model(*folder_ / fmt::format("body/frame_{}.ply", name));
    const Model resampled = read_model(*folder_ / fmt::format("meshes/t_{}.obj", name));
    const double most = mean_difference(resampled, truth);  // as well as texels of this size can
    EXPECT_LT(most, 0.03) << name;
    EXPECT_LT(mean_difference(seen, truth), most + 0.01) << name;
  }
}

TEST_F(PhotographedBody, KeepsItsPhotographsAsSteadilyAsIsAsked) {
  const auto changed = [](const char* steady, const std::string& output) {
    const Result result = exported({"--from", "cameras_%04d.json", "--steady", steady}, output);
    EXPECT_EQ(result.status, 0) << result.error;
    return result.json()["result"]["textures"][1]["changed"].get<double>();
  };
  const double kept = changed("100", "kept/t_%04d.png"), anew = changed("0", "anew/t_%04d.png");
  EXPECT_LT(kept, 0.5 * anew);
  EXPECT_GT(anew, 0.005);
}

TEST_F(PhotographedBody, IsSeenByARigThatStandsStill) {
  ASSERT_EQ(exported({"--from", "cameras_%04d.json", "--frames", "1"}, "by_frame/t_%04d.png").status, 0);
  const Result rig = exported({"--from", "rig_1.json", "--images", "shots/%04d", "--frames", "1"}, "rig/t_%04d.png");
  ASSERT_EQ(rig.status, 0) << rig.error;
  EXPECT_EQ(file_bytes(*folder_ / "by_frame/t_0001.png"), file_bytes(*folder_ / "rig/t_0001.png"));
}

TEST_F(PhotographedBody, IsRefusedWithOptionsOfMeshesAndTheOtherWayRound) {
  const auto refused = [](std::vector<std::string> words) {
    words.insert(words.begin(), {"export", "laid.evolving", "-o", "no_%04d.png"});
    return refusal(*folder_, words, "no_0000.png");
  };
  for (const char* name : {"--stitch", "--samples=3"})
    EXPECT_THAT(refused({"--from", "cameras_%04d.json", name}), HasSubstr("it is of captured meshes"));
  for (const char* name : {"--images=shots", "--steady=1"})
    EXPECT_THAT(refused({"--from", "body", name}), HasSubstr("it is of photographs"));
  EXPECT_THAT(refused({"--from", "other_%04d.json"}), HasSubstr("the cameras of frame 0 are not there"));
  EXPECT_THAT(refused({"--from", "rig_0.json", "--images", "nowhere/%04d"}),
              HasSubstr("nowhere/0000: wanted a folder"));
  for (const std::vector<std::string>& images : std::vector<std::vector<std::string>>{{}, {"--images", "shots/0000"}}) {
    std::vector<std::string> words = {"--from", "rig_0.json"};
    words.insert(words.end(), images.begin(), images.end());
    EXPECT_THAT(refused(words), HasSubstr("--images says where those of each frame are"));
  }
  const std::vector<std::string> without = {"export", "body.evolving", "-o", "no_%04d.ply", "--from", "cameras_%04d.json"};
  EXPECT_THAT(refusal(*folder_, without, "no_0000.ply"), HasSubstr("unwrap it first"));
}

}  // namespace
}  // namespace mq::test
