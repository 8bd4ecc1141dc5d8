// marquetry remesh, run as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

TEST(Remesh, LeavesOutColoursAndTexturesThatDoNotFit) {
  const Folder folder;
  write_ball(folder, "a.ply", 3, 0, 0.25F);
  write_strip(folder);
  const Result result = marquetry(folder, {"remesh", "strip.obj", "a.ply", "-o", "o.ply"});
  ASSERT_EQ(result.status, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("texture coordinates and pictures are left out"));
  EXPECT_THAT(result.error, HasSubstr("colours at vertices are left out"));
  EXPECT_EQ(read_model(folder / "o.ply").mesh.triangle_count(),
            read_model(folder / "a.ply").mesh.triangle_count());
}

TEST(Remesh, RefusesWhatItCannotWorkWithAndWritesNothing) {
  const Folder folder;
  write_ball(folder, "a.ply", 3, 0, 0.25F);
  Model inside_out = read_model(folder / "a.ply");
  for (Triangle& t : inside_out.mesh.triangles) std::swap(t[0], t[1]);
  inside_out.document.reset();
  write_model(folder / "b.ply", inside_out);
  EXPECT_THAT(refusal(folder, {"remesh", "a.ply", "b.ply", "-o", "o.ply"}, "o.ply"),
              HasSubstr("turned inside out"));
  EXPECT_THAT(refusal(folder, {"remesh", "a.ply", "none.ply", "-o", "o.ply"}, "o.ply"),
              HasSubstr("none.ply"));
  EXPECT_THAT(refusal(folder, {"remesh", "a.ply", "a.ply", "-o", "o.png"}, "o.png"),
              HasSubstr("wanted a model"));
  EXPECT_THAT(refusal(folder, {"remesh", "a.ply", "a.ply", "-o", "o.ply", "-t", "8tx"}, "o.ply"),
              HasSubstr("texels are no measure"));
  write_bytes(folder / "points.ply",
              "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
              "property float z\nend_header\n0 0 0\n");
  EXPECT_THAT(refusal(folder, {"remesh", "a.ply", "points.ply", "-o", "o.ply"}, "o.ply"),
              HasSubstr("no faces"));
  write_ball(folder, "fine.ply", 4, 0, 0.25F);
  EXPECT_THAT(
      refusal(folder, {"remesh", "a.ply", "a.ply", "--reference", "fine.ply", "-o", "o.ply"},
              "o.ply"),
      HasSubstr("has other triangles"));
}

}  // namespace
}  // namespace mq::test
