// Shapes that are filtered: what is written, what is said of them, what is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cli/models.h"
#include "fixtures.h"
#include "mq/io/normals.h"
#include "mq/mesh/geometry.h"
#include "mq/mesh/volume.h"
#include "mq/sample/shapes.h"

namespace mq::test {
namespace {

using testing::HasSubstr;
using testing::Not;
using Words = std::vector<std::string>;
using Json = nlohmann::json;

void write_mesh(const Folder& folder, const std::string& name, const Mesh& mesh) {
  Model model;
  model.mesh = mesh;
  write_model(folder / name, model);
}

Mesh bumpy_sphere() {
  Mesh mesh = fixtures::sphere(4);
  for (Vector3& p : mesh.positions) p *= 1 + 0.05 * std::sin(20 * p.x()) * std::sin(20 * p.y());
  return mesh;
}

Result filter(const Folder& folder, const Words& more) {
  Words words = {"filter", "--geometry"};
  words.insert(words.end(), more.begin(), more.end());
  return marquetry(folder, words);
}

TEST(FilterGeometry, SmoothsAndSharpensAShapeAndSaysHowItChanged) {
  const Folder folder;
  write_mesh(folder, "ball.ply", bumpy_sphere());
  const Mesh before = read_model(folder / "ball.ply").mesh;
  const double area = [&] {
    double sum = 0;
    for (const double a : triangle_areas(before)) sum += a;
    return sum;
  }();
  for (const bool normals : {false, true})
    for (const char* beta : {"0", "3"}) {
      Words words = {"ball.ply", "-o", "out.ply", "--beta", beta, "--length", "3%", "--json"};
      if (normals) words.push_back("--normals");
      const Result result = filter(folder, words);
      ASSERT_EQ(result.status, 0) << result.error;
      const Json found = result.json()["result"];
      const Mesh after = read_model(folder / "out.ply").mesh;
      EXPECT_TRUE(after.triangles == before.triangles);
      EXPECT_NEAR(found["area"]["before"].get<double>(), area, 1e-6);
      EXPECT_NEAR(found["volume"]["after"].get<double>(), enclosed_volume(after), 1e-4);
      EXPECT_GT(found["largest_moved"].get<double>(), 0.005);
      if (!normals || *beta == '0') {
        EXPECT_EQ(found["area"]["change"].get<double>() > 0, *beta == '3');
      }
      EXPECT_TRUE(result.json()["solve"]["converged"].get<bool>());
    }
  write_mesh(folder, "torus.ply", fixtures::torus(48, 24));
  const Result thin =
      filter(folder, {"torus.ply", "-o", "out.ply", "--beta", "9", "--length", "10%", "--normals", "--json"});
  ASSERT_EQ(thin.status, 0) << thin.error;
  EXPECT_LT(thin.json()["result"]["volume"]["change"].get<double>(), -0.1);
  EXPECT_THAT(thin.error, HasSubstr("parts that are thin may have come through each other; without --normals"));
  // Said before it begins as well.
  EXPECT_LT(thin.error.find("may come through itself"), thin.error.find("% prepare")) << thin.error;
  const Result said = filter(folder, {"ball.ply", "-o", "out.ply", "--beta", "0"});
  EXPECT_THAT(said.output, HasSubstr("area 12.")) << said.output;
  EXPECT_THAT(said.output, HasSubstr("volume 4."));
}

TEST(FilterGeometry, ChangesNothingAtBetaOneAndAlphaZero) {
  const Folder folder;
  write_strip(folder);
  write_mesh(folder, "ball.ply", bumpy_sphere());
  for (const Words& words :
       {Words{"--beta", "1"}, Words{"--beta", "0", "--alpha", "0"}, Words{"--beta", "1", "--normals"},
        Words{"--beta", "0", "--alpha", "0", "--normals"}}) {
    Words all = {"strip.obj", "-o", "out.obj"};
    all.insert(all.end(), words.begin(), words.end());
    const Result result = filter(folder, all);
    ASSERT_EQ(result.status, 0) << result.error;
    EXPECT_EQ(file_bytes(folder / "out.obj"), file_bytes(folder / "strip.obj"));
    EXPECT_TRUE(std::filesystem::exists(folder / "strip.png"));
    all[0] = "ball.ply", all[2] = "out.ply";
    ASSERT_EQ(filter(folder, all).status, 0);
    EXPECT_EQ(file_bytes(folder / "out.ply"), file_bytes(folder / "ball.ply"));
  }
}

TEST(FilterGeometry, KeepsTextureCoordinatesAndWordsOfAFile) {
  const Folder folder;
  write_bytes(folder / "tent.obj",
              "# a tent\no tent\n"
              "v 0 0 0\nv 1 0 0.5\nv 2 0 0\nv 0 1 0\nv 1 1 0.5\nv 2 1 0\n"
              "vt 0.05 0.1\nvt 0.45 0.1\nvt 0.45 0.9\nvt 0.05 0.9\n"
              "g left\nf 1/1 2/2 5/3 4/4\ng right\nf 2 3 6 5\n");
  const Result result =
      filter(folder, {"tent.obj", "-o", "flat.obj", "--beta", "0", "--length", "0.5", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_TRUE(result.json()["result"]["volume"].is_null());
  const std::string text = file_bytes(folder / "flat.obj");
  EXPECT_THAT(text, HasSubstr("# a tent\n"));
  EXPECT_THAT(text, HasSubstr("g left\nf 1/1 2/2 5/3 4/4\ng right\nf 2 3 6 5\n"));
  EXPECT_THAT(text, Not(HasSubstr("v 1 0 0.5\n")));
}

TEST(FilterGeometry, MovesCopiesOfAVertexTogether) {
  const Folder folder;
  Mesh soup = fixtures::triangle_soup(bumpy_sphere());
  write_mesh(folder, "soup.ply", soup);
  write_mesh(folder, "ball.ply", bumpy_sphere());
  for (const char* name : {"soup", "ball"})
    ASSERT_EQ(filter(folder, {std::string(name) + ".ply", "-o", std::string(name) + "_out.ply",
                              "--beta", "0", "--length", "5%"}).status,
              0);
  const Mesh one = read_model(folder / "soup_out.ply").mesh;
  const Mesh two = read_model(folder / "ball_out.ply").mesh;
  for (int t = 0; t < one.triangle_count(); ++t)
    for (int k = 0; k < 3; ++k)
      EXPECT_LT((one.position(t, k) - two.position(t, k)).norm(), 1e-5);
}

TEST(FilterGeometry, WorksWhereSpotsAndMasksSay) {
  const Folder folder;
  Model model;
  model.mesh = bumpy_sphere();
  model.colors = {.channels = 3, .values = {}, .depth = Depth::u8};
  for (const Vector3& p : model.mesh.positions)
    model.colors.values.insert(model.colors.values.end(), 3, p.z() > 0 ? 1.0F : 0.0F);
  write_model(folder / "ball.ply", model);
  const Mesh before = read_model(folder / "ball.ply").mesh;
  for (const Words& where : {Words{"--spot", "0,0,1,0.8"}, Words{"--mask", "ball.ply"}}) {
    Words words = {"ball.ply", "-o", "out.ply", "--beta", "0", "--length", "2%", "--json"};
    words.insert(words.end(), where.begin(), where.end());
    const Result result = filter(folder, words);
    ASSERT_EQ(result.status, 0) << result.error;
    EXPECT_GT(result.json()["result"]["mask"]["mean"].get<double>(), 0.05);
    const Mesh after = read_model(folder / "out.ply").mesh;
    double top = 0, bottom = 0;
    for (std::size_t v = 0; v < before.positions.size(); ++v) {
      const double moved = (after.positions[v] - before.positions[v]).norm();
      if (before.positions[v].z() > 0.8) top = std::max(top, moved);
      if (before.positions[v].z() < -0.5) bottom = std::max(bottom, moved);
    }
    EXPECT_GT(top, 5e-3);
    EXPECT_LT(bottom, 1e-4);
  }
}

TEST(FilterGeometry, TurnsTheNormalsOfTheFile) {
  const Folder folder;
  write_bytes(folder / "pyramid.obj",
              "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 -1\n"
              "f 1//1 3//1 2//1\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
  const Result result =
      filter(folder, {"pyramid.obj", "-o", "out.obj", "--beta", "0", "--length", "10%"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("pyramid.obj: says normals"));
  const CornerFrames frames = file_frames(read_model(folder / "out.obj"));
  ASSERT_EQ(frames.normals.size(), 12U);
  EXPECT_LT((frames.normals[0] + Eigen::Vector3f::UnitZ()).norm(), 0.3F)
      << "of the file, hardly turned";
  for (const Eigen::Vector3f& n : frames.normals) EXPECT_NEAR(n.norm(), 1, 1e-5F);
  write_bytes(folder / "pyramid.ply",
              "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
              "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
              "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
              "0 0 0 0.6 0 0.8\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n");
  ASSERT_EQ(filter(folder, {"pyramid.ply", "-o", "out.ply", "--beta", "3"}).status, 0);
  EXPECT_EQ(file_frames(read_model(folder / "out.ply")).normals[0], Eigen::Vector3f(0.6F, 0, 0.8F))
      << "a triangle that grows in its plane is not turned";
  // Nothing moved: they are true.
  ASSERT_EQ(filter(folder, {"pyramid.obj", "-o", "same.obj", "--beta", "1"}).status, 0);
  EXPECT_EQ(file_bytes(folder / "same.obj"), file_bytes(folder / "pyramid.obj"));
}

TEST(FilterGeometry, KeepsCreasesWhereAsked) {
  const Folder folder;
  Mesh cube = fixtures::flat_square(20);
  for (Vector3& p : cube.positions) p.z() = -std::abs(p.x() - 0.5);
  write_mesh(folder, "roof.ply", cube);
  const auto moved = [&](const Words& more) {
    Words words = {"roof.ply", "-o", "out.ply", "--beta", "0", "--length", "5%", "--json"};
    words.insert(words.end(), more.begin(), more.end());
    const Result result = filter(folder, words);
    EXPECT_EQ(result.status, 0) << result.error;
    const Mesh after = read_model(folder / "out.ply").mesh;
    return std::abs(after.positions[10 * 21 + 10].z());
  };
  EXPECT_LT(moved({"--by-curvature", "20%"}), 0.6 * moved({}));
}

TEST(FilterGeometry, SolvesByMultigridAsByFactorisation) {
  const Folder folder;
  write_mesh(folder, "ball.ply", bumpy_sphere());
  const auto shape = [&](const Words& more) {
    Words words = {"ball.ply", "-o", "out.ply", "--beta", "0", "--normals", "--length", "5%",
                   "--json"};
    words.insert(words.end(), more.begin(), more.end());
    const Result result = filter(folder, words);
    EXPECT_EQ(result.status, 0) << result.error;
    return std::pair(result.json()["solve"]["method"].get<std::string>(),
                     read_model(folder / "out.ply").mesh.positions);
  };
  const auto direct = shape({"--solver", "direct"});
  const auto iterated = shape({"--solver", "multigrid", "--tolerance", "1e-9"});
  EXPECT_THAT(direct.first, HasSubstr("direct"));
  EXPECT_EQ(iterated.first, "multigrid");
  for (std::size_t v = 0; v < direct.second.size(); ++v)
    EXPECT_LT((direct.second[v] - iterated.second[v]).norm(), 1e-5);
}

TEST(FilterGeometry, GivesTheSameBitsForAnyNumberOfThreads) {
  const Folder folder;
  write_mesh(folder, "ball.ply", bumpy_sphere());
  const auto bytes = [&](const char* threads) {
    EXPECT_EQ(filter(folder, {"ball.ply", "-o", "out.ply", "--beta", "2", "--normals",
                              "--by-curvature", "5%", "--threads", threads}).status,
              0);
    return file_bytes(folder / "out.ply");
  };
  const std::string one = bytes("1");
  EXPECT_TRUE(one == bytes("2"));
  EXPECT_TRUE(one == bytes("7"));
}

TEST(FilterGeometry, IsRepeatedFromItsReport) {
  const Folder folder;
  write_mesh(folder, "ball.ply", bumpy_sphere());
  ASSERT_EQ(filter(folder, {"ball.ply", "-o", "a.ply", "--beta", "0", "--normals", "--report",
                            "r.json"}).status,
            0);
  const Result again = marquetry(folder, {"filter", "--config", "r.json", "-o", "b.ply"});
  ASSERT_EQ(again.status, 0) << again.error;
  EXPECT_EQ(file_bytes(folder / "a.ply"), file_bytes(folder / "b.ply"));
}

TEST(FilterGeometry, SaysWhatItCannotDo) {
  const Folder folder;
  write_strip(folder);
  const auto error = [&](const Words& more) {
    Words words = {"filter", "strip.obj", "--beta", "0"};
    words.insert(words.end(), more.begin(), more.end());
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 2);
    return result.error;
  };
  EXPECT_THAT(error({"-o", "o.png", "--geometry"}), HasSubstr("wanted a model"));
  EXPECT_THAT(error({"-o", "o.obj", "--geometry", "--length", "8tx"}),
              HasSubstr("strip.obj: a length in texels needs a texture"));
  EXPECT_THAT(error({"-o", "o.obj", "--geometry", "--mask", "strip.png"}),
              HasSubstr("strip.png: --mask: colours at vertices have no texels"));
  EXPECT_THAT(error({"-o", "o.obj", "--geometry", "--normals", "--spot", "0,0,0,1"}),
              HasSubstr("leave --normals out"));
  EXPECT_THAT(error({"-o", "o.obj", "--geometry", "--vertices"}), HasSubstr("contradict"));
  EXPECT_THAT(error({"strip.png", "-o", "o.obj", "--geometry"}),
              HasSubstr("strip.obj: --geometry changes its shape, and 'strip.png' would not be"));
  EXPECT_THAT(error({"-o", "o.obj", "--geometry", "--by-curvature", "x"}), HasSubstr("curvature"));
  for (const char* name : {"--by-curvature", "--smooth-normals", "--fit-weight", "--fit-steps"})
    EXPECT_THAT(error({"-o", "o.obj", name, "2"}), HasSubstr("give --geometry too"));
  for (const char* name : {"--fit-weight", "--fit-steps"})
    EXPECT_THAT(error({"-o", "o.obj", "--geometry", name, "2"}), HasSubstr("give --normals too"));
  EXPECT_THAT(error({"-o", "o.obj", "--geometry", "--smooth-normals", "2"}),
              HasSubstr("give --by-curvature too"));
  write_bytes(folder / "line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
  const Result flat = marquetry(folder, {"filter", "line.obj", "-o", "o.obj", "--geometry", "--beta", "0"});
  EXPECT_EQ(flat.status, 2);
  EXPECT_THAT(flat.error, HasSubstr("line.obj: the surface has no area"));
}

/// A cube with rounded edges, as a model of the folder.
void write_rounded_cube(const Folder& folder) {
  write_mesh(folder, "cube.ply", cube_cross(24).mesh);
  ASSERT_EQ(filter(folder, {"cube.ply", "-o", "round.ply", "--beta", "0", "--length", "3%"}).status,
            0);
}

/// By how much normals miss the axis they are nearest to, radians, in the mean.
double off_axes(const Mesh& mesh) {
  double sum = 0;
  for (const Vector3& n : triangle_normals(mesh))
    sum += std::acos(std::min(1.0, n.cwiseAbs().maxCoeff()));
  return sum / mesh.triangle_count();
}

TEST(ShockGeometry, GivesARoundedCubeItsEdgesBack) {
  const Folder folder;
  write_rounded_cube(folder);
  const double before = off_axes(read_model(folder / "round.ply").mesh);
  for (const char* time : {"10", "1e6"}) {
    const Result result =
        marquetry(folder, {"shock", "round.ply", "--geometry", "-o", "sharp.ply", "--time", time,
                           "--fit-steps", "3", "--json"});
    ASSERT_EQ(result.status, 0) << result.error;
    EXPECT_LT(off_axes(read_model(folder / "sharp.ply").mesh), 0.8 * before);
    const Json found = result.json()["result"];
    EXPECT_LT(found["area"]["change"].get<double>(), 0);
    EXPECT_TRUE(found["volume"]["change"].is_number());
    EXPECT_GT(found["paths"]["triangles_crossed"].get<double>(), 0);
    if (time == std::string("1e6")) {
      EXPECT_EQ(found["paths"]["at_rest"].get<int>(),
                3 * read_model(folder / "round.ply").mesh.triangle_count());
    }
  }
}

TEST(ShockGeometry, LeavesTheFileAloneAtTimeZero) {
  const Folder folder;
  write_strip(folder);
  for (const char* time : {"--time", "--absolute-time"}) {
    const Result result = marquetry(
        folder, {"shock", "strip.obj", "-g", "-o", "same.obj", time, "0", "--fit-steps", "2"});
    ASSERT_EQ(result.status, 0) << result.error;
    EXPECT_EQ(file_bytes(folder / "same.obj"), file_bytes(folder / "strip.obj"));
  }
}

TEST(ShockGeometry, IsRepeatedFromItsReportWithAnyNumberOfThreads) {
  const Folder folder;
  write_rounded_cube(folder);
  ASSERT_EQ(marquetry(folder, {"shock", "round.ply", "-g", "-o", "a.ply", "--report", "r.json",
                               "--threads", "1"}).status,
            0);
  const Result again =
      marquetry(folder, {"shock", "--config", "r.json", "-o", "b.ply", "--threads", "7"});
  ASSERT_EQ(again.status, 0) << again.error;
  EXPECT_EQ(file_bytes(folder / "a.ply"), file_bytes(folder / "b.ply"));
}

TEST(ShockGeometry, SaysWhatItCannotDo) {
  const Folder folder;
  write_strip(folder);
  const auto error = [&](const Words& more) {
    Words words = {"shock", "strip.obj", "--geometry"};
    words.insert(words.end(), more.begin(), more.end());
    const Result result = marquetry(folder, words);
    EXPECT_EQ(result.status, 2);
    return result.error;
  };
  EXPECT_THAT(error({"-o", "o.png"}), HasSubstr("wanted a model"));
  EXPECT_THAT(error({"-o", "o.obj", "--method", "osher-rudin"}), HasSubstr("--method is for pictures"));
  EXPECT_THAT(error({"-o", "o.obj", "--smooth", "2tx"}), HasSubstr("texels needs a texture"));
  EXPECT_THAT(error({"-o", "o.obj", "--vertices"}), HasSubstr("contradict"));
  EXPECT_THAT(error({"strip.png", "-o", "o.obj"}),
              HasSubstr("strip.obj: --geometry changes its shape, and 'strip.png' would not be"));
  EXPECT_THAT(error({"-o", "o.obj", "--flipped", "keep"}), HasSubstr("--flipped is for charts"));
}

TEST(ShockGeometry, SmoothsNormalsAtTimeZeroWhereAsked) {
  const Folder folder;
  write_mesh(folder, "ball.ply", bumpy_sphere());
  const Result result = marquetry(folder, {"shock", "ball.ply", "-g", "-o", "o.ply", "-t", "0",
                                           "--smooth-normals", "3%", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_GT(result.json()["result"]["largest_moved"].get<double>(), 5e-3);
}

TEST(ShockGeometry, LeavesACleanCubeAlone) {
  const Folder folder;
  write_mesh(folder, "cube.ply", cube_cross(24).mesh);
  for (const char* time : {"1e-9", "2", "1e6"}) {
    ASSERT_EQ(marquetry(folder, {"shock", "cube.ply", "-g", "-o", "o.ply", "-t", time}).status, 0);
    EXPECT_EQ(file_bytes(folder / "o.ply"), file_bytes(folder / "cube.ply"));
  }
}

TEST(ShockGeometry, WarnsWhereALotOfTheShapeGoes) {
  // All normals of a torus come to be those at its outer equator, where it curves least.
  const Folder folder;
  write_mesh(folder, "torus.ply", fixtures::torus(48, 24));
  const Result result =
      marquetry(folder, {"shock", "torus.ply", "-g", "-o", "o.ply", "-t", "5", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("warning: the volume changed by -"));
  EXPECT_LT(result.json()["result"]["volume"]["change"].get<double>(), -0.1);
  EXPECT_THAT(result.json()["result"]["warnings"].back().get<std::string>(),
              HasSubstr("--smooth-potential"));
  const Result less =
      marquetry(folder, {"shock", "torus.ply", "-g", "-o", "o.ply", "-t", "0.1", "--json"});
  EXPECT_TRUE(less.json()["result"]["warnings"].empty());
  EXPECT_THAT(less.error, Not(HasSubstr("warning: the")));
}

}  // namespace
}  // namespace mq::test
