// What shock does is a few calls of the library: the same calls give the same files, byte for byte.

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "model/program_files.h"
#include "mq/filter/image_shock.h"
#include "mq/model/moved_vertices.h"
#include "mq/model/model_shock.h"
#include "mq/model/outputs.h"

namespace mq {
namespace {

using test::Folder;

TEST(VerbShock, SharpensPicturesByPaths) {
  for (const ColourSpace space : {ColourSpace::stored, ColourSpace::linear}) {
    const Folder folder;
    write_image(folder / "a.png", test::busy_picture(40, 30));
    run(folder, {"shock", "a.png", "-o", "out.png", "--smooth", "1tx", "--space",
                 space == ColourSpace::stored ? "stored" : "linear"});
    ShockRequest request;
    request.smooth = {1, Length::Unit::texels};
    Texture texture = read_texture(folder / "a.png");
    const ValueSpace values{.space = space};
    const Image<float> before = decoded(texture, values);
    ImageShockOptions options;
    options.weights = request.weights({.area = 40 * 30, .texel_spacing = 1});
    options.time = request.time;
    EXPECT_GT(put_changed(before, shock(before, options).image, values, texture), 0);
    write_texture(folder / "ours.png", texture);
    EXPECT_EQ(bytes(folder, "ours.png"), bytes(folder, "out.png"));
  }
}

TEST(VerbShock, SharpensTextures) {
  const Folder folder;
  test::write_strip(folder);
  run(folder, {"shock", "strip.obj", "-o", "out.png"});
  run(folder, {"shock", "strip.obj", "-o", "longer.png", "--solver",
               "multigrid", "-t", "5"});
  Messages messages;
  const TexturedModel model = load_textured_model(folder / "strip.obj", {}, messages);
  const TextureSignal signal(model, {}, messages);
  const Signal before = signal.values();
  const auto ours = [&](const ShockRequest& request) {
    Model sharpened = model.model;
    const ShockedModel found = shock_signal(model, signal, before, request);
    signal.put(before, found.signal, sharpened);
    Outputs(folder / "ours.png", model.model, Outputs::Kind::pictures).write(sharpened, {});
    return bytes(folder, "ours.png");
  };
  EXPECT_TRUE(ours({}) == bytes(folder, "out.png"));
  ShockRequest longer;
  longer.solver.kind = ShockSolverChoice::Kind::multigrid;
  longer.time.value = 5;
  EXPECT_TRUE(ours(longer) == bytes(folder, "longer.png"));
}

TEST(VerbShock, SharpensColoursAtVertices) {
  const Folder folder;
  test::write_bytes(folder / "fan.ply", test::coloured_ply);
  run(folder, {"shock", "fan.ply", "-o", "out.ply", "-t", "10"});
  Messages messages;
  TexturedModel model = load_textured_model(folder / "fan.ply", {}, messages);
  const VertexColourSignal signal(model);
  const Signal before = signal.values();
  ShockRequest request;
  request.time.value = 10;
  const ShockedModel found = shock_signal(model, signal, before, request);
  signal.put(before, found.signal, model.model);
  write_model(folder / "ours.ply", model.model);
  EXPECT_TRUE(bytes(folder, "ours.ply") == bytes(folder, "out.ply"));
}

/// A bent sheet, whose shape there is something to sharpen of.
std::string bent_ply() {
  std::string vertices, faces;
  const int n = 8;
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= n; ++x)
      vertices += std::to_string(x) + " " + std::to_string(y) + " " +
                  std::to_string(0.3 * std::abs(x - 4) + 0.05 * ((x * 7 + y * 3) % 5)) + "\n";
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const int v = y * (n + 1) + x;
      for (const auto& [a, b, c] : {std::tuple{v, v + 1, v + n + 2}, {v, v + n + 2, v + n + 1}})
        faces += "3 " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + "\n";
    }
  return "ply\nformat ascii 1.0\nelement vertex " + std::to_string((n + 1) * (n + 1)) +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
         std::to_string(2 * n * n) + "\nproperty list uchar int vertex_indices\nend_header\n" +
         vertices + faces;
}

TEST(VerbShock, SharpensShapes) {
  const Folder folder;
  test::write_bytes(folder / "sheet.ply", bent_ply());
  run(folder, {"shock", "sheet.ply", "--geometry", "-o", "out.ply", "--smooth-normals", "4%",
               "--fit-steps", "2"});
  Messages messages;
  TexturedModel model = load_textured_model(folder / "sheet.ply",
                                            {.missing = MissingPictures::unneeded}, messages);
  ShockRequest request;
  request.time.value = 1;
  request.smooth_normals = {4, Length::Unit::percent};
  request.fit_steps = 2;
  const SharpenedShape shape = shock_shape(model, request);
  EXPECT_FALSE(move_vertices(shape.positions, model));
  write_model(folder / "ours.ply", model.model);
  EXPECT_EQ(bytes(folder, "ours.ply"), bytes(folder, "out.ply"));
}

TEST(ShapeChange, IsOfAreaAndOfVolumeWhereThereIsOne) {
  const Folder folder;
  test::write_bytes(folder / "sheet.ply", bent_ply());
  Messages messages;
  TexturedModel model = load_textured_model(folder / "sheet.ply",
                                            {.missing = MissingPictures::unneeded}, messages);
  std::vector<Vector3> twice = model.surface.mesh.positions;
  for (Vector3& p : twice) p *= 2;
  const ShapeChange change = shape_change(model.surface, twice);
  EXPECT_NEAR(*change.area.change(), 3, 1e-9);
  EXPECT_FALSE(change.volume);
  EXPECT_GT(change.largest_moved, change.rms_moved);
  const std::vector<Vector3> stored = model.model.mesh.positions;
  move_vertices(model.surface.mesh.positions, model);
  EXPECT_EQ(model.model.mesh.positions, stored);
}

TEST(ValueSpace, KnowsTheStepsOfWholeNumbers) {
  Texture texture;
  texture.format.depth = Depth::u8;
  EXPECT_EQ(value_step(texture, {}), 1.0 / 255);
  EXPECT_EQ(value_step(texture, {.space = ColourSpace::log}), 0);
  texture.format.depth = Depth::f32;
  EXPECT_EQ(value_step(texture, {}), 0);
}

/// Of P = x² + 2y at the texels of a flat strip, and at its vertices.
TEST(DownhillField, IsMinusTheGradientOfThePotential) {
  const Folder folder;
  test::write_strip(folder);
  Messages messages;
  const TexturedModel model = load_textured_model(folder / "strip.obj", {}, messages);
  const auto potential = [](const Vector3& p) { return p.x() * p.x() + 2 * p.y(); };
  const auto expect = [&](const TangentField& field, double tolerance) {
    for (int t = 0; t < model.surface.triangle_count(); ++t) {
      const Mesh& mesh = model.surface.mesh;
      const Vector3 middle = (mesh.position(t, 0) + mesh.position(t, 1) + mesh.position(t, 2)) / 3;
      EXPECT_LT((field[std::size_t(t)] - Vector3(-2 * middle.x(), -2, 0)).norm(), tolerance) << t;
    }
  };
  const TextureSignal texels(model, {}, messages);
  Vector P(texels.space().size());
  const auto& places = texels.space().texels().positions;
  for (Eigen::Index i = 0; i < P.size(); ++i)
    P[i] = potential(Vector3(places[std::size_t(i)][0], places[std::size_t(i)][1], places[std::size_t(i)][2]));
  const ModelField fine = downhill_field(model, texels, P);
  EXPECT_EQ(fine.texels.size(), 2 * P.size());
  expect(fine.field, 0.1);
  const VertexColourSignal vertices(model);
  Vector at_vertices(vertices.space().size());
  for (Eigen::Index v = 0; v < at_vertices.size(); ++v)
    at_vertices[v] = potential(model.surface.mesh.positions[std::size_t(v)]);
  const ModelField coarse = downhill_field(model, vertices, at_vertices);
  EXPECT_EQ(coarse.texels.size(), 0);
  // The gradient of the linear interpolant, of which no triangle can say more.
  const TangentField gradient = gradient_field(model.surface, at_vertices);
  for (std::size_t t = 0; t < gradient.size(); ++t) EXPECT_EQ(coarse.field[t], -gradient[t]);
}

}  // namespace
}  // namespace mq
