// marquetry remesh, run as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "cli/models.h"
#include "cli/refusal.h"
#include "fixtures.h"
#include "mq/mesh/surface.h"

namespace mq::test {
namespace {

using ::testing::HasSubstr;

/// A ball with a colour everywhere, bulging on top by `bump`.
void write_ball(const Folder& folder, const std::string& name, int levels, double bump,
                float grey) {
  Model model;
  model.path = folder / name;
  model.mesh = fixtures::sphere(levels);
  for (Vector3& p : model.mesh.positions)
    p *= 1 + bump * std::exp(-8 * (p - Vector3(0, 0, 1)).squaredNorm());
  model.colors = {3, std::vector<float>(3 * model.mesh.positions.size(), grey), Depth::f32};
  write_model(model.path, model);
}

TEST(Remesh, KeepsWhatItCanAndSaysWhat) {
  const Folder folder;
  write_ball(folder, "a.ply", 4, 0, 0.25F);
  write_ball(folder, "b.ply", 5, 0.5, 0.75F);
  const Result result = marquetry(
      folder, {"remesh", "a.ply", "b.ply", "-o", "o.ply", "--record", "record.json", "--json"});
  ASSERT_EQ(result.status, 0) << result.error;
  const nlohmann::json found = result.json()["result"];
  const Model before = read_model(folder / "a.ply"), after = read_model(folder / "o.ply");
  const nlohmann::json record = nlohmann::json::parse(file_bytes(folder / "record.json"));
  EXPECT_TRUE(found["manifold"]);
  EXPECT_EQ(found["regions"], 1);
  EXPECT_GT(found["triangles_kept"]["fraction"], 0.5);
  EXPECT_LT(found["from_target"]["max"], 0.05);
  EXPECT_EQ(after.mesh.triangle_count(), found["triangles"]);
  EXPECT_EQ(make_surface(after.mesh).boundary_edges, 0);
  int kept = 0;
  for (int t = 0; t < after.mesh.triangle_count(); ++t) {
    const int source = record["template_triangles"][std::size_t(t)];
    if (source < 0) continue;
    ++kept;
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(after.mesh.position(t, k), before.mesh.position(source, k));
  }
  EXPECT_EQ(kept, found["triangles_kept"]["count"]);
  ASSERT_EQ(after.colors.channels, 3);
  for (int v = 0; v < after.mesh.vertex_count(); ++v)
    EXPECT_EQ(after.colors.values[3 * std::size_t(v)],
              record["template_vertices"][std::size_t(v)] >= 0 ? 0.25F : 0.75F);
}

TEST(Remesh, PaintsWhatWasBorn) {
  const Folder folder;
  write_ball(folder, "a.ply", 4, 0, 0.25F);
  write_ball(folder, "b.ply", 4, 0.5, 0.75F);
  ASSERT_EQ(marquetry(folder, {"remesh", "a.ply", "b.ply", "-o", "o.obj", "--paint"}).status, 0);
  const Model after = read_model(folder / "o.obj");
  std::set<float> reds;
  for (int v = 0; v < after.mesh.vertex_count(); ++v)
    reds.insert(std::round(100 * after.colors.values[3 * std::size_t(v)]));
  EXPECT_EQ(reds, (std::set<float>{72, 93}));
}

/// A square with its picture, all of one colour, and texture coordinates that are x and y; dented
/// in one place by `depth`.
void write_sheet(const Folder& folder, const std::string& name, int squares, double depth,
                 const std::array<float, 3>& colour) {
  Model model;
  model.path = folder / (name + ".obj");
  model.mesh = fixtures::flat_square(squares);
  model.mesh.uvs.clear();
  for (const Vector3& p : model.mesh.positions) model.mesh.uvs.emplace_back(p.x(), p.y());
  model.mesh.corner_uvs = model.mesh.triangles;
  for (Vector3& p : model.mesh.positions)
    p.z() -= depth * std::exp(-60 * (p - Vector3(0.6, 0.6, 0)).squaredNorm());
  Texture texture;
  texture.name = std::filesystem::path(name).filename().string() + ".png";
  texture.pixels = Image<float>(4, 4, 3);
  for (int i = 0; i < 16; ++i) std::ranges::copy(colour, texture.pixels.pixel(i % 4, i / 4).begin());
  model.textures = {texture};
  write_model(model.path, model);
}

TEST(Remesh, CarriesTheTexturesOfBoth) {
  const Folder folder;
  std::filesystem::create_directory(folder / "out");
  write_sheet(folder, "red", 24, 0, {1, 0, 0});
  write_sheet(folder, "blue", 40, 0.3, {0, 0, 1});
  for (const std::string output : {"out/o.obj", "out/o.ply", "out/o.glb"}) {
    ASSERT_EQ(marquetry(folder, {"remesh", "red.obj", "blue.obj", "-o", output}).status, 0);
    const Model after = read_model(folder / output);
    ASSERT_EQ(after.textures.size(), 2U) << output;
    int red = 0, blue = 0;
    for (int t = 0; t < after.mesh.triangle_count(); ++t) {
      ASSERT_TRUE(after.mesh.textured(t)) << output;
      const Image<float>& picture = after.textures[after.mesh.texture(t)].pixels;
      (picture(0, 0, 0) > 0.5F ? red : blue)++;
      double deepest = 0;
      for (int k = 0; k < 3; ++k) {
        deepest = std::min(deepest, after.mesh.position(t, k).z());
        // Exact but between the two, where corners are those of a triangle nearby.
        EXPECT_LT((after.mesh.uv(t, k) - after.mesh.position(t, k).head<2>()).norm(), 0.05);
      }
      if (deepest < -0.1) {
        EXPECT_GT(picture(0, 0, 2), 0.5F) << output;
      }
    }
    EXPECT_GT(red, 300) << output;
    EXPECT_GT(blue, 300) << output;
  }
}

TEST(Remesh, GivesPicturesOfOneNameOthers) {
  const Folder folder;
  for (const std::string sub : {"a", "b", "out"}) std::filesystem::create_directory(folder / sub);
  write_sheet(folder, "a/sheet", 24, 0, {1, 0, 0});
  write_sheet(folder, "b/sheet", 40, 0.3, {0, 0, 1});
  ASSERT_EQ(
      marquetry(folder, {"remesh", "a/sheet.obj", "b/sheet.obj", "-o", "out/o.obj"}).status, 0);
  const Model after = read_model(folder / "out/o.obj");
  ASSERT_EQ(after.textures.size(), 2U);
  EXPECT_NE(after.textures[0].pixels.pixel(0, 0)[0], after.textures[1].pixels.pixel(0, 0)[0]);
}

TEST(Remesh, LeavesOutColoursAndTexturesThatDoNotFit) {
  const Folder folder;
  write_ball(folder, "a.ply", 3, 0, 0.25F);
  write_strip(folder);
  const Result result = marquetry(folder, {"remesh", "strip.obj", "a.ply", "-o", "o.ply"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("a.ply: has no texture coordinates"));
  EXPECT_THAT(result.error, HasSubstr("colours at vertices are left out"));
  EXPECT_EQ(read_model(folder / "o.ply").mesh.triangle_count(),
            read_model(folder / "a.ply").mesh.triangle_count());
}

/// The same model with triangles turned over.
void write_turned(const Folder& folder, const std::string& from, const std::string& to,
                  int every = 1) {
  Model model = read_model(folder / from);
  for (std::size_t t = 0; t < model.mesh.triangles.size(); t += std::size_t(every))
    std::swap(model.mesh.triangles[t][1], model.mesh.triangles[t][2]);
  model.document.reset();
  write_model(folder / to, model);
}

TEST(Remesh, TurnsBackATargetThatFacesTheWrongWay) {
  const Folder folder;
  write_ball(folder, "a.ply", 4, 0, 0.25F);
  write_ball(folder, "b.ply", 4, 0.5, 0.75F);
  write_turned(folder, "b.ply", "inside_out.ply");
  write_turned(folder, "b.ply", "scattered.ply", 7);
  write_turned(folder, "a.ply", "hollow.ply");
  const auto remeshed = [&](const std::string& from, const std::string& to, const std::string& o) {
    const Result result = marquetry(folder, {"remesh", from, to, "-o", o, "--json"});
    EXPECT_EQ(result.status, 0) << result.error;
    return result.json();
  };
  EXPECT_TRUE(remeshed("a.ply", "b.ply", "o.ply")["defects"].empty());
  for (const auto& [target, kind] :
       {std::pair{"inside_out.ply", "inside_out_triangles"}, {"scattered.ply", "turned_triangles"}}) {
    const nlohmann::json report = remeshed("a.ply", target, std::string("of_") + target);
    EXPECT_EQ(report["defects"][0]["kind"], kind);
    EXPECT_EQ(file_bytes(folder / (std::string("of_") + target)), file_bytes(folder / "o.ply"));
  }
  // Two that are both inside out face alike, and what faces inward stays.
  const nlohmann::json both = remeshed("hollow.ply", "inside_out.ply", "both.ply");
  EXPECT_TRUE(both["defects"].empty());
  EXPECT_GT(both["result"]["triangles_kept"]["fraction"], 0.5);
}

TEST(Remesh, RefusesWhatItCannotWorkWithAndWritesNothing) {
  const Folder folder;
  write_ball(folder, "a.ply", 3, 0, 0.25F);
  write_turned(folder, "a.ply", "b.ply");
  EXPECT_THAT(refusal(folder, {"remesh", "b.ply", "a.ply", "-o", "o.ply"}, "o.ply"),
              HasSubstr("turned inside out"));
  EXPECT_THAT(refusal(folder, {"remesh", "a.ply", "none.ply", "-o", "o.ply"}, "o.ply"),
              HasSubstr("none.ply"));
  EXPECT_THAT(refusal(folder, {"remesh", "a.ply", "a.ply", "-o", "o.png"}, "o.png"),
              HasSubstr("wanted a model"));
  EXPECT_THAT(refusal(folder, {"remesh", "a.ply", "a.ply", "-o", "o.ply", "-t", "8tx"}, "o.ply"),
              HasSubstr("found '8tx', wanted a length such as 0.02 (model units) or 1%"));
  write_bytes(folder / "points.ply",
              "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
              "property float z\nend_header\n0 0 0\n");
  EXPECT_THAT(refusal(folder, {"remesh", "a.ply", "points.ply", "-o", "o.ply"}, "o.ply"),
              HasSubstr("no faces"));
  Mesh flat;
  flat.positions.assign(3, Vector3(1, 2, 3));
  flat.triangles = {{0, 1, 2}};
  Model no_area;
  no_area.mesh = flat;
  write_model(folder / "flat.ply", no_area);
  for (const bool is_target : {true, false})
    EXPECT_THAT(refusal(folder,
                        {"remesh", is_target ? "a.ply" : "flat.ply",
                         is_target ? "flat.ply" : "a.ply", "-o", "o.ply"},
                        "o.ply"),
                HasSubstr("flat.ply: none of its triangles has an area"));
  write_ball(folder, "fine.ply", 4, 0, 0.25F);
  EXPECT_THAT(
      refusal(folder, {"remesh", "a.ply", "a.ply", "--reference", "fine.ply", "-o", "o.ply"},
              "o.ply"),
      HasSubstr("has other triangles"));
}

}  // namespace
}  // namespace mq::test
